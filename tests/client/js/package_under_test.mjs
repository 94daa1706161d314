// The modules of the package that $HAPTICD_JS names, built by the target haptic_js.
import { pathToFileURL } from "node:url";

const dist = new URL("dist/", pathToFileURL(process.env.HAPTICD_JS + "/"));

/** One module of the package, for what index.js does not export. */
export const part = (name) => import(new URL(name, dist).href);
