import { App } from "../../server/front/page/src/app";
import { made, MadeSource } from "./made_source";

Object.assign(window, { made });
new App((token) => new MadeSource(token));
