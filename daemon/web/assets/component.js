// The page of a component: its services, ports, tasks and events.

import { get, path, post, told } from "./api.js";
import { histograms } from "./heat.js";
import { el, heads, name, note, put } from "./dom.js";
import { tone } from "./overview.js";
import { ports } from "./port.js";
import { rules } from "./rules.js";
import { service } from "./service.js";
import { count, duration, middlewares } from "./units.js";

const CHANGES = "transition,activity_ended,component_loaded,component_unloaded,component_reloaded";
/** As many services are all open at first. */
const FEW = 12;
const KINDS = [["activity", "Activities"], ["attribute", "Attributes"], ["function", "Functions"]];

export async function component(page, context, named) {
  context.title(named);
  const own = path("components", named);
  const described = await get(own);
  if (!context.stillShown()) return;
  const state = el("span", { class: `pill ${tone(described.state)}`, id: "component-state" }, described.state);
  const mine = described.services.filter((one) => !one.standard);
  // Where there are many services, forms are filled only of those that somebody opens.
  const services = mine.map((one) => service(named, one, context, mine.length <= FEW || one.kind === "activity"));
  const shown = ports(named, context, () => live.watch(watched()));
  const supervised = rules();
  const spent = services.map((one) => one.spent).filter(Boolean);
  spent.forEach((one) => one.node.addEventListener("toggle", () => live?.watch(watched())));
  const heats = histograms(`${own}/tasks/histograms`, () => live?.watch(watched()));
  const tasks = el("tbody");
  const table = el("div", { class: "wide" }, el("table", { class: "cards", id: "tasks" },
    heads(["Task", "#Period", "#Cycles", "#Missed", "#Work, mean", "#Longest", "#Lateness, 99 %"]), tasks));
  put(page,
    el("div", { class: "title" }, el("h1", {}, name(named)), state),
    described.doc && el("p", { class: "doc" }, described.doc),
    el("p", { class: "soft" }, [named === described.component ? null : ["an instance of ", name(described.component), " · "],
      `version ${described.version} · ${described.lang} · `, middlewares(described.backend).join(", "),
      described.cell ? ` · cell ${described.cell}` : "", " · ", el("bdi", { class: "path", title: described.library }, described.library.split("/").at(-1))]),
    KINDS.map(([kind, title]) => {
      const these = mine.map((one, at) => [one, services[at]])
        .filter(([one]) => one.kind === kind);
      return these.length > 0 && el("section", { "aria-label": title }, el("h2", {}, title),
        el("div", { class: kind === "activity" ? "stack" : "grid" }, these.map(([, made]) => made.node)));
    }),
    described.events.length > 0 && el("section", {}, el("h2", {}, "Events"),
      el("div", { class: "row" }, described.events.map((event) => fire(named, event, context)))),
    el("section", {}, el("h2", {}, "Ports"), el("p", { class: "soft" }, "Open a port to see its value."), shown.node),
    el("section", {}, el("h2", {}, "Tasks"), table, heats.node), supervised.node);

  function takeTasks({ tasks: all }) {
    put(tasks, all.map((task) => {
      const cell = (label, text, extra) => el("td", { "data-label": label, class: "number", ...extra }, text);
      return el("tr", {}, el("th", { scope: "row" }, name(task.name), task.real_time && " (real-time)",
        task.stuck && el("span", { class: "bad" }, ` stuck in ${task.stuck.codel}`)),
      cell("Period", task.period_ns ? duration(task.period_ns) : "–"), cell("Cycles", count(task.cycles.count)),
      cell("Missed", count(task.overruns), { class: task.overruns > 0 ? "number warn" : "number" }),
      cell("Work, mean", duration(task.cycles.mean_ns)), cell("Longest", duration(task.cycles.max_ns)),
      cell("Lateness, 99 %", duration(task.lateness.p99_ns)));
    }));
  }

  let gone = false;
  function takeAll({ components }, status) {
    if (status !== 200) return;
    const now = components.find((one) => one.name === named);
    if (now && gone) return context.redraw();
    gone = !now;
    supervised.take(now?.supervision ?? []);
    put(state, now ? now.state : "gone");
    state.className = `pill ${now ? tone(now.state) : "bad"}`;
  }

  function hear(change) {
    if (change.component !== named) return;
    if (change.event.startsWith("component_")) {
      if (change.event !== "component_unloaded") context.redraw();
      return;
    }
    services.forEach((one) => one.hear(change));
  }

  let ahead = 0;
  const draw = () => {
    const now = Date.now() / 1000 + ahead;
    spent.filter((one) => one.node.open).forEach((one) => one.draw(now));
  };
  const drawing = setInterval(draw, 500);
  /** The dated changes of the last minutes, and those that come. */
  function date({ first, changes, now }) {
    if (first) spent.forEach((one) => one.reset());
    ahead = now / 1e9 - Date.now() / 1000;
    for (const { at, change } of changes) {
      if (change.component === named) spent.find((one) => one.service === change.service)?.take(at / 1e9, change);
    }
    draw();
  }

  const good = (take) => (body, status) => status === 200 && take(body);
  const watched = () => [
    { path: "/components", take: takeAll },
    { path: `${own}/activities`, take: good(({ activities }) => services.forEach((one) => one.take(activities))) },
    { path: `${own}/ports?values=false`, take: good(({ ports: all }) => shown.take(all)) },
    { path: `${own}/tasks`, take: good(takeTasks) },
    { path: `/events?only=${CHANGES}`, hear },
    ...(spent.some((one) => one.node.open) ? [{ path: `/timeline/stream?component=${encodeURIComponent(named)}`, hear: date }] : []),
    ...heats.watched(),
    ...shown.watched(),
  ];
  const live = context.watch(watched());
  return () => {
    clearInterval(drawing);
    shown.close();
  };
}

function fire(component, event, context) {
  const go = async () => {
    try {
      await post(path("components", component, "events", event));
      note(`${event} was fired`);
    } catch (error) {
      note(told(error), "error");
    }
  };
  return el("button", { type: "button", class: "danger", disabled: !context.may("call"), onclick: go }, "Fire ", name(event));
}
