// Short ways to the document.

type Child = Node | string;

/** A new element: `h("p", { class: "note" }, "text")`. */
export function h<K extends keyof HTMLElementTagNameMap>(
  tag: K,
  attributes: Record<string, string> = {},
  ...children: Child[]
): HTMLElementTagNameMap[K] {
  const made = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
  made.append(...children);
  return made;
}

/** The element of index.html with this id. */
export function at<T extends HTMLElement = HTMLElement>(id: string): T {
  const found = document.getElementById(id);
  if (!found) throw new Error(`index.html has no #${id}`);
  return found as T;
}

/** A colour of the page's theme as it is now: "rgb(0, 90, 140)" of "--link". */
export function colour(name: string): string {
  const probe = h("span", { style: `color: var(${name})` });
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
export function facts(list: readonly [string, string][]): Child[] {
  return list.flatMap(([name, value]) => [h("dt", {}, name), h("dd", {}, value)]);
}

/** Makes the children again only if `told`, which they tell, differs from the last time. */
export function fill(element: HTMLElement, told: unknown, make: () => Child[]): void {
  const key = JSON.stringify(told);
  if (element.dataset.key === key) return;
  element.dataset.key = key;
  element.replaceChildren(...make());
}
