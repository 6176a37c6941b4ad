// The rules that a component is supervised by, and whether they were broken.

import { el, heads, put } from "./dom.js";
import { count, duration, timeOfDay } from "./units.js";

/** A section with the rules; it is hidden while there are none. */
export function rules() {
  const body = el("tbody");
  const node = el("section", { id: "rules", hidden: true }, el("h2", {}, "Supervision"),
    el("div", { class: "wide" }, el("table", { class: "cards" },
      heads(["Rule", "Kind", "#Broken", "Last", "#Value", "#Bound", "Reaction"]), body)));

  function take(all) {
    node.hidden = all.length === 0;
    put(body, all.map((rule) => {
      const { last } = rule;
      const broken = rule.violations > 0;
      const value = (number) => number === undefined ? "–" : rule.kind === "alive" ? count(number) : duration(number);
      const cell = (label, text, kind) => el("td", { "data-label": label, class: kind }, text);
      return el("tr", {}, el("th", { scope: "row" }, rule.rule, last && el("div", { class: "soft" }, last.what)),
        cell("Kind", rule.kind), cell("Broken", broken ? count(rule.violations) : "never", broken ? "number warn" : "number"),
        cell("Last", last ? timeOfDay(last.unix_ms / 1000) : "–"),
        cell("Value", value(last?.value), "number"), cell("Bound", value(last?.bound), "number"),
        cell("Reaction", rule.reactions.join(", ")));
    }));
  }
  return { node, take };
}
