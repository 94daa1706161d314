// Help without a key: the card "This page needs a key".

import { at, say } from "../dom";

export class Access {
  private readonly card = at("access");
  private readonly field = at<HTMLInputElement>("token");

  /** `use`: a token was entered; rejects with words if it does not serve. */
  constructor(use: (token: string) => Promise<void>) {
    at("token-form").addEventListener("submit", (event) => {
      event.preventDefault();
      say(at("token-said"), "Trying it …");
      use(this.field.value).then(
        () => {
          this.field.value = "";
          say(at("token-said"), "");
          this.close();
        },
        (error: unknown) => say(at("token-said"), `It does not serve: ${String(error)}`),
      );
    });
    at("access-close").addEventListener("click", () => this.close());
    at("other-key").addEventListener("click", () => this.open(true));
  }

  /** `looks`: the page works as it is, for looking. */
  open(looks: boolean): void {
    say(
      at("access-title"),
      looks ? "A key that allows more" : "This page needs a key",
    );
    at("access-close").hidden = !looks;
    if (!this.card.hidden) return;
    this.card.hidden = false;
    if (looks) {
      this.card.scrollIntoView({ block: "center" });
      this.field.focus();
    }
  }

  close(): void {
    this.card.hidden = true;
  }
}
