// A hapticd with TLS: the server's certificate is checked, and one of the client's is enough.
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import * as fs from "node:fs";
import * as os from "node:os";
import * as path from "node:path";
import { test } from "node:test";
import { Hapticd, hold, open } from "./hapticd_process.mjs";
import { part } from "./package_under_test.mjs";

const { Connection } = await part("index.js");

/** A folder with ca, server and client, .pem and .key each. */
function certificates(t) {
  const folder = fs.mkdtempSync(path.join(os.tmpdir(), "haptic-js-"));
  t.after(() => fs.rmSync(folder, { recursive: true }));
  const openssl = (words) =>
    execFileSync("openssl", words.split(" "), { cwd: folder, stdio: "pipe" });
  const key = (name) =>
    `-newkey ec -pkeyopt ec_paramgen_curve:prime256v1 -nodes -keyout ${name}.key`;
  openssl(`req -x509 ${key("ca")} -out ca.pem -subj /CN=issuer -days 2`);
  for (const [name, also] of [["server", "IP:127.0.0.1"], ["client", "DNS:client"]]) {
    openssl(`req ${key(name)} -out ${name}.csr -subj /CN=${name}`);
    fs.writeFileSync(path.join(folder, `${name}.ext`), `subjectAltName=${also}\n`);
    openssl(`x509 -req -in ${name}.csr -CA ca.pem -CAkey ca.key -CAcreateserial -days 2 ` +
      `-extfile ${name}.ext -out ${name}.pem`);
  }
  return folder;
}

test("certificates stand for tokens", async (t) => {
  const folder = certificates(t);
  const read = (name) => fs.readFileSync(path.join(folder, name), "utf8");
  const server = await Hapticd.start(t, { settings: [
    `server.tls={certificate: "${folder}/server.pem" key: "${folder}/server.key" ` +
    `client_ca: "${folder}/ca.pem"}`] });
  const url = server.url.replace("http:", "https:");
  const tls = { ca: read("ca.pem"), cert: read("client.pem"), key: read("client.key") };
  const session = await open(t, new Connection(url, { tls }));
  await hold(session, (state) => state.proxySeqUsed > 5n);
  const nameless = new Connection(url, { tls: { ca: tls.ca } });
  await assert.rejects(nameless.serverInfo(), { code: "unauthenticated" });
  await assert.rejects(nameless.open({ role: "observer" }), { code: "unauthenticated" });
  const trusting = new Connection(url);
  await assert.rejects(trusting.serverInfo(), { code: "unavailable", message: /certificate/ });
  await assert.rejects(trusting.open(), { code: "unavailable", message: /certificate/ });
});
