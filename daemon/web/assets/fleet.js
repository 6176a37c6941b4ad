// Other daemons that this one sees on middlewares.

import { el, heads, name, put } from "./dom.js";
import { timeOfDay } from "./units.js";

/** Names that may stand in a command as they are. */
const PLAIN = /^[A-Za-z0-9][A-Za-z0-9._-]*$/;

/** `{ node, take(daemons) }`; a daemon that was seen and is no more stays, as one that is gone. */
export function fleet() {
  const node = el("section", { id: "fleet", hidden: true });
  const seen = new Map();

  function take({ own, daemons }) {
    const now = new Set();
    for (const { name: daemon, backend } of daemons) {
      const key = JSON.stringify([daemon, backend]);
      now.add(key);
      seen.set(key, { daemon, backend, gone: null });
    }
    for (const [key, one] of seen) {
      if (!now.has(key) && one.gone === null) one.gone = Date.now() / 1000;
    }
    const rows = [...seen.values()].sort((one, other) => one.daemon.localeCompare(other.daemon));
    node.hidden = rows.length === 0;
    put(node, el("h2", {}, "Fleet"),
      el("p", { class: "soft" }, "Daemons that this one sees. A name is not proved: to command one takes a token of its own file."),
      el("div", { class: "wide" }, el("table", { class: "cards" },
        heads(["Daemon", "State", "Seen on", "Open its console"]),
        el("tbody", {}, rows.map((one) => row(one, own))))));
  }

  function row({ daemon, backend, gone }, own) {
    const mine = daemon === own;
    const state = gone !== null ? el("span", { class: "pill bad" }, `gone since ${timeOfDay(gone).slice(0, 8)}`)
      : el("span", { class: "pill good" }, mine ? "this daemon" : "visible");
    const way = mine ? "here" : PLAIN.test(daemon)
      ? el("code", {}, `genomctl --host ${backend}:${daemon} web`) : "its name cannot be typed as it is";
    return el("tr", { "data-daemon": daemon }, el("th", { scope: "row" }, name(daemon)),
      el("td", { "data-label": "State" }, state), el("td", { "data-label": "Seen on" }, name(backend)),
      el("td", { "data-label": "Open its console" }, way));
  }

  return { node, take };
}
