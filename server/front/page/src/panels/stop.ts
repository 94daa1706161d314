// The emergency stop: the button, Esc and Shift+S. A stop that got no answer is sent again until it
// has one.

import { ClientError } from "hapticd";
import { at, say } from "../dom";
import type { Source } from "../live_source";

const AGAIN_MS = 200;
const TRIES = 50;

function pause(ms: number): Promise<void> {
  return new Promise((done) => setTimeout(done, ms));
}

export class Stop {
  private readonly said = at("stop-said");
  private sending = false;
  private saidAt = 0;

  constructor(private readonly source: () => Pick<Source, "stop">) {
    const button = at("stop");
    // A press counts when it begins, as on a real stop button. A click without a press is the
    // keyboard's, or of an assistive technology.
    button.addEventListener("pointerdown", (event) => {
      if (event.button === 0) void this.press();
    });
    button.addEventListener("click", (event) => {
      if (event.detail === 0) void this.press();
    });
    document.addEventListener("keydown", (event) => {
      const typing = event.target instanceof HTMLInputElement && event.target.type === "password";
      const shiftS = event.shiftKey && event.code === "KeyS" && !typing;
      if ((event.key !== "Escape" && !shiftS) || event.repeat) return;
      event.preventDefault();
      void this.press();
    });
  }

  /** No device is stopped any more: what was said is old. */
  over(): void {
    if (!this.sending && performance.now() - this.saidAt > 2000) this.tell("", false);
  }

  private async press(): Promise<void> {
    if (this.sending) return;
    this.sending = true;
    const begin = performance.now();
    for (let tries = 0; tries < TRIES; tries++) {
      try {
        const stopped = await this.source().stop();
        const took = Math.round(performance.now() - begin);
        this.tell(`Stopped ${stopped.join(", ")} in ${took} ms.`, false);
        break;
      } catch (error) {
        const refused = error instanceof ClientError && error.code === "unauthenticated";
        this.tell(
          refused
            ? "Not stopped: this page has no key. Switch the device off by its own switch."
            : "Not stopped yet: the server does not answer. Trying again. Switch the device off " +
                "by its own switch.",
          true,
        );
        if (refused) break;
        await pause(AGAIN_MS);
      }
    }
    this.sending = false;
  }

  private tell(text: string, bad: boolean): void {
    say(this.said, text);
    this.said.classList.toggle("bad", bad);
    this.saidAt = performance.now();
  }
}
