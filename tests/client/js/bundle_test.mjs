// The package as others get it: packed, and bundled for a browser.
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import * as fs from "node:fs";
import { createRequire } from "node:module";
import * as os from "node:os";
import * as path from "node:path";
import { test } from "node:test";

const folder = process.env.HAPTICD_JS;
const esbuild = createRequire(folder + "/")("esbuild");

/** An unpacked package beside its dependencies, as npm lays them. */
function installed(t) {
  const root = fs.mkdtempSync(path.join(os.tmpdir(), "haptic-js-"));
  t.after(() => fs.rmSync(root, { recursive: true }));
  const modules = path.join(root, "node_modules");
  fs.mkdirSync(path.join(modules, "hapticd"), { recursive: true });
  const [{ filename }] = JSON.parse(
    execFileSync("npm", ["pack", "--json", "--pack-destination", root], { cwd: folder }));
  execFileSync("tar", ["xzf", path.join(root, filename), "--strip-components=1",
                       "-C", path.join(modules, "hapticd")]);
  for (const name of ["@bufbuild", "@connectrpc", "ws"]) {
    fs.symlinkSync(path.join(folder, "node_modules", name), path.join(modules, name));
  }
  return root;
}

test("the packed package is whole", (t) => {
  const root = installed(t);
  const packed = path.join(root, "node_modules", "hapticd");
  assert.deepEqual(fs.readdirSync(packed).sort(), ["LICENSE", "dist", "package.json"]);
  const program = "import { Connection } from 'hapticd'; console.log(typeof Connection)";
  const said = execFileSync(process.execPath, ["--input-type=module", "-e", program],
                            { cwd: root, encoding: "utf8" });
  assert.equal(said, "function\n");
});

test("a browser's bundle has no Node", async (t) => {
  const { metafile } = await esbuild.build({
    stdin: { contents: "export * from 'hapticd'", resolveDir: installed(t) },
    bundle: true, format: "esm", platform: "browser", write: false, metafile: true,
  });
  const modules = Object.keys(metafile.inputs).map((name) => path.basename(name));
  assert.ok(modules.includes("transport_browser.js"));
  assert.deepEqual(modules.filter((name) => name.endsWith("_node.js") || name === "websocket.js"),
                   []);
});
