// Serves the files of a folder under the policy of hapticd's web server.
import * as fs from "node:fs";
import * as http from "node:http";
import * as path from "node:path";

const TYPES = { ".html": "text/html", ".js": "text/javascript", ".css": "text/css",
                ".svg": "image/svg+xml" };
const POLICY = "default-src 'self'; connect-src 'self' ws: wss:; img-src 'self' data:; " +
  "style-src 'self' 'unsafe-inline'; script-src 'self' 'wasm-unsafe-eval'";

/** Its address; it ends with the test `t`. */
export async function serve(t, folder) {
  const server = http.createServer(({ url }, response) => {
    const name = new URL(url, "http://localhost").pathname;
    const file = path.join(folder, name === "/" ? "index.html" : path.basename(name));
    if (!fs.existsSync(file)) return response.writeHead(404).end();
    response.writeHead(200, { "Content-Type": TYPES[path.extname(file)],
                              "Content-Security-Policy": POLICY });
    response.end(fs.readFileSync(file));
  });
  await new Promise((resolve) => server.listen(0, "127.0.0.1", resolve));
  t.after(() => server.close());
  return `http://127.0.0.1:${server.address().port}/`;
}
