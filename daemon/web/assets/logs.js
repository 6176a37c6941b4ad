// The log of the daemon and changes in it, as they happen, with filters.

import { get } from "./api.js";
import { el, link, name, pageOf, put } from "./dom.js";
import { timeOfDay } from "./units.js";

/** Rows that are kept; the oldest go. */
const MOST = 1000;
const LEVELS = ["error", "warn", "info", "debug", "trace"];

export async function logs(page, context) {
  const query = new URLSearchParams(location.search);
  const { components } = await get("/components");
  const level = pick("level", "Level", [["", "all"], ...LEVELS.map((one) => [one, one])], query.get("level") ?? "");
  const about = pick("component", "Component", [["", "all"], ...components.map((one) => [one.name, one.name])], query.get("component") ?? "");
  const kind = pick("show", "Show", [["", "log and events"], ["log", "log"], ["events", "events"]], query.get("show") ?? "");
  const words = el("input", { id: "words", type: "search", value: query.get("words") ?? "", autocomplete: "off" });
  const paused = el("button", { type: "button", "aria-pressed": "false" }, "Pause");
  const clear = el("button", { type: "button" }, "Clear");
  const count = el("span", { class: "soft", role: "status" });
  const list = el("ol", { class: "log", id: "log", tabindex: 0, "aria-label": "Log and events" });
  put(page, el("h1", {}, "Logs and events"),
    el("form", { class: "filters", onsubmit: (event) => event.preventDefault() },
      kind.node, level.node, about.node,
      el("div", { class: "field" }, el("label", { for: "words" }, "Words"), words), paused, clear, count),
    list);

  const held = [];
  const wanted = (text) => words.value.toLowerCase().split(/\s+/).every((word) => text.includes(word));

  function add(row, text) {
    row.dataset.text = text.toLowerCase();
    row.hidden = !wanted(row.dataset.text);
    if (paused.getAttribute("aria-pressed") === "true") {
      held.push(row);
      if (held.length > MOST) held.shift();
      put(count, `${held.length} wait`);
      return;
    }
    const follows = list.scrollTop + list.clientHeight >= list.scrollHeight - 40;
    list.append(row);
    while (list.children.length > MOST) list.firstChild.remove();
    if (follows) list.scrollTop = list.scrollHeight;
  }

  const who = (component) => component && [link(pageOf(component), name(component)), " "];

  function hearLog(entry) {
    const { time, level: grade, component, message, origin } = entry;
    add(el("li", { class: grade, title: origin }, el("time", {}, timeOfDay(time)), " ",
      el("span", { class: "grade" }, grade), " ", who(component), el("bdi", { class: "message" }, message)),
    `${grade} ${component ?? ""} ${message}`);
  }

  function hearChange(change) {
    const { event, component, ...rest } = change;
    if (about.value && component !== about.value) return;
    const members = Object.entries(rest).map(([key, value]) => `${key} ${typeof value === "string" ? value : JSON.stringify(value)}`).join(", ");
    add(el("li", { class: change.exception ? "warn event" : "event" }, el("time", {}, timeOfDay(Date.now() / 1000)), " ",
      el("span", { class: "grade" }, "event"), " ", who(component),
      el("strong", {}, event.replaceAll("_", " ")), " ", el("bdi", { class: "message" }, members)),
    `event ${event} ${component ?? ""} ${members}`);
  }

  function watched() {
    const log = new URLSearchParams({ last: 300 });
    if (level.value) log.set("level", level.value);
    if (about.value) log.set("component", about.value);
    const all = [];
    if (kind.value !== "events") all.push({ path: `/logs/stream?${log}`, hear: hearLog });
    if (kind.value !== "log") all.push({ path: "/events", hear: hearChange });
    return all;
  }

  function keep() {
    const now = { show: kind.value, level: level.value, component: about.value, words: words.value };
    const set = new URLSearchParams(Object.entries(now).filter(([, value]) => value));
    history.replaceState(null, "", set.size > 0 ? `/logs?${set}` : "/logs");
  }

  for (const one of [kind, level, about]) {
    one.input.addEventListener("change", () => {
      keep();
      list.replaceChildren();
      live.watch(watched());
    });
  }
  words.addEventListener("input", () => {
    keep();
    for (const row of [...list.children, ...held]) row.hidden = !wanted(row.dataset.text);
  });
  clear.addEventListener("click", () => list.replaceChildren());
  paused.addEventListener("click", () => {
    const now = paused.getAttribute("aria-pressed") !== "true";
    paused.setAttribute("aria-pressed", String(now));
    put(paused, now ? "Go on" : "Pause");
    put(count);
    if (!now) held.splice(0).forEach((row) => add(row, row.dataset.text));
  });
  const live = context.watch(watched(), 1);
}

function pick(id, label, options, value) {
  const input = el("select", { id }, options.map(([key, text]) => el("option", { value: key, selected: key === value }, text)));
  return { input, get value() { return input.value; }, node: el("div", { class: "field" }, el("label", { for: id }, label), input) };
}
