// Short ways to the document. lit-html makes what changes, and touches only what differs.

import { html, render, type TemplateResult } from "lit-html";

export { html, render };

/** The element of index.html with this id. */
export function at<T extends HTMLElement = HTMLElement>(id: string): T {
  const found = document.getElementById(id);
  if (!found) throw new Error(`index.html has no #${id}`);
  return found as T;
}

/** A colour of the page's theme as it is now: "rgb(0, 90, 140)" of "--link". */
export function colour(name: string): string {
  const probe = document.createElement("span");
  probe.style.color = `var(${name})`;
  document.body.append(probe);
  const { color } = getComputedStyle(probe);
  probe.remove();
  return color;
}

/** Changes the text only if it differs: a screen reader and a selection stay undisturbed. */
export function say(element: Element, text: string): void {
  if (element.textContent !== text) element.textContent = text;
}

/** The children of a `dl`. */
export function facts(list: readonly [string, string][]): TemplateResult[] {
  return list.map(([name, value]) => html`<dt>${name}</dt><dd>${value}</dd>`);
}
