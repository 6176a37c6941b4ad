// The graph of components: their ports, connections, cells, and what other programs have on the
// middlewares. Connections are made, moved and removed by dragging, in menus, or with the keyboard.

import { get } from "./api.js";
import { choose as select } from "./dialog.js";
import { el, name, pageOf, put, svg } from "./dom.js";
import { Drawing, about, color } from "./drawing.js";
import { Ends, isEnd, isStart, likely, ordered } from "./ends.js";
import { next, pointer } from "./gestures.js";
import { closeMenu, menu } from "./menu.js";
import { parts } from "./port.js";
import { Rates } from "./rates.js";
import { LEVELS, MANY, scene } from "./scene.js";
import { frequency, middlewares } from "./units.js";
import { View } from "./view.js";
import { change, connect, disconnect, mismatch, move, moveTo, pick, servicesOf } from "./wiring.js";

/** Milliseconds between two looks at what other programs have. */
const LOOKS = 5000;

function help() {
  const line = (what, how) => [el("dt", {}, what), el("dd", {}, how)];
  return el("details", { class: "soft" }, el("summary", {}, "How to connect"), el("dl", { class: "keys" },
    line("Connect", "Drag from an out port to an in port, or from a remote to a service. With the keyboard: Enter on both."),
    line("Move", "Drag the end of a connection, or its in port, to another in port."),
    line("Disconnect and more", "Right click, long touch, menu key or M, on a connection, a port or a component; Delete disconnects."),
    line("Look around", "Wheel or two fingers zoom, dragging moves. Arrow keys go along ports and connections.")));
}

export async function graph(page, context) {
  const query = new URLSearchParams(location.search);
  const drawing = new Drawing();
  const line = svg("path", { class: "dragged", hidden: true });
  drawing.layer.append(line);
  const canvas = svg("svg", { id: "graph", class: "graph", role: "group", "aria-label": "Graph of components", "aria-busy": "true" }, drawing.layer);
  const view = new View(canvas, drawing.layer, (box) => drawing.cull(box));
  const status = el("p", { class: "soft", role: "status", id: "graph-status" });
  const key = el("ul", { class: "legend", "aria-label": "Colours of middlewares" });
  const find = el("input", { type: "search", id: "find", value: query.get("find") ?? "", autocomplete: "off", placeholder: "name, port, type, cell" });
  const level = select("level", "Show", [["", "what fits"], ...LEVELS.map((one) => [one, one])], query.get("level") ?? "");
  const states = tick("with-state", "State ports", query.get("states") === "1");
  const others = tick("with-peers", "Other programs", query.get("peers") !== "0");
  const mayWire = context.may("wire");
  put(page, el("div", { class: "title" }, el("h1", {}, "Graph"), el("span", { class: "gap" }),
    button("−", "Smaller", () => view.zoom(0.8)), button("+", "Larger", () => view.zoom(1.25)), button("Fit", "Fit everything into the window", fit)),
  el("form", { class: "filters", role: "search", onsubmit: (event) => { event.preventDefault(); goToFound(); } },
    el("div", { class: "field" }, el("label", { for: "find" }, "Find"), find), level.node, states.node, others.node),
  canvas,
  el("div", { class: "row under-graph" }, key, status),
  mayWire ? help() : el("p", { class: "soft" }, "Your rights do not allow to connect."));

  const told = { components: [], ports: [], connections: [], middlewares: [] };
  const folds = new Map();
  const rates = new Rates();
  let known = [];
  const awaited = new Set(["components", "connections", "ports", "middlewares"]);
  let shape = "";
  let picked = null;
  let dragged = null;
  let waits = false;
  let stopped = false;

  function tick(id, text, checked) {
    const input = el("input", { type: "checkbox", id, checked });
    return { input, node: el("div", { class: "field inline" }, input, el("label", { for: id }, text)) };
  }
  function button(text, label, act) {
    return el("button", { type: "button", "aria-label": label, title: label, onclick: act }, text);
  }

  // What is shown.

  const levelNow = () => level.input.value || (told.components.length > MANY ? "components" : "ports");
  const wish = () => ({ level: levelNow(), folds, states: states.input.checked, peers: others.input.checked, find: find.value });

  /** Draws with the next frame, once for all that arrived. */
  function later() {
    if (waits) return;
    waits = true;
    requestAnimationFrame(() => {
      waits = false;
      if (!stopped) draw();
    });
  }

  function draw() {
    // What is below the pointer stays there.
    if (dragged) return;
    const now = JSON.stringify([told.components.map(({ activities, notes, ...one }) => one), told.connections, told.middlewares, wish(), [...folds],
      told.ports.map((port) => [port.address, port.backend, port.digest])]);
    if (now !== shape) {
      shape = now;
      const made = scene(told, wish());
      const box = canvas.getBoundingClientRect();
      drawing.draw(made, Math.max(0.6, box.width / Math.max(1, box.height)));
      known = made.nodes;
      drawKey(made);
      if (view.chosen) drawing.cull(view.seen());
      else fit();
    }
    // From now on what is drawn moves only when something changes.
    if (awaited.size === 0) canvas.removeAttribute("aria-busy");
    drawing.tell(rateOf, (node) => node.component ? numbers.get(node.name) ?? 0 : 0);
  }

  let numbers = new Map();

  function drawKey({ nodes, edges, hidden }) {
    const used = new Set([...edges.filter((one) => one.kind === "port").map((one) => one.backend), ...told.ports.flatMap((port) => middlewares(port.backend))]);
    const entry = (kind, text) => el("li", {}, el("span", { class: `key ${kind}` }), name(text));
    put(key, [...used].filter(Boolean).sort().map((backend) => entry(color(backend), backend)),
      edges.some((one) => one.kind === "service") && entry("dashed", "calls of remotes"),
      nodes.some((one) => one.kind === "peer") && entry("dotted", "other programs"));
    const plural = (count, what) => `${count} ${what}${count === 1 ? "" : "s"}`;
    put(status, `${plural(told.components.length, "component")}, ${plural(told.connections.length, "connection")}`,
      hidden > 0 && `, ${hidden} not shown`);
  }

  function rateOf({ list, foreign, kind }) {
    if (foreign || kind === "service") return "";
    let sum;
    for (const one of list) {
      const rate = rates.of(one.out) ?? rates.of(one.in);
      if (rate !== undefined) sum = (sum ?? 0) + rate;
    }
    return sum === undefined ? "" : `${list.length > 1 ? `${list.length} · ` : ""}${frequency(sum)}`;
  }

  function fit() {
    view.chosen = false;
    view.fit(drawing.bounds());
  }

  function goToFound() {
    const first = known.find((node) => !node.beside);
    if (!find.value.trim() || !first) return put(status, "Nothing has this name.");
    view.reveal(drawing.place(first.id));
    focus(first.id);
  }

  function share() {
    const now = new URLSearchParams([["find", find.value.trim()], ["level", level.input.value],
      ["states", states.input.checked ? "1" : ""], ["peers", others.input.checked ? "" : "0"]].filter(([, value]) => value));
    history.replaceState(null, "", `${location.pathname}${now.size > 0 ? `?${now}` : ""}`);
    later();
  }
  find.addEventListener("input", () => { view.chosen = false; share(); });
  level.input.addEventListener("change", () => { folds.clear(); view.chosen = false; share(); });
  states.input.addEventListener("change", share);
  others.input.addEventListener("change", share);

  function fold(id, folded) {
    folds.set(id, folded);
    draw();
    focus(id);
  }

  function focus(id) {
    const node = drawing.find(id);
    node?.focus({ preventScroll: true });
  }

  // Connections.

  const ends = new Ends(told, drawing);
  const reconnect = (from, to) => connect(from, to, told.connections);
  const goOn = (one, other) => reconnect(...(one.way === "out" ? [one, other] : [other, one]));

  async function connectTo(port) {
    const title = port.remote ? "Call a service" : port.way === "out" ? "Connect to" : "Read";
    pick(title, port.address, await ends.fitting(port), (end) => goOn(port, end));
  }

  async function moveAway(one) {
    const from = ends.source(one);
    const others = (await ends.fitting(from)).filter((end) => end.address !== one.in);
    pick("Move to", one.in, others, (end) => move(one, from, end, told.connections));
  }

  const ofConnection = (one) => [
    one.kind === "port" && ["Change policy or middleware…", () => change(one, ends.source(one), ends.reader(one))],
    ["Move to another end…", () => moveAway(one)],
    ["Disconnect…", () => disconnect(one), { danger: true }],
  ];

  /** The menu of whatever has this key. */
  function openMenu(id, at) {
    const back = drawing.find(id);
    const box = back?.getBoundingClientRect();
    const where = at ?? { x: box.x + Math.min(box.width, 200) / 2, y: box.y + box.height / 2 };
    const all = told.middlewares.map((one) => one.name);
    if (id.startsWith("edge ")) {
      const one = drawing.edges.get(id.slice(5));
      if (!one) return;
      const label = [about(one), rateOf(one)].filter(Boolean).join(", ");
      if (one.list.length === 1) {
        menu(where, label, [label, ...(mayWire && !one.foreign ? ofConnection(one.list[0]) : [])], back);
      } else {
        const each = one.list.slice(0, 12).map((single) =>
          [`${single.out} → ${single.in}`, () => mayWire ? menu(where, single.in, [`${single.out} → ${single.in}`, ...ofConnection(single)], back) : goTo(single.in)]);
        menu(where, label, [label, ...each], back);
      }
      return;
    }
    const row = drawing.ports.get(id);
    if (row) {
      const { port } = row;
      const { component, port: own } = parts(port.address);
      const now = ends.of(port);
      menu(where, port.address, [`${port.address}${port.type ? `, ${port.type.replace(/^::/, "")}` : ""}`,
        mayWire && (!port.foreign || port.way === "out") && [port.way === "in" && !port.remote ? "Read an out port…" : port.remote ? "Call a service…" : "Connect to…", () => connectTo(port)],
        ...(mayWire && now ? ofConnection(now) : []),
        mayWire && !port.foreign && !port.remote && !port.service && ["Move to another middleware…", () => moveTo(component, own, port.backend, all)],
        !port.foreign && ["Open its component", () => goTo(port.address)]], back);
      return;
    }
    const node = drawing.nodes.get(id.replace(/^fold /, ""));
    if (!node) return;
    menu(where, node.name, [node.name,
      node.kind === "component" && ["Open its page", () => goTo(node.name)],
      ["Only this and its neighbours", () => { find.value = node.name; find.dispatchEvent(new Event("input")); }],
      node.kind !== "peer" && [node.folded ? "Unfold" : "Fold", () => fold(node.id, !node.folded)],
      node.component?.cell && ["Fold its cell", () => fold(`cell ${node.component.cell}`, true)],
      mayWire && node.component && ["Move to another middleware…", () => moveTo(node.name, undefined, node.component.backend, all)]], back);
  }

  function goTo(address) {
    history.pushState(null, "", pageOf(parts(address).component));
    dispatchEvent(new PopStateEvent("popstate"));
  }

  // Choosing ends.

  /** Shows which ends fit this one. */
  function mark(port) {
    for (const { port: other } of drawing.ports.values()) {
      const fits = port.remote ? other.service : isEnd(other);
      if (!fits) continue;
      const [from, to] = ordered(port, other);
      drawing.find(other.key)?.classList.add(mismatch(from, to) ? "unfit" : "fits");
    }
    drawing.find(port.key)?.classList.add("picked");
  }
  function unmark() {
    for (const one of canvas.querySelectorAll(".fits, .unfit, .picked")) one.classList.remove("fits", "unfit", "picked");
  }

  function choose(port) {
    if (picked && (isEnd(port) || (picked.remote && port.service))) {
      const [from, to] = ordered(picked, port);
      drop();
      return reconnect(from, to);
    }
    if (!mayWire || !isStart(port)) return look(port);
    drop();
    picked = port;
    mark(port);
    put(status, name(port.address), ` is chosen: press Enter on ${port.remote ? "a service" : "an in port"}, or Escape.`);
  }

  function drop() {
    picked = null;
    unmark();
  }

  function look(port) {
    const now = ends.of(port);
    if (now && mayWire) return openMenu(port.key);
    put(status, name(port.address), now ? [" reads ", name(now.out)] : port.way === "in" ? " is not connected." : "",
      mayWire && !now && port.way === "in" ? " Choose an out port first." : "");
  }

  pointer(canvas, view, line, {
    begin(id, event) {
      if (!mayWire) return undefined;
      const port = ends.at(id);
      if (port && isStart(port) && !port.remote) {
        dragged = { port };
        return { at: drawing.anchor(id) };
      }
      // An end that is connected comes off: of its connection, or of its in port.
      const edge = id.startsWith("edge ") && drawing.edges.get(id.slice(5));
      const one = edge ? !edge.foreign && edge.list.length === 1 && edge.list[0] : port && ends.of(port);
      if (one && (!edge || nearEnd(event, edge))) {
        dragged = { port: ends.source(one), moved: one };
        const from = drawing.anchor(`${one.kind === "service" ? "service" : "out"} ${one.out}`);
        return { at: from ?? view.point(event) };
      }
      if (!port?.remote) return undefined;
      dragged = { port };
      return { at: drawing.anchor(id) };
    },
    over(id) {
      if (id === undefined) return mark(dragged.port);
      const other = ends.at(id);
      const [from, to] = other ? ordered(dragged.port, other) : [];
      const why = other && (isEnd(other) || other.service) && mismatch(from, to);
      put(status, why ? el("span", { class: "bad" }, why) : other ? [name(dragged.port.address), " → ", name(other.address)] : "");
    },
    drop(id) {
      const { port, moved } = dragged ?? {};
      dragged = null;
      later();
      unmark();
      const other = id && ends.at(id);
      const node = id && (drawing.ports.get(id)?.node ?? drawing.nodes.get(id.replace(/^fold /, "")));
      // A remote may be dropped on a service, or anywhere on the component that has it.
      const remote = port?.remote ? port : moved?.kind === "service" ? ends.reader(moved) : undefined;
      if (remote && other?.service) return reconnect(other, remote);
      if (remote && !other?.remote && node?.component) return callOf(node.name, remote);
      if (!other || !port || !isEnd(other)) return undefined;
      const [from, to] = ordered(port, other);
      return moved ? move(moved, from, to, told.connections) : reconnect(from, to);
    },
    click(id, event) {
      const port = ends.at(id);
      if (id.startsWith("edge ")) openMenu(id, { x: event.clientX, y: event.clientY });
      else if (id.startsWith("fold ")) fold(id.slice(5), !drawing.nodes.get(id.slice(5)).folded);
      else if (port) picked || port.way === "in" ? choose(port) : look(port);
      else if (drawing.nodes.get(id)?.kind !== "component") openMenu(id, { x: event.clientX, y: event.clientY });
    },
    menu: openMenu,
  });

  async function callOf(component, remote) {
    pick("Call a service", remote.address, likely(remote, await servicesOf(component)), (service) => reconnect(service, remote));
  }

  function nearEnd(event, edge) {
    const at = view.point(event);
    const far = ({ node, port }, side) => {
      const box = drawing.place(node);
      const end = drawing.anchor(port) ?? { x: box.x + (side === "out" ? box.width : 0), y: box.y + box.height / 2 };
      return Math.hypot(end.x - at.x, end.y - at.y);
    };
    return far(edge.to, "in") < far(edge.from, "out");
  }

  canvas.addEventListener("keydown", (event) => {
    const id = event.target.closest("[data-key]")?.dataset.key;
    if (!id || event.ctrlKey || event.metaKey || event.altKey) return;
    const port = ends.at(id);
    const edge = id.startsWith("edge ") && drawing.edges.get(id.slice(5));
    const now = edge ? edge.list.length === 1 && !edge.foreign && edge.list[0] : port && ends.of(port);
    if (event.key === "Escape" && picked) {
      drop();
      put(status, "Nothing is chosen.");
    } else if (event.key.startsWith("Arrow")) {
      const to = next(id, event.key, drawing);
      if (to) walk(to);
    } else if (event.key === "Delete" && now && mayWire) {
      disconnect(now);
    } else if (event.key === "ContextMenu" || event.key === "m" || event.key === "M" || (event.key === "F10" && event.shiftKey)) {
      openMenu(id);
    } else if (event.key === "Enter" || event.key === " ") {
      if (port) choose(port);
      else if (id.startsWith("fold ")) fold(id.slice(5), !drawing.nodes.get(id.slice(5)).folded);
      else if (edge || drawing.nodes.get(id)?.kind !== "component") openMenu(id);
      else return;
    } else {
      return;
    }
    event.preventDefault();
  });

  function walk(to) {
    focus(to);
    const at = drawing.anchor(to);
    const box = at ? { x: at.x - 100, y: at.y - 20, width: 200, height: 40 } : drawing.place(to);
    if (box) view.reveal(box);
  }

  canvas.addEventListener("pointerover", (event) => drawing.light(event.target.closest?.("[data-id]")?.dataset.id));
  canvas.addEventListener("pointerleave", () => drawing.light(undefined));
  canvas.addEventListener("focusin", (event) => drawing.light(event.target.closest("[data-id]")?.dataset.id));
  const resized = new ResizeObserver(() => {
    view.resize();
    shape = "";
    later();
  });
  resized.observe(canvas);

  // What the daemon tells.

  async function lookAround() {
    if (!document.hidden && !stopped) {
      try {
        told.middlewares = (await get("/middlewares?visible=true")).middlewares;
      } catch {
        // The live stream says when the daemon is away.
      }
      awaited.delete("middlewares");
      later();
    }
    if (!stopped && context.stillShown()) looking = setTimeout(lookAround, LOOKS);
  }
  let looking = setTimeout(lookAround, 0);

  const good = (what, take) => (body, code) => {
    awaited.delete(what);
    if (code !== 200) return;
    take(body);
    later();
  };
  context.watch([
    { path: "/components", take: good("components", (body) => {
      told.components = body.components;
      numbers = new Map(body.components.map((one) => [one.name, one.activities]));
    }) },
    { path: "/connections", take: good("connections", (body) => { told.connections = body.connections; }) },
    { path: "/ports?values=false", take: good("ports", (body) => {
      told.ports = body.ports;
      rates.take(body.ports);
    }) },
  ], 4);
  return () => {
    stopped = true;
    clearTimeout(looking);
    resized.disconnect();
    closeMenu();
  };
}
