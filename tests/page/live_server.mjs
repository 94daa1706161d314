// A hapticd with its page, and a program that controls its device.
import { execFileSync } from "node:child_process";
import * as path from "node:path";
import { Hapticd, engaged, eventually, hold, open } from "../client/js/hapticd_process.mjs";

/** The setting that gives a server a certificate that no browser trusts: its own issuer's. */
export function selfSigned(folder) {
  const [certificate, key] = ["pem", "key"].map((end) => path.join(folder, `server.${end}`));
  execFileSync("openssl", ["req", "-x509", "-newkey", "ec", "-pkeyopt",
    "ec_paramgen_curve:prime256v1", "-nodes", "-keyout", key, "-out", certificate, "-days", "2",
    "-subj", "/CN=127.0.0.1", "-addext", "subjectAltName=IP:127.0.0.1"], { stdio: "pipe" });
  return `server.tls={certificate: "${certificate}" key: "${key}"}`;
}

/** `rights`: of the printed address, "observe" or "control". */
export function startHapticd(t, rights, options = {}) {
  return Hapticd.start(t, { ...options, settings: [`server.web.printed="${rights}"`,
                                                   ...(options.settings ?? [])] });
}

/** The printed address that was not used yet. */
export function printedAddress(server) {
  let seen = "";
  return eventually(() => {
    seen = [...server.log.matchAll(/page: (\S+)/g)].at(-1)?.[1] ?? "";
    if (seen === server.used) return "";
    server.used = seen;
    return seen;
  }, "hapticd prints an address");
}

/** Holds the device with force on until the test ends. */
export async function holdDevice(t, server) {
  const session = await open(t, server.connect("primary"),
                             { clientName: "simulation", reEngage: false });
  session.engageWhenReady();
  await hold(session, engaged);
  let over = false;
  t.after(() => (over = true));
  const going = hold(session, () => over).catch(() => undefined);
  t.after(() => going);
  return session;
}
