// The graph of components: ports and connections, which are made by dragging from an out port to an
// in port, or with the keyboard, and removed by choosing them.

import { path, post, remove, told } from "./api.js";
import { el, name, note, pageOf, put, svg, visible } from "./dom.js";
import { ROW, TITLE, WIDTH, heightOf, layout } from "./layout.js";
import { parts } from "./port.js";
import { frequency, middlewares } from "./units.js";

/** Colours of middlewares, by their names; others take the last. */
const COLORS = { local: 1, shm: 2, zenoh: 3, ros2: 4 };
/** The port that every component has, which says how it is. */
const STATE = "genom_state";

const color = (backend) => `m${COLORS[backend] ?? 5}`;
const short = (text, most) => text.length > most ? `${text.slice(0, most - 1)}…` : text;

export async function graph(page, context) {
  const edgesLayer = svg("g");
  const nodesLayer = svg("g");
  const drag = svg("path", { class: "dragged", hidden: true });
  const canvas = svg("svg", { id: "graph", class: "graph", role: "group", "aria-label": "Graph of components" }, edgesLayer, nodesLayer, drag);
  const status = el("p", { class: "soft", role: "status", id: "graph-status" });
  const withState = el("input", { type: "checkbox", id: "with-state" });
  const button = (text, label, act) => el("button", { type: "button", "aria-label": label, title: label, onclick: act }, text);
  const key = el("ul", { class: "legend", "aria-label": "Colours of middlewares" });
  put(page, el("div", { class: "title" }, el("h1", {}, "Graph"), el("span", { class: "gap" }),
    button("−", "Smaller", () => zoom(1.25)), button("+", "Larger", () => zoom(0.8)), button("Fit", "Show everything", () => { moved = false; fit(); })),
  el("p", { class: "soft" }, context.may("wire")
    ? "Drag from an out port to an in port to connect them, or press Enter on both. Choose a connection to remove it."
    : "Your rights do not allow to connect."),
  el("div", { class: "row" }, key, el("span", { class: "field inline" }, withState, el("label", { for: "with-state" }, "State ports"))),
  canvas, status);

  let ports = [];
  let connections = [];
  let components = [];
  let shape = "";
  let places = new Map();
  let picked = null;
  let view = null;
  // Rows of ports of each component; whether the user chose what is seen.
  let nodeRows = new Map();
  let moved = false;
  const nodes = new Map();
  const rates = new Map();
  const anchors = new Map();

  withState.addEventListener("change", draw);

  const isShown = (port) => withState.checked || port.name !== STATE;

  /** Draws all anew where components, ports or connections changed; else only numbers. */
  function draw() {
    const known = new Set(components.map((one) => one.name));
    const mine = ports.filter((port) => known.has(parts(port.address).component));
    const now = JSON.stringify([withState.checked, components.map((one) => [one.name, one.state, one.remotes]),
      mine.map((port) => [port.address, port.backend]), connections]);
    if (now !== shape) {
      shape = now;
      redraw(mine);
    }
    drawRates();
  }

  function redraw(mine) {
    const focused = document.activeElement?.getAttribute?.("data-key");
    const by = new Map(components.map((one) => [one.name, { in: [], out: [] }]));
    for (const port of mine.filter(isShown)) by.get(parts(port.address).component)[port.direction].push(port);
    for (const one of components) {
      for (const remote of one.remotes ?? []) by.get(one.name).in.push({ address: `${one.name}/${remote}`, name: remote, remote: true, backend: one.backend });
    }
    const rows = (id) => Math.max(by.get(id).in.length, by.get(id).out.length);
    const ends = connections.map((one) => [parts(one.out).component, parts(one.in).component]).filter((pair) => pair.every((id) => by.has(id)));
    nodeRows = new Map(components.map(({ name: id }) => [id, rows(id)]));
    places = layout(components.map(({ name: id }) => ({ id, rows: rows(id) })), ends);
    nodesLayer.replaceChildren();
    edgesLayer.replaceChildren();
    nodes.clear();
    anchors.clear();
    for (const one of components) nodesLayer.append(nodeOf(one, by.get(one.name)));
    rates.clear();
    for (const one of connections) {
      const edge = edgeOf(one);
      if (edge) edgesLayer.append(edge);
    }
    const backends = [...new Set(connections.map((one) => one.backend ?? "local"))].sort();
    put(key, backends.map((backend) => el("li", {}, el("span", { class: `key ${color(backend)}` }), name(backend))));
    if (!moved) fit();
    if (focused) canvas.querySelector(`[data-key="${CSS.escape(focused)}"]`)?.focus();
    put(status, `${components.length} components, ${connections.length} connections`);
  }

  function nodeOf(one, its) {
    const { x, y } = places.get(one.name);
    const height = heightOf(Math.max(its.in.length, its.out.length));
    const title = svg("a", { href: pageOf(one.name), "data-within": true, "data-key": `c ${one.name}` },
      svg("text", { x: 12, y: 22, class: "what" }, short(visible(one.name, 60), 22)), svg("title", {}, one.name));
    const node = svg("g", { class: `component${one.state === "running" ? "" : " bad"}`, transform: `translate(${x} ${y})`, "data-node": one.name },
      svg("rect", { width: WIDTH, height, rx: 10 }), title,
      one.state !== "running" && svg("text", { x: WIDTH - 12, y: 22, class: "state" }, short(one.state, 10)),
      svg("line", { x1: 0, x2: WIDTH, y1: TITLE - 3, y2: TITLE - 3 }));
    for (const [direction, list] of Object.entries(its)) {
      list.forEach((port, at) => node.append(portOf(port, direction, x, y, at)));
    }
    nodes.set(one.name, node);
    return node;
  }

  function portOf(port, direction, x, y, at) {
    const out = direction === "out";
    const middle = TITLE + at * ROW + ROW / 2;
    const edge = out ? WIDTH : 0;
    anchors.set(port.address, { x: x + edge, y: y + middle });
    const own = port.address.split("/").slice(1).join("/");
    const label = port.remote ? `remote ${port.address}` : `${direction} port ${port.address}, type ${port.type}`;
    const made = svg("g", { class: `port ${direction}${port.remote ? " remote" : ""}`, tabindex: 0, role: "button", "aria-label": label,
      "data-port": port.address, "data-direction": direction, "data-digest": port.digest, "data-key": `p ${port.address}` },
    svg("title", {}, label),
    svg("rect", { class: "hit", x: out ? WIDTH / 2 : 0, y: middle - ROW / 2, width: WIDTH / 2, height: ROW }),
    svg("circle", { cx: edge, cy: middle, r: 6, class: color(middlewares(port.backend)[0]) }),
    svg("text", { x: out ? WIDTH - 13 : 13, y: middle + 4, "text-anchor": out ? "end" : "start" }, short(visible(own, 60), 15)));
    made.addEventListener("keydown", (event) => portKey(event, port, direction));
    if (out && context.may("wire")) made.addEventListener("pointerdown", (event) => begin(event, port));
    if (!out) made.addEventListener("click", () => picked ? choose(port) : look(port));
    return made;
  }

  function edgeOf(one) {
    // The service of a remote has no place of its own: the edge ends at its component.
    const from = anchors.get(one.out) ?? titleOf(parts(one.out).component);
    const to = anchors.get(one.in);
    if (!from || !to) return null;
    const d = curve(from, to);
    const level = to.x < from.x + 20 ? below(from, to) : (from.y + to.y) / 2;
    const rate = svg("text", { x: (from.x + to.x) / 2, y: level - 6, class: "rate" });
    rates.set(one.in, rate);
    const label = `connection from ${one.out} to ${one.in}, ${one.backend ?? "same daemon"}${one.policy ? `, ${one.policy}` : ""}`;
    const open = (event) => {
      event.preventDefault();
      disconnect(one);
    };
    const made = svg("g", { class: `edge ${one.kind} ${color(one.backend ?? "local")}`, tabindex: 0, role: "button", "aria-label": label,
      "data-edge": one.in, "data-key": `e ${one.in}` },
    svg("title", {}, label), svg("path", { d, class: "hit" }), svg("path", { d, class: "line" }), rate);
    made.addEventListener("click", open);
    made.addEventListener("contextmenu", open);
    made.addEventListener("keydown", (event) => ["Enter", " ", "Delete"].includes(event.key) && open(event));
    return made;
  }

  const titleOf = (id) => places.has(id) && { x: places.get(id).x + WIDTH, y: places.get(id).y + TITLE / 2 };

  /** How low a way against the flow goes: below both of its components. */
  function below(from, to) {
    const ends = [...places].filter(([, { x }]) => x === to.x || x + WIDTH === from.x)
      .map(([id, { y }]) => y + heightOf(nodeRows.get(id)));
    const near = ends.filter((bottom) => bottom > Math.min(from.y, to.y)).sort((one, other) => one - other);
    return Math.max(from.y, to.y, near[0] ?? 0, near.at(-1) < Math.max(from.y, to.y) + 200 ? near.at(-1) : 0) + 34;
  }

  function curve(from, to) {
    if (to.x < from.x + 20) {
      const low = below(from, to);
      return `M${from.x} ${from.y} C${from.x + 80} ${from.y} ${from.x + 80} ${low} ${from.x} ${low}`
        + ` L${to.x} ${low} C${to.x - 80} ${low} ${to.x - 80} ${to.y} ${to.x} ${to.y}`;
    }
    const bend = Math.max(50, Math.abs(to.x - from.x) / 2);
    return `M${from.x} ${from.y} C${from.x + bend} ${from.y} ${to.x - bend} ${to.y} ${to.x} ${to.y}`;
  }

  // Rates, as differences of counters.
  const history = new Map();
  function drawRates() {
    const now = performance.now();
    for (const port of ports) {
      const samples = port.traffic?.samples;
      if (samples === undefined) continue;
      const past = (history.get(port.address) ?? []).filter(([at]) => now - at < 3000);
      past.push([now, samples]);
      history.set(port.address, past);
    }
    for (const one of connections) {
      const past = history.get(one.out) ?? history.get(one.in);
      const text = rates.get(one.in);
      if (!text || !past || past.length < 2) continue;
      const [[begin, first], [end, last]] = [past[0], past.at(-1)];
      if (end - begin > 400) put(text, frequency(1000 * Math.max(0, last - first) / (end - begin)));
    }
  }

  // Dragging.
  const point = (event) => {
    const box = canvas.getBoundingClientRect();
    const scale = Math.max(view.width / box.width, view.height / box.height);
    return {
      x: view.x + view.width / 2 + (event.clientX - box.left - box.width / 2) * scale,
      y: view.y + view.height / 2 + (event.clientY - box.top - box.height / 2) * scale,
    };
  };

  function begin(event, port) {
    if (event.button !== 0) return;
    event.preventDefault();
    event.stopPropagation();
    const from = anchors.get(port.address);
    mark(port);
    const move = (now) => {
      drag.removeAttribute("hidden");
      const to = point(now);
      drag.setAttribute("d", `M${from.x} ${from.y} L${to.x} ${to.y}`);
    };
    const end = (now) => {
      removeEventListener("pointermove", move);
      removeEventListener("pointerup", end);
      removeEventListener("pointercancel", end);
      drag.setAttribute("hidden", "");
      unmark();
      const at = now.type === "pointerup" && document.elementFromPoint(now.clientX, now.clientY)?.closest?.("[data-port]");
      if (at && at.dataset.direction === "in") connect(port.address, at.dataset.port);
    };
    addEventListener("pointermove", move);
    addEventListener("pointerup", end);
    addEventListener("pointercancel", end);
  }

  /** Shows which in ports have the type of this out port. */
  function mark(port) {
    for (const one of nodesLayer.querySelectorAll(".port.in")) {
      one.classList.add(one.dataset.digest === port.digest ? "fits" : "unfit");
    }
  }
  function unmark() {
    for (const one of nodesLayer.querySelectorAll(".fits, .unfit")) one.classList.remove("fits", "unfit");
    for (const one of nodesLayer.querySelectorAll(".picked")) one.classList.remove("picked");
  }

  // The keyboard.
  function portKey(event, port, direction) {
    if (event.key === "Escape" && picked) {
      picked = null;
      unmark();
      put(status, "Nothing is chosen.");
    }
    if (event.key === "Delete" && direction === "in") return look(port);
    if (event.key !== "Enter" && event.key !== " ") return;
    event.preventDefault();
    if (direction === "out") {
      if (!context.may("wire")) return;
      unmark();
      picked = port;
      mark(port);
      event.currentTarget.classList.add("picked");
      put(status, name(port.address), " is chosen: press Enter on an in port, or Escape.");
    } else if (picked) {
      choose(port);
    } else {
      look(port);
    }
  }

  function choose(port) {
    const from = picked;
    picked = null;
    unmark();
    connect(from.address, port.address);
  }

  /** What an in port or a remote is connected to, with the way to remove it. */
  function look(port) {
    const found = connections.find((one) => one.in === port.address);
    if (found) disconnect(found);
    else put(status, name(port.address), " is not connected. Choose an out port first.");
  }

  // Dialogs.
  function ask(title, fields, verb, act) {
    const problem = el("p", { class: "error", role: "alert" });
    const dialog = el("dialog", { "aria-labelledby": "dialog-title" },
      el("form", { method: "dialog" }, el("h2", { id: "dialog-title" }, title), fields, problem,
        el("div", { class: "row" }, el("button", { type: "submit", class: "main" }, verb),
          el("button", { type: "button", onclick: () => dialog.close() }, "Cancel"))));
    dialog.querySelector("form").addEventListener("submit", async (event) => {
      event.preventDefault();
      put(problem);
      try {
        await act();
        dialog.close();
      } catch (error) {
        put(problem, told(error));
      }
    });
    dialog.addEventListener("close", () => dialog.remove());
    page.append(dialog);
    dialog.showModal();
  }

  function connect(from, to) {
    const policy = el("select", { id: "policy" }, ["latest", "queue", "ring"].map((one) => el("option", { value: one }, one)));
    const size = el("input", { id: "size", type: "number", min: 1, max: 65536, value: "10" });
    const sized = el("div", { class: "field", hidden: true }, el("label", { for: "size" }, "Samples kept"), size);
    policy.addEventListener("change", () => { sized.hidden = policy.value === "latest"; });
    const backend = el("input", { id: "backend", type: "text", autocomplete: "off", placeholder: "that of the out port" });
    const fields = [
      el("p", {}, name(from), " → ", name(to)),
      el("div", { class: "field" }, el("label", { for: "policy" }, "Policy"), policy, el("span", { class: "help" }, "which unread samples the reader gets")),
      sized,
      el("div", { class: "field" }, el("label", { for: "backend" }, "Middleware"), backend),
    ];
    ask("Connect", fields, "Connect", async () => {
      const request = { in: to, out: from, policy: policy.value === "latest" ? "latest" : `${policy.value}:${size.value}` };
      if (backend.value.trim()) request.backend = backend.value.trim();
      await post("/connections", JSON.stringify(request));
      note(`${to} reads ${from}`);
    });
  }

  function disconnect(one) {
    const about = [el("p", {}, name(one.out), " → ", name(one.in)),
      el("p", { class: "soft" }, [one.backend ?? "same daemon", one.policy].filter(Boolean).join(", "))];
    if (!context.may("wire")) return put(status, `${visible(one.out)} → ${visible(one.in)}`);
    ask("Disconnect", about, "Disconnect", async () => {
      const { component, port, element } = parts(one.in);
      await remove(path("connections", component, port, ...(element ? [element] : [])));
      note(`${one.in} is disconnected`);
    });
  }

  // The view.
  function fit() {
    const all = [...places].map(([id, { x, y }]) => ({ x, y, bottom: y + nodes.get(id).firstChild.height.baseVal.value }));
    if (all.length === 0) return;
    const x = Math.min(...all.map((one) => one.x)) - 90;
    const y = Math.min(...all.map((one) => one.y)) - 30;
    const box = canvas.getBoundingClientRect();
    const width = Math.max(...all.map((one) => one.x + WIDTH)) - x + 90;
    const height = Math.max(...all.map((one) => one.bottom)) - y + 60;
    // Few components are not blown up.
    const scale = Math.max(width / box.width, height / box.height, 0.9);
    const [wide, high] = [box.width * scale, box.height * scale];
    show({ x: x - (wide - width) / 2, y: y - (high - height) / 2, width: wide, height: high });
  }
  function show(next) {
    view = next;
    canvas.setAttribute("viewBox", `${view.x} ${view.y} ${view.width} ${view.height}`);
  }
  function zoom(by, around = { x: view?.x + view?.width / 2, y: view?.y + view?.height / 2 }) {
    if (!view || view.width * by > 60000 || view.width * by < 120) return;
    moved = true;
    show({ x: around.x - (around.x - view.x) * by, y: around.y - (around.y - view.y) * by, width: view.width * by, height: view.height * by });
  }
  canvas.addEventListener("wheel", (event) => {
    if (!event.ctrlKey && !event.metaKey) return;
    event.preventDefault();
    zoom(event.deltaY > 0 ? 1.12 : 0.89, point(event));
  }, { passive: false });
  canvas.addEventListener("pointerdown", (event) => {
    if (event.target !== canvas || !view) return;
    const start = { ...view };
    const scale = view.width / canvas.getBoundingClientRect().width;
    moved = true;
    const move = (now) => show({ ...start, x: start.x - (now.clientX - event.clientX) * scale, y: start.y - (now.clientY - event.clientY) * scale });
    const end = () => {
      removeEventListener("pointermove", move);
      removeEventListener("pointerup", end);
    };
    addEventListener("pointermove", move);
    addEventListener("pointerup", end);
  });

  const good = (take) => (body, status_) => status_ === 200 && take(body);
  context.watch([
    { path: "/components", take: good((body) => { components = body.components; draw(); }) },
    { path: "/connections", take: good((body) => { connections = body.connections; draw(); }) },
    { path: "/ports?values=false", take: good((body) => { ports = body.ports; draw(); }) },
  ], 4);
}
