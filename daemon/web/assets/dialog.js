// Questions to the user.

import { told } from "./api.js";
import { el, put } from "./dom.js";

let last = 0;

/** Asks in a dialog; `act` may refuse, and the reason is shown there. Enter does it at once. */
export function ask(title, fields, verb, act, { danger } = {}) {
  last += 1;
  const id = `dialog-${last}`;
  const problem = el("p", { class: "error", role: "alert" });
  const go = el("button", { type: "submit", class: danger ? "danger" : "main", }, verb);
  const dialog = el("dialog", { "aria-labelledby": id },
    el("form", { method: "dialog" }, el("h2", { id }, title), fields, problem,
      el("div", { class: "row" }, go, el("button", { type: "button", onclick: () => dialog.close() }, "Cancel"))));
  const back = document.activeElement;
  dialog.querySelector("form").addEventListener("submit", async (event) => {
    event.preventDefault();
    put(problem);
    go.disabled = true;
    try {
      await act();
      dialog.close();
    } catch (error) {
      put(problem, told(error));
    }
    go.disabled = false;
  });
  dialog.addEventListener("close", () => {
    dialog.remove();
    if (back?.isConnected) back.focus({ preventScroll: true });
  });
  document.getElementById("page").append(dialog);
  // What has to be filled in comes first; else Enter answers.
  (dialog.querySelector("input[type=text]:required") ?? go).autofocus = true;
  dialog.showModal();
}

/** A field with one of `choices`, `[value, text]`. */
export function choose(id, label, choices, value, help) {
  const input = el("select", { id }, choices.map(([one, text]) => el("option", { value: one, selected: one === value }, text)));
  const node = el("div", { class: "field" }, el("label", { for: id }, label), input, help && el("span", { class: "help" }, help));
  return { node, input };
}
