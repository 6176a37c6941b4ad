// What runs: components with their states, what they missed, and how their activities ended.

import { get, path } from "./api.js";
import { el, heads, link, name, pageOf, put } from "./dom.js";
import { fleet } from "./fleet.js";
import { count, exception, middlewares } from "./units.js";

const CHANGES = "overrun,activity_ended,component_loaded,component_unloaded,component_failed";

/** Whether a state is one in which all is well. */
export const tone = (state) => state === "running" ? "good" : state === "held" ? "warn" : "bad";

export async function overview(page, context) {
  const about = await get("/");
  const missed = new Map();
  const ended = new Map();
  const rows = new Map();
  const body = el("tbody");
  const summary = el("p", { class: "soft", id: "summary" });
  const loading = el("div");
  const cells = el("div");
  const others = fleet();
  const empty = el("p", { class: "empty" }, "No component runs. Load one: ",
    el("code", {}, "genomctl load demo"), ".");
  const table = el("table", { class: "cards", id: "components" },
    heads(["Component", "State", "#Activities", "#Missed periods", "Last exception", "Middleware", "Cell"]), body);
  put(page, el("h1", {}, "Overview"), summary, loading, el("div", { class: "wide" }, table), empty, cells, others.node);

  function row(component) {
    const cell = (label, extra) => el("td", { "data-label": label, ...extra });
    const made = {
      state: cell("State"), activities: cell("Activities", { class: "number" }),
      missed: cell("Missed periods", { class: "number" }), ended: cell("Last exception"),
      backend: cell("Middleware"), cell: cell("Cell"),
    };
    made.row = el("tr", { "data-component": component },
      el("th", { scope: "row" }, link(pageOf(component), name(component))),
      made.state, made.activities, made.missed, made.ended, made.backend, made.cell);
    return made;
  }

  function drawCounts(component) {
    const shown = rows.get(component);
    if (!shown) return;
    const of = missed.get(component);
    put(shown.missed, of === undefined ? "–" : count(of));
    shown.missed.classList.toggle("warn", of > 0);
    const last = ended.get(component);
    put(shown.ended, last ? el("span", { class: "bad" }, name(exception(last.exception)), " of ", name(last.service)) : "–");
  }

  /** Reads once what changes are added to later. */
  async function lookUp(component) {
    const [tasks, activities] = await Promise.allSettled(
      [get(path("components", component, "tasks")), get(path("components", component, "activities"))]);
    if (tasks.status === "fulfilled") {
      missed.set(component, tasks.value.tasks.reduce((sum, task) => sum + task.overruns, 0));
    }
    if (activities.status === "fulfilled") {
      const last = activities.value.activities.filter((one) => one.status === "exception").pop();
      if (last) ended.set(component, last);
    }
    if (context.stillShown()) drawCounts(component);
  }

  function take({ components, loading: names = [], left_behind = [] }) {
    const order = components.map((one) => one.name);
    for (const [known, shown] of rows) {
      if (!order.includes(known)) {
        shown.row.remove();
        rows.delete(known);
      }
    }
    components.forEach((one, at) => {
      let shown = rows.get(one.name);
      if (!shown) {
        shown = row(one.name);
        rows.set(one.name, shown);
        lookUp(one.name);
      }
      if (body.children[at] !== shown.row) body.insertBefore(shown.row, body.children[at] ?? null);
      put(shown.state, el("span", { class: `pill ${tone(one.state)}` }, one.state));
      put(shown.activities, one.activities);
      put(shown.backend, middlewares(one.backend).map((backend) => [name(backend), " "]));
      put(shown.cell, one.cell ? name(one.cell) : "–");
      drawCounts(one.name);
    });
    table.hidden = components.length === 0;
    empty.hidden = components.length > 0 || names.length > 0;
    const plural = components.length === 1 ? "component" : "components";
    put(summary, `${components.length} ${plural} · default middleware ${about.backend} · genomd ${about.genomd}, process ${about.pid}`);
    put(loading, names.length > 0 && el("p", { class: "warn" }, `Being loaded: ${names.join(", ")}`),
      left_behind.map((one) => el("p", { class: "bad" }, name(one.was), ` ${one.state}`)));
  }

  function drawCells({ cells: all = [] } = {}) {
    if (all.length === 0) return put(cells);
    put(cells, el("h2", {}, "Cells"), el("div", { class: "wide" }, el("table", { class: "cards" },
      heads(["Cell", "State", "#Process", "#Starts", "Components"]),
      el("tbody", {}, all.map((one) => el("tr", {},
        el("th", { scope: "row" }, name(one.name)),
        el("td", { "data-label": "State" }, el("span", { class: `pill ${one.state === "running" ? "good" : "warn"}` }, one.state)),
        el("td", { "data-label": "Process", class: "number" }, one.pid ?? "–"),
        el("td", { "data-label": "Starts", class: "number" }, one.starts),
        el("td", { "data-label": "Components" }, (one.components ?? []).map((component) => [link(pageOf(component), name(component)), " "]))))))));
  }

  function hear(change) {
    const { event, component } = change;
    if (event === "overrun") missed.set(component, (missed.get(component) ?? 0) + change.ticks);
    if (event === "activity_ended" && change.exception) ended.set(component, change);
    if (event === "component_unloaded" || event === "component_loaded") {
      missed.delete(component);
      ended.delete(component);
      if (rows.has(component)) lookUp(component);
    }
    if (event === "missed") for (const known of rows.keys()) lookUp(known);
    drawCounts(component);
  }

  context.watch([
    { path: "/components", take: (body, status) => status === 200 && take(body) },
    { path: "/cells", take: (body, status) => status === 200 && drawCells(body) },
    { path: "/daemons", take: (body, status) => status === 200 && others.take(body) },
    { path: `/events?only=${CHANGES}`, hear },
  ], 4);
}
