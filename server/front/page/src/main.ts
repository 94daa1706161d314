import { App } from "./app";
import { LiveSource } from "./live_source";

new App((token) => new LiveSource(token));
