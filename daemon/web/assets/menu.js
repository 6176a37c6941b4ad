// A menu beside a pointer or an element, worked with mouse, fingers and keys.

import { el, visible } from "./dom.js";

let open = null;

export function closeMenu() {
  open?.close();
}

/** `items`: `[text, act, { danger }]`, or a text alone, which is a heading. `back` gets the focus again. */
export function menu({ x, y }, label, items, back = document.activeElement) {
  closeMenu();
  const node = el("div", { class: "menu", role: "menu", "aria-label": visible(label), id: "menu" });
  const close = (again = true) => {
    if (open?.node !== node) return;
    open = null;
    node.remove();
    removeEventListener("pointerdown", outside, true);
    removeEventListener("keydown", escape, true);
    removeEventListener("blur", away);
    if (again && back?.isConnected) back.focus({ preventScroll: true });
  };
  const outside = (event) => node.contains(event.target) || close(false);
  const away = () => close(false);
  // Wherever the focus is: what follows a touch may have taken it.
  const escape = (event) => {
    if (event.key !== "Escape") return;
    close();
    event.preventDefault();
    event.stopPropagation();
  };
  for (const item of items.filter(Boolean)) {
    if (typeof item === "string") {
      node.append(el("div", { class: "menu-about", role: "presentation" }, item));
      continue;
    }
    const [text, act, { danger } = {}] = item;
    node.append(el("button", { type: "button", role: "menuitem", tabindex: -1, class: danger ? "danger" : undefined,
      onclick: () => { close(); act(); } }, text));
  }
  const all = [...node.querySelectorAll("button")];
  node.addEventListener("contextmenu", (event) => event.preventDefault());
  node.addEventListener("keydown", (event) => {
    const at = all.indexOf(document.activeElement);
    const to = { ArrowDown: at + 1, ArrowUp: at - 1 + all.length, Home: 0, End: all.length - 1 }[event.key];
    if (event.key === "Tab") close();
    else if (to !== undefined) all[to % all.length].focus();
    else return;
    event.preventDefault();
    event.stopPropagation();
  });
  document.body.append(node);
  const box = node.getBoundingClientRect();
  // Through the object model: the policy for contents allows no style in markup.
  node.style.left = `${Math.max(6, Math.min(x, innerWidth - box.width - 6))}px`;
  node.style.top = `${Math.max(6, Math.min(y, innerHeight - box.height - 6))}px`;
  open = { node, close };
  addEventListener("pointerdown", outside, true);
  addEventListener("keydown", escape, true);
  addEventListener("blur", away);
  all[0]?.focus({ preventScroll: true });
}
