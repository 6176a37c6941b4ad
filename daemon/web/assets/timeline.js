// The timeline: activities with their states, exceptions, missed periods and connections on a time
// axis. Of the daemon, as they happen, or of a recording that the browser reads.

import { el, heads, name, note, put, visible } from "./dom.js";
import { Lanes, entries, stateAt } from "./lanes.js";
import { NoRecording, changes as changesOf } from "./mcap.js";
import { count, duration, timeOfDay } from "./units.js";

/** Seconds that are shown at first, the least and the most. */
const USUAL = 60;
const LEAST = 0.001;
const MOST = 30 * 86400;
/** Rows of one lane; activities beyond them share the last. */
const ROWS = 4;
/** What is listed below the drawing. */
const LISTED = 100;

const ROW = 18;
const GAP = 8;
const HEAD = 24;
const HUES = [168, 24, 262, 200, 42, 330, 96, 228];

const seconds = (time) => duration(Math.max(0, Math.round(time * 1e9)));

export async function timeline(page, context) {
  const lanes = new Lanes();
  const query = new URLSearchParams(location.search);
  const number = (name) => query.get(name) === null ? NaN : Number(query.get(name));
  /** The range: fixed, or the last seconds until now. */
  let range = Number.isFinite(number("from")) && number("to") > number("from")
    ? { from: number("from"), to: number("to"), follows: false }
    : { from: 0, to: 0, last: Math.min(MOST, Math.max(LEAST, number("last") || USUAL)), follows: true };
  let component = query.get("component") ?? "";
  let ahead = 0;
  let file = null;
  let since = null;
  let missed = 0;
  let picked = null;
  let waits = false;
  let addressed;

  const canvas = el("canvas", { id: "timeline", class: "timeline", role: "application", tabindex: 0,
    "aria-label": "Timeline", "aria-describedby": "timeline-keys" });
  const told = el("p", { class: "soft", id: "timeline-told" });
  const detail = el("p", { id: "timeline-detail", role: "status", "aria-live": "polite" });
  const rows = el("tbody");
  const of = el("select", { id: "timeline-component", onchange: () => { component = of.value; changed(); } });
  const chooser = el("input", { id: "timeline-file", type: "file", accept: ".mcap", onchange: () => chooser.files[0] && open(chooser.files[0]) });
  const button = (text, label, work) => el("button", { type: "button", "aria-label": label, title: label, onclick: work }, text);
  const follow = el("button", { type: "button", id: "timeline-follow", onclick: () => { live(); } }, "Follow");
  const back = el("button", { type: "button", id: "timeline-back", hidden: true, onclick: () => {
    clearTimeout(addressed);
    history.replaceState(null, "", "/timeline");
    context.redraw();
  } }, "Back to the daemon");
  put(page, el("h1", {}, "Timeline"),
    el("div", { class: "row filters" },
      el("div", { class: "field" }, el("label", { for: "timeline-component" }, "Component"), of),
      el("div", { class: "row" }, button("−", "Zoom out", () => zoom(2)), button("+", "Zoom in", () => zoom(0.5)),
        button("◂", "Earlier", () => pan(-0.25)), button("▸", "Later", () => pan(0.25)), button("All", "Show all", () => all()), follow),
      el("div", { class: "field" }, el("label", { for: "timeline-file" }, "A recording (.mcap) instead; it stays in the browser"), chooser), back),
    told, canvas,
    el("p", { class: "soft", id: "timeline-keys" }, "Arrow keys move, + and − zoom, Home shows everything, End follows; Enter and Shift+Enter go from one thing to the next and the one before. Drag, or zoom with the wheel and Ctrl."),
    detail,
    el("details", { class: "card", open: true }, el("summary", {}, el("h3", {}, "In this range")),
      el("div", { class: "wide" }, el("table", { class: "cards", id: "timeline-list" }, heads(["When", "Where", "What", "#How long"]), rows))));

  const now = () => file ? lanes.last : Date.now() / 1000 + ahead;

  function show() {
    if (range.follows) [range.from, range.to] = [now() - range.last, now()];
    return range;
  }

  function live() {
    const last = Math.min(MOST, Math.max(LEAST, range.to - range.from || USUAL));
    range = { ...range, last, follows: true };
    changed();
  }

  function fix(from, to) {
    const long = Math.min(MOST, Math.max(LEAST, to - from));
    range = { from, to: from + long, follows: false };
    changed();
  }

  function pan(part) {
    const { from, to } = show();
    fix(from + (to - from) * part, to + (to - from) * part);
  }

  function zoom(factor, part = 0.5) {
    const { from, to, follows } = show();
    const long = Math.min(MOST, Math.max(LEAST, (to - from) * factor));
    if (follows && !file) {
      range = { ...range, last: long };
      return changed();
    }
    const fixed = from + (to - from) * part;
    fix(fixed - long * part, fixed + long * (1 - part));
  }

  function all() {
    if (!Number.isFinite(lanes.first)) return;
    const pad = Math.max(0.01, (lanes.last - lanes.first) * 0.02);
    fix(lanes.first - pad, (file ? lanes.last : now()) + pad);
  }

  /** The address says what is shown, so that it can be shared. */
  function changed() {
    const shown = new URLSearchParams();
    if (range.follows) shown.set("last", Number(range.last.toPrecision(6)));
    else {
      shown.set("from", range.from.toFixed(6));
      shown.set("to", range.to.toFixed(6));
    }
    if (component) shown.set("component", component);
    // Browsers allow a hundred changes of the address in half a minute.
    clearTimeout(addressed);
    addressed = setTimeout(() => history.replaceState(null, "", `/timeline?${shown}`), 150);
    later();
  }

  function later() {
    if (waits) return;
    waits = true;
    requestAnimationFrame(() => {
      waits = false;
      if (context.stillShown()) draw();
    });
  }

  let shapes = [];
  function draw() {
    const { from, to } = show();
    const found = lanes.within(from, to, component);
    const long = to - from;
    const [names, wide] = [Math.min(220, Math.max(110, canvas.clientWidth * 0.22)), canvas.clientWidth];
    const heights = found.map(({ rows: own }) => Math.max(1, Math.min(ROWS, own.length)) * ROW + GAP);
    const high = HEAD + heights.reduce((sum, one) => sum + one, 0) + GAP;
    const scale = Math.min(devicePixelRatio || 1, 16384 / Math.max(high, wide));
    canvas.style.setProperty("height", `${Math.max(120, high)}px`);
    canvas.width = Math.round(wide * scale);
    canvas.height = Math.round(Math.max(120, high) * scale);
    const pen = canvas.getContext("2d");
    pen.setTransform(scale, 0, 0, scale, 0, 0);
    const style = getComputedStyle(canvas);
    const color = (name) => style.getPropertyValue(`--${name}`);
    const dark = matchMedia("(prefers-color-scheme: dark)").matches;
    const x = (at) => names + (wide - names) * (at - from) / long;
    pen.font = "12px system-ui, sans-serif";
    axis(pen, color, x, from, to, names, wide, high);
    shapes = [];
    let y = HEAD;
    found.forEach((lane, index) => {
      if (index % 2 === 1) {
        pen.fillStyle = color("ground");
        pen.fillRect(0, y, wide, heights[index]);
      }
      pen.fillStyle = color("text");
      pen.textAlign = "left";
      pen.fillText(lane.name, 8, y + GAP / 2 + 13, names - 14);
      pen.save();
      pen.beginPath();
      pen.rect(names, y, wide - names, heights[index]);
      pen.clip();
      for (const { bar, row } of lane.bars) activity(pen, color, dark, x, bar, y + GAP / 2 + Math.min(row, ROWS - 1) * ROW, to, names);
      for (const mark of lane.marks) marked(pen, color, x(mark.at), mark, y + GAP / 2, Math.max(1, Math.min(ROWS, lane.rows.length)) * ROW);
      pen.restore();
      y += heights[index];
    });
    if (picked) ring(pen, color, x, names);
    const bars = found.flatMap((lane) => lane.bars.map(({ bar }) => bar));
    const marks = found.flatMap((lane) => lane.marks);
    const missing = since && from < since ? ` What was before ${timeOfDay(since)} is not kept.` : "";
    put(told, `${timeOfDay(from)} … ${timeOfDay(to)} (${seconds(long)}): ${count(bars.length)} activities, ${count(marks.length)} marks.${missing}`,
      missed > 0 && el("span", { class: "warn" }, ` ${count(missed)} changes were left out: this page was too slow.`),
      file && el("span", {}, " Of ", name(file.name), file.whole ? "" : ", which ends early", file.more ? ", the first of it" : "", "."));
    canvas.setAttribute("aria-label", `Timeline of ${seconds(long)}: ${bars.length} activities, ${marks.length} marks in ${found.length} lanes`);
    list(bars, marks, to);
    follow.setAttribute("aria-pressed", String(range.follows));
  }

  function axis(pen, color, x, from, to, names, wide, high) {
    const raw = (to - from) / Math.max(2, (wide - names) / 110);
    const power = 10 ** Math.floor(Math.log10(raw));
    const step = [1, 2, 5, 10].map((one) => one * power).find((one) => one >= raw);
    const long = step >= 1 ? 8 : 12;
    pen.strokeStyle = color("rule");
    pen.fillStyle = color("soft");
    pen.textAlign = "center";
    pen.lineWidth = 1;
    for (let at = Math.ceil(from / step) * step; at <= to; at += step) {
      const here = Math.round(x(at)) + 0.5;
      pen.beginPath();
      pen.moveTo(here, HEAD - 5);
      pen.lineTo(here, high);
      pen.stroke();
      const fine = step < 0.001 ? ` + ${duration(Math.round((at * 1e3 % 1) * 1e6))}` : "";
      pen.fillText(timeOfDay(at).slice(0, long) + fine, Math.min(Math.max(here, names + 30), wide - 34), 14);
    }
  }

  /** A bar with a piece for each state; states have colours by their names. */
  function activity(pen, color, dark, x, bar, y, to, names) {
    const end = bar.to ?? (file ? lanes.last : Math.min(to, now()));
    const [left, right] = [Math.max(names, x(bar.from)), Math.max(x(bar.from) + 2, x(end))];
    pen.fillStyle = color("deep");
    pen.fillRect(left, y, right - left, ROW - 3);
    bar.states.forEach((state, index) => {
      const [begin, over] = [x(state.from), x(bar.states[index + 1]?.from ?? end)];
      if (over < names || begin > canvas.clientWidth) return;
      let hash = 0;
      for (const sign of state.name) hash = (hash * 31 + sign.codePointAt(0)) % 997;
      pen.fillStyle = `hsl(${HUES[hash % HUES.length]} 55% ${dark ? 38 : 68}%)`;
      pen.fillRect(Math.max(names, begin), y, Math.max(0.7, over - Math.max(names, begin)), ROW - 3);
      if (over - Math.max(names, begin) > 34) {
        pen.fillStyle = color("text");
        pen.textAlign = "left";
        pen.fillText(state.name, Math.max(names, begin) + 4, y + 12, over - Math.max(names, begin) - 6);
      }
    });
    pen.strokeStyle = bar.exception ? color("bad") : color("soft");
    pen.lineWidth = bar.exception ? 2 : 1;
    pen.strokeRect(left + 0.5, y + 0.5, Math.max(1, right - left - 1), ROW - 4);
    shapes.push({ left, right, top: y, bottom: y + ROW, bar });
  }

  function marked(pen, color, x, mark, y, high) {
    const tone = { bad: "bad", warn: "warn", good: "good" }[mark.tone] ?? "soft";
    pen.strokeStyle = pen.fillStyle = color(tone);
    pen.lineWidth = 1.5;
    pen.beginPath();
    pen.moveTo(x, y);
    pen.lineTo(x, y + high);
    pen.stroke();
    pen.beginPath();
    pen.moveTo(x - 4.5, y);
    pen.lineTo(x + 4.5, y);
    pen.lineTo(x, y + 7);
    pen.fill();
    shapes.push({ left: x - 5, right: x + 5, top: y - 2, bottom: y + high, mark });
  }

  function ring(pen, color, x, names) {
    const shape = shapes.find(({ bar, mark }) => (bar ?? mark) === picked);
    if (!shape) return;
    pen.strokeStyle = color("focus");
    pen.lineWidth = 2.5;
    const left = Math.max(names, shape.left - 1);
    pen.strokeRect(left, shape.top - 1, Math.min(shape.right, canvas.clientWidth) - left + 1, shape.bottom - shape.top);
  }

  /** What a bar or mark is, in words. */
  function words(one, at) {
    if (one.what) return `${timeOfDay(one.at)} · ${one.lane}: ${one.what}`;
    const state = at !== undefined ? stateAt(one, at) : one.states.at(-1);
    const end = one.to ?? now();
    const inState = state ? `; in ${state.name}${state.paused ? " (paused)" : ""} since ${timeOfDay(state.from)}${state.to ? ` for ${seconds(state.to - state.from)}` : ""}` : "";
    const how = one.to === null ? "runs for" : one.exception ? `ended with ${one.exception} after` : "ended after";
    return `${timeOfDay(one.from)} · ${one.lane} #${one.activity} ${how} ${one.cut ? "more than " : ""}${seconds(end - one.from)}${inState}`;
  }

  let drawn = "";
  function list(bars, marks, to) {
    const shown = entries(bars, marks, LISTED).map((one) => one.what
      ? [timeOfDay(one.at), one.lane, one.what, one.until > one.at ? seconds(one.until - one.at) : "", one.tone]
      : [timeOfDay(one.from), one.lane, `#${one.activity} ${one.exception ?? (one.to === null ? `in ${one.states.at(-1)?.name ?? "no state yet"}` : `done: ${one.states.slice(0, 12).map((state) => state.name).join(" → ")}`)}`,
        one.to === null ? "runs" : seconds(one.to - one.from), one.exception ? "bad" : ""]);
    const text = JSON.stringify(shown);
    // The reader of a table is not disturbed where nothing changed.
    if (text === drawn) return;
    drawn = text;
    put(rows, shown.map(([when, where, what, long, tone]) => el("tr", { class: tone },
      el("td", { "data-label": "When" }, when), el("td", { "data-label": "Where" }, name(where)), el("td", { "data-label": "What" }, name(what)),
      el("td", { "data-label": "How long", class: "number" }, long))));
  }

  function pick(one, at) {
    picked = one;
    put(detail, one ? visible(words(one, at), 400) : "");
    later();
  }

  function step(by) {
    const order = shapes.map(({ bar, mark }) => bar ?? mark).sort((one, other) => (one.at ?? one.from) - (other.at ?? other.from));
    if (order.length === 0) return;
    const index = order.indexOf(picked);
    pick(order[index < 0 ? (by > 0 ? 0 : order.length - 1) : (index + by + order.length) % order.length]);
  }

  const KEYS = {
    ArrowLeft: () => pan(-0.2), ArrowRight: () => pan(0.2), "+": () => zoom(0.5), "=": () => zoom(0.5), "-": () => zoom(2),
    ArrowUp: () => zoom(0.8), ArrowDown: () => zoom(1.25), Home: () => all(), End: () => live(), Escape: () => pick(null),
  };
  canvas.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    const work = event.key === "Enter" ? () => step(event.shiftKey ? -1 : 1) : KEYS[event.key];
    if (!work) return;
    event.preventDefault();
    work();
  });
  const names = () => Math.min(220, Math.max(110, canvas.clientWidth * 0.22));
  const timeOf = (x) => {
    const { from, to } = show();
    return from + (to - from) * (x - names()) / (canvas.clientWidth - names());
  };
  canvas.addEventListener("wheel", (event) => {
    // Without Ctrl the page scrolls, as everywhere.
    if (!event.ctrlKey) return;
    event.preventDefault();
    const part = (event.offsetX - names()) / (canvas.clientWidth - names());
    zoom(event.deltaY > 0 ? 1.25 : 0.8, Math.min(1, Math.max(0, part)));
  }, { passive: false });
  let dragged = null;
  canvas.addEventListener("pointerdown", (event) => {
    dragged = { x: event.offsetX, ...show(), moved: false };
    canvas.setPointerCapture(event.pointerId);
  });
  canvas.addEventListener("pointermove", (event) => {
    if (!dragged) return;
    const by = (dragged.x - event.offsetX) * (dragged.to - dragged.from) / (canvas.clientWidth - names());
    if (!dragged.moved && Math.abs(dragged.x - event.offsetX) < 4) return;
    dragged.moved = true;
    fix(dragged.from + by, dragged.to + by);
  });
  canvas.addEventListener("pointerup", (event) => {
    if (dragged && !dragged.moved) {
      const [x, y] = [event.offsetX, event.offsetY];
      const hit = shapes.findLast((one) => x >= one.left && x <= one.right && y >= one.top && y <= one.bottom);
      pick(hit ? hit.mark ?? hit.bar : null, timeOf(x));
    }
    dragged = null;
  });
  canvas.addEventListener("pointercancel", () => { dragged = null; });

  function choices() {
    const all = [...lanes.components].sort();
    if (all.length + 1 === of.options.length) return;
    put(of, el("option", { value: "" }, "all"), all.map((one) => el("option", { value: one }, one)));
    if (component && !lanes.components.has(component)) of.append(el("option", { value: component }, component));
    of.value = component;
  }

  function hear({ first, changes, now: told, since: from, missed: more }) {
    if (file) return;
    if (first) {
      lanes.clear();
      missed = 0;
    }
    ahead = told / 1e9 - Date.now() / 1000;
    since = from / 1e9;
    missed += more;
    for (const { at, change } of changes) lanes.add(at / 1e9, change);
    choices();
    later();
  }

  async function open(chosen) {
    const mine = { name: chosen.name, whole: true, more: false };
    try {
      put(told, "reading…");
      const { found, whole, more } = await changesOf(chosen, (part) => put(told, `reading: ${Math.round(100 * part)} %`));
      if (found.length === 0) throw new NoRecording("it has no activities, exceptions or changes");
      file = { ...mine, whole, more };
      streams?.watch([]);
      lanes.clear();
      [since, missed, picked] = [null, 0, null];
      for (const { at, change } of found) lanes.add(at, change);
      of.replaceChildren();
      component = "";
      choices();
      back.hidden = false;
      all();
    } catch (error) {
      note(`${chosen.name}: ${error instanceof NoRecording ? error.message : "it cannot be read"}`, "error");
      later();
    }
  }

  choices();
  const streams = context.watch([{ path: "/timeline/stream", hear }]);
  const ticking = setInterval(() => range.follows && !file && !document.hidden && later(), 200);
  addEventListener("resize", later);
  later();
  return () => {
    clearInterval(ticking);
    clearTimeout(addressed);
    removeEventListener("resize", later);
  };
}
