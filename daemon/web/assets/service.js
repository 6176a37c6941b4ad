// A service on the page of its component: what it is, a form to call it, and for an activity its
// state machine at work.

import { get, path, post, remove, told } from "./api.js";
import { el, name, put, visible } from "./dom.js";
import { inputs } from "./form.js";
import { drawing } from "./machine.js";
import { Spent } from "./spent.js";
import { exception } from "./units.js";

/** How long a state stays lit that an activity only passed through, in ms. */
const GLOW = 450;
/** Ended activities that are listed. */
const KEPT = 4;

/** How a service ended, as text. */
function outcome(reply) {
  if (reply.exception) {
    const detail = reply.detail ? ` ${visible(JSON.stringify(reply.detail), 400)}` : "";
    return el("span", { class: "bad" }, name(exception(reply.exception)), detail);
  }
  const result = reply.result ?? {};
  const none = typeof result === "object" && Object.keys(result).length === 0;
  return el("span", { class: "good" }, none ? "done" : visible(JSON.stringify(result), 400));
}

/** `{ node, take(activities), hear(change) }` for a service of a component; `open` at first or not. */
export function service(component, described, context, open) {
  const activity = described.kind === "activity";
  const form = el("form", { class: "call", novalidate: true });
  const reply = el("output", { class: "reply", "aria-live": "polite" });
  const list = el("ul", { class: "activities" });
  const machine = activity && described.codels.length > 0
    ? drawing(`State machine of ${described.name}`, described.codels) : null;
  const spent = machine ? new Spent(described.name) : null;
  const head = el("summary", {}, el("h3", {}, name(described.name)),
    el("span", { class: "kind" }, described.kind), list.count = el("span", { class: "pill good", hidden: true }));
  const box = el("details", { class: `card service ${described.kind}`, "data-service": described.name, open },
    head,
    described.doc && el("p", { class: "doc" }, described.doc),
    el("div", { class: "work" }, machine && el("div", { class: "wide", tabindex: 0, role: "group", "aria-label": `States of ${described.name}` }, machine.node), el("div", {}, form, list)),
    spent?.node,
    facts(described));

  async function fill() {
    try {
      const whole = await get(path("components", component, "services", described.name));
      const made = inputs(whole);
      const verb = activity ? "Start" : described.kind === "attribute" && made.nodes.length > 0 ? "Set" : described.kind === "attribute" ? "Read" : "Call";
      const may = context.may("call");
      const button = el("button", { type: "submit", class: "main" }, verb);
      put(form, made.nodes, el("div", { class: "row" },
        may ? button : el("span", { class: "soft" }, "Your rights do not allow calls."), reply));
      form.onsubmit = (event) => {
        event.preventDefault();
        if (may) call(made);
      };
    } catch (error) {
      put(form, el("p", { class: "error", role: "alert" }, told(error)));
    }
  }

  async function call(made) {
    let body;
    try {
      body = made.json();
    } catch (mistake) {
      put(reply, el("span", { class: "bad" }, mistake.message));
      mistake.field?.focus();
      return;
    }
    put(reply, "…");
    try {
      const answer = await post(path("components", component, "services", described.name), body);
      put(reply, answer.activity === undefined ? outcome(answer) : `activity ${answer.activity} was accepted`);
    } catch (error) {
      put(reply, el("span", { class: "bad" }, told(error)));
    }
  }

  async function abort(number) {
    try {
      await remove(path("components", component, "activities", String(number)));
    } catch (error) {
      put(reply, el("span", { class: "bad" }, told(error)));
    }
  }

  const rows = new Map();
  function takeActivities(all) {
    const mine = all.filter((one) => one.service === described.name);
    const running = mine.filter((one) => one.status === "running");
    const ended = mine.filter((one) => one.status !== "running").slice(-KEPT);
    const shown = [...running, ...ended.reverse()];
    for (const [number, row] of rows) {
      if (!shown.some((one) => one.activity === number)) {
        row.node.remove();
        rows.delete(number);
      }
    }
    shown.forEach((one, at) => {
      let row = rows.get(one.activity);
      if (!row) {
        row = { text: el("span"), stop: el("button", { type: "button", onclick: () => abort(one.activity) }, "Abort") };
        row.stop.setAttribute("aria-label", `Abort activity ${one.activity} of ${described.name}`);
        row.node = el("li", { "data-activity": one.activity }, `#${one.activity} `, row.text, " ", context.may("call") && row.stop);
        rows.set(one.activity, row);
      }
      const runs = one.status === "running";
      row.node.dataset.status = one.status;
      row.stop.hidden = !runs;
      put(row.text, runs ? ["in ", el("strong", {}, one.state ?? "?")] : outcome(one));
      if (list.children[at] !== row.node) list.insertBefore(row.node, list.children[at] ?? null);
    });
    list.count.hidden = running.length === 0;
    put(list.count, `${running.length} running`);
    states = new Set(running.flatMap((one) => (one.state ?? "").split(/[^\w:]+/)).filter(Boolean));
    light();
  }

  let states = new Set();
  const passed = new Map();
  function light() {
    const now = performance.now();
    for (const [state, since] of passed) if (now - since > GLOW) passed.delete(state);
    machine?.light(new Set([...states, ...passed.keys()]));
  }

  function hear(change) {
    if (change.service !== described.name || !machine) return;
    const state = change.event === "transition" ? change.state : change.event === "activity_ended" ? "ether" : null;
    if (!state) return;
    passed.set(state, performance.now());
    light();
    setTimeout(light, GLOW + 20);
  }

  // The form is read when somebody looks at it.
  let filled = false;
  const look = () => {
    if (box.open && !filled) {
      filled = true;
      fill();
    }
  };
  box.addEventListener("toggle", look);
  look();
  return { node: box, take: takeActivities, hear, spent };
}

function facts(described) {
  const throws = described.throws.filter((one) => !one.startsWith("::genom::")).map(exception);
  const all = [
    ["Task", described.task], ["Interrupts", described.interrupts.join(", ")],
    ["After", described.after.join(", ")], ["Before", described.before.join(", ")],
    ["Exceptions", throws.join(", ")],
  ].filter(([, text]) => text);
  return all.length > 0 && el("dl", { class: "facts" }, all.map(([term, text]) =>
    el("div", {}, el("dt", {}, term), el("dd", {}, name(text)))));
}
