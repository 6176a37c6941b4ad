// The drawing of a scene. What did not change is left as it is.

import { pageOf, svg, visible } from "./dom.js";
import { ROW, TITLE, WIDTH, heightOf, layout } from "./layout.js";
import { middlewares } from "./units.js";
import { route } from "./wires.js";

/** Colours of middlewares, by their names; others take the last. */
const COLORS = { local: 1, shm: 2, zenoh: 3, ros2: 4 };
export const color = (backend) => `m${COLORS[backend] ?? 5}`;
const short = (text, most) => text.length > most ? `${text.slice(0, most - 1)}…` : text;
/** Room for a connection at the side of a folded node. */
const BETWEEN = 10;

export class Drawing {
  #edges = svg("g");
  // Apart from their connections, whose names for screen readers do not change all the time.
  #rates = svg("g", { "aria-hidden": "true" });
  #nodes = svg("g");
  #shown = new Map();
  #lines = new Map();
  #anchors = new Map();
  #beside = new Map();
  #places = new Map();
  /** What moves as a whole. */
  layer = svg("g", {}, this.#edges, this.#rates, this.#nodes);
  /** `{ port, node }` of each row, and edges, by their keys. */
  ports = new Map();
  edges = new Map();
  nodes = new Map();

  /** Draws `{ nodes, edges }` for a place that is `aspect` times as wide as high. */
  draw({ nodes, edges }, aspect) {
    const { height, ends } = heights(nodes, edges);
    const wanted = edges.map((one) => ({ from: one.from.node, to: one.to.node, via: one.from.port ?? one.from.node,
      out: ends.get(one).out, in: ends.get(one).in }));
    const { places, stops, dense } = layout(nodes.map(({ id }) => ({ id, height: height.get(id) })), wanted, aspect);
    this.#places = new Map(nodes.map(({ id }) => [id, { ...places.get(id), width: WIDTH, height: height.get(id) }]));
    spread(nodes, edges, ends, this.#places);
    this.ports = new Map(nodes.flatMap((node) => [...node.rows.in, ...node.rows.out].map((port) => [port.key, { port, node }])));
    this.edges = new Map(edges.map((one) => [one.key, one]));
    this.nodes = new Map(nodes.map((node) => [node.id, node]));
    this.#anchors.clear();
    this.layer.classList.toggle("crowded", Boolean(dense));
    const focused = document.activeElement?.getAttribute?.("data-key");
    this.#drawNodes(nodes);
    this.#drawEdges(edges, ends, stops);
    if (focused && document.activeElement?.getAttribute?.("data-key") !== focused) this.find(focused)?.focus({ preventScroll: true });
  }

  #drawNodes(nodes) {
    const gone = new Set(this.#shown.keys());
    for (const node of nodes) {
      const place = this.#places.get(node.id);
      const drawn = JSON.stringify([node, place.height], (key, value) => ["connected", "traffic", "words", "activities"].includes(key) ? undefined : value);
      let shown = this.#shown.get(node.id);
      if (shown?.drawn !== drawn) {
        const made = nodeOf(node, place.height);
        if (shown) shown.made.replaceWith(made);
        else this.#nodes.append(made);
        shown = { made, drawn, work: made.querySelector(".work-now") };
        this.#shown.set(node.id, shown);
      }
      gone.delete(node.id);
      const at = `translate(${place.x} ${place.y})`;
      if (shown.at !== at) shown.made.setAttribute("transform", at);
      shown.at = at;
      for (const side of ["in", "out"]) {
        node.rows[side].forEach(({ key }, row) => this.#anchors.set(key, { x: place.x + (side === "out" ? WIDTH : 0), y: place.y + middle(row) }));
      }
    }
    for (const id of gone) {
      this.#shown.get(id).made.remove();
      this.#shown.delete(id);
    }
  }

  #drawEdges(edges, ends, stops) {
    const gone = new Set(this.#lines.keys());
    this.#beside.clear();
    edges.forEach((one, index) => {
      const [source, target] = [this.#places.get(one.from.node), this.#places.get(one.to.node)];
      const from = { x: source.x + WIDTH, y: source.y + ends.get(one).out };
      const to = { x: target.x, y: target.y + ends.get(one).in };
      const d = route(from, stops[index], to);
      const label = visible(about(one));
      let line = this.#lines.get(one.key);
      if (!line) {
        line = lineOf(one);
        this.#lines.set(one.key, line);
        this.#edges.append(line.made);
        this.#rates.append(line.rate);
      }
      gone.delete(one.key);
      line.one = one;
      if (line.d !== d) {
        line.d = d;
        for (const path of line.paths) path.setAttribute("d", d);
        [line.x, line.y] = [to.x - 13, to.y - 5];
        line.rate.setAttribute("x", line.x);
        line.rate.setAttribute("y", line.y);
      }
      if (line.label !== label) {
        line.label = label;
        line.made.setAttribute("aria-label", label);
        line.title.textContent = label;
      }
      line.rate.classList.toggle("dense", Boolean(ends.get(one).dense));
      for (const { node } of [one.from, one.to]) {
        if (!this.#beside.has(node)) this.#beside.set(node, []);
        this.#beside.get(node).push(line);
      }
    });
    for (const key of gone) {
      this.#lines.get(key).made.remove();
      this.#lines.get(key).rate.remove();
      this.#lines.delete(key);
    }
  }

  /** Writes rates at edges, and how many activities run, where they changed. */
  tell(rateOf, activities) {
    for (const line of this.#lines.values()) {
      const text = rateOf(line.one);
      if (line.told !== text) {
        line.told = text;
        line.text.data = text;
      }
    }
    for (const [id, { work, told }] of this.#shown) {
      const count = activities(this.nodes.get(id));
      const text = count > 0 ? `▸ ${count}` : "";
      if (!work || told === text) continue;
      work.firstChild.data = text;
      this.#shown.get(id).told = text;
    }
  }

  /** Leaves out the texts of what is not in `box`: laying them out costs most when the scale changes. */
  cull(box) {
    const out = (x, y, width, height) => x > box.x + box.width || y > box.y + box.height || x + width < box.x || y + height < box.y;
    const tell = (one, node, is) => {
      if (one.away === is) return;
      one.away = is;
      node.classList.toggle("away", is);
    };
    for (const [id, shown] of this.#shown) {
      const { x, y, width, height } = this.#places.get(id);
      tell(shown, shown.made, out(x, y, width, height));
    }
    for (const line of this.#lines.values()) tell(line, line.rate, out(line.x - 80, line.y - 20, 80, 20));
  }

  /** Lights the connections of a node; `undefined` puts all out. */
  light(node) {
    if (this.lit === node) return;
    const all = (id, on) => {
      for (const { made, rate } of this.#beside.get(id) ?? []) for (const one of [made, rate]) one.classList.toggle("lit", on);
    };
    all(this.lit, false);
    this.lit = node;
    all(node, true);
  }

  /** The place of a row, and the box of a node, in the drawing. */
  anchor = (key) => this.#anchors.get(key);
  place = (id) => this.#places.get(id);
  find = (key) => this.layer.querySelector(`[data-key="${CSS.escape(key)}"]`);

  /** A box around everything. */
  bounds() {
    const all = [...this.#places.values()];
    if (all.length === 0) return { x: 0, y: 0, width: 1, height: 1 };
    const [x, y] = [Math.min(...all.map((one) => one.x)) - 70, Math.min(...all.map((one) => one.y)) - 30];
    const low = Math.max(...all.map((one) => one.y + one.height), ...[...this.#lines.values()].map((line) => lowest(line.d)));
    return { x, y, width: Math.max(...all.map((one) => one.x + WIDTH)) - x + 70, height: low - y + 30 };
  }
}

const middle = (row) => TITLE + row * ROW + ROW / 2;
/** The lowest horizontal piece of a line. */
const lowest = (d) => Math.max(-Infinity, ...[...d.matchAll(/ (-?[\d.]+) H/g)].map(([, y]) => Number(y)));

/** Height of each node, and how far below its top each edge begins and ends. */
function heights(nodes, edges) {
  const rows = new Map(nodes.flatMap((node) => ["in", "out"].flatMap((side) => node.rows[side].map(({ key }, row) => [key, middle(row)]))));
  const count = new Map();
  for (const { from, to } of edges) {
    for (const key of [!from.port && `out ${from.node}`, !to.port && `in ${to.node}`]) if (key) count.set(key, (count.get(key) ?? 0) + 1);
  }
  const height = new Map(nodes.map((node) => {
    const shown = node.folded ? 0 : Math.max(1, node.rows.in.length, node.rows.out.length);
    const most = Math.max(count.get(`in ${node.id}`) ?? 0, count.get(`out ${node.id}`) ?? 0);
    return [node.id, Math.max(heightOf(shown), Math.min(150, most * BETWEEN + 8))];
  }));
  const ends = new Map(edges.map((one) => [one, {
    out: rows.get(one.from.port) ?? height.get(one.from.node) / 2,
    in: rows.get(one.to.port) ?? height.get(one.to.node) / 2,
  }]));
  return { height, ends };
}

/** Spreads edges over the sides of folded nodes, in the order of their other ends. */
function spread(nodes, edges, ends, places) {
  for (const side of ["from", "to"]) {
    const [own, other, far] = side === "from" ? ["out", "to", "in"] : ["in", "from", "out"];
    const all = new Map();
    for (const one of edges) if (!one[side].port) all.set(one[side].node, [...(all.get(one[side].node) ?? []), one]);
    for (const [id, list] of all) {
      const height = places.get(id).height;
      const at = new Map(list.map((one) => [one, places.get(one[other].node).y + ends.get(one)[far]]));
      list.sort((one, next) => at.get(one) - at.get(next));
      list.forEach((one, index) => {
        ends.get(one)[own] = height * (index + 1) / (list.length + 1);
        if (side === "to") ends.get(one).dense = height / (list.length + 1) < 13;
      });
    }
  }
}

function nodeOf(node, height) {
  const { kind, component } = node;
  const well = kind !== "component" || component.state === "running";
  const under = { component: () => [component.component !== node.name && component.component, component.cell && `cell ${component.cell}`].filter(Boolean).join(" · "),
    cell: () => `cell, ${node.inside.length} ${node.inside.length === 1 ? "component" : "components"}`,
    peer: () => node.note ?? `on ${node.backend}, not of this daemon` }[kind]();
  const shown = visible(node.name, 60);
  // In a drawing that is small the name alone is there, as large as it fits.
  const size = Math.round(Math.max(20, Math.min(height > 100 && !node.folded ? 44 : 34, 340 / Math.max(4, Math.min(shown.length, 14)))));
  // Names are cut here, and whole in labels.
  const words = [svg("text", { x: 14, y: under ? 18 : 24, class: "what", "aria-hidden": "true" }, short(shown, 20)),
    svg("text", { x: WIDTH / 2, y: height / 2 + size * 0.35, class: `large s${size}`, "font-size": size, "aria-hidden": "true" }, short(shown, 14)),
    svg("title", {}, visible([node.name, under, component?.state].filter(Boolean).join(", ")))];
  const title = kind === "component"
    ? svg("a", { href: pageOf(node.name), "data-within": true, "data-key": node.id, "aria-label": `component ${shown}` }, words)
    : svg("g", { tabindex: 0, role: "button", "data-key": node.id, "aria-label": `${kind} ${shown}` }, words);
  const made = svg("g", { class: `node ${kind}${well ? "" : " bad"}${node.beside ? " beside" : ""}`, "data-node": node.name, "data-id": node.id },
    node.kind === "cell" && svg("rect", { class: "behind", x: 5, y: 5, width: WIDTH, height, rx: 9 }),
    svg("rect", { class: "body", width: WIDTH, height, rx: 9 }), title,
    under && svg("text", { x: 14, y: 32, class: "under" }, short(visible(under, 80), 30)),
    !well && svg("text", { x: WIDTH - 34, y: 18, class: "state" }, short(component.state, 12)),
    kind === "component" && svg("text", { x: WIDTH - 34, y: !well ? 32 : under ? 18 : 24, class: "work-now" }, document.createTextNode("")),
    kind !== "peer" && svg("g", { class: "fold", tabindex: -1, role: "button", "data-key": `fold ${node.id}`, "aria-expanded": String(!node.folded),
      "aria-label": `${node.folded ? "Unfold" : "Fold"} ${shown}` },
    svg("rect", { x: WIDTH - 28, y: 4, width: 24, height: TITLE - 10, rx: 5 }),
    svg("path", { d: node.folded ? `M${WIDTH - 19} 14 l5 4 l-5 4` : `M${WIDTH - 20} 16 l4 5 l4 -5` })),
    !node.folded && svg("line", { x1: 0, x2: WIDTH, y1: TITLE, y2: TITLE }));
  for (const side of ["in", "out"]) node.rows[side].forEach((port, row) => made.append(portOf(port, row)));
  return made;
}

function portOf(port, row) {
  const out = port.way === "out";
  const [y, edge] = [middle(row), out ? WIDTH : 0];
  const own = port.address.split("/").slice(1).join("/") || port.address;
  const what = port.remote ? "remote" : port.service ? "service" : `${port.way} port`;
  const label = visible(`${what} ${port.address}${port.type ? `, type ${port.type}` : ""}${port.foreign ? ", of another program" : ""}`);
  const kind = [port.way, port.remote && "remote", port.service && "service", port.awaited && "awaited"].filter(Boolean).join(" ");
  // Readers elsewhere have no names of their own.
  const isOurs = !(port.foreign && port.way === "in");
  return svg("g", { class: `port ${kind}`, tabindex: -1, role: "button", "aria-label": label, "data-key": port.key,
    "data-port": isOurs ? port.address : undefined, "data-direction": port.way },
  svg("title", {}, label),
  svg("rect", { class: "hit", x: out ? WIDTH / 2 : 0, y: y - ROW / 2, width: WIDTH / 2, height: ROW, rx: 4 }),
  port.service || port.remote
    ? svg("rect", { class: `end ${color(middlewares(port.backend)[0])}`, x: edge - 5, y: y - 5, width: 10, height: 10, rx: 2 })
    : svg("circle", { class: `end ${color(middlewares(port.backend)[0])}`, cx: edge, cy: y, r: 5.5 }),
  svg("text", { "aria-hidden": "true", x: out ? WIDTH - 14 : 14, y: y + 4, "text-anchor": out ? "end" : "start" },
    short(visible(port.foreign && !out ? port.address : own, 60), out || !port.foreign ? 15 : 24)));
}

/** A connection, or several between the same ends, as one text. */
export function about(one) {
  const [first] = one.list;
  if (one.foreign) return `${first.count > 1 ? `${first.count} readers` : "a reader"} of ${first.out} in other programs, on ${one.backend}`;
  const name = ({ out, in: into, backend, policy }) => `from ${out} to ${into}, ${[backend ?? "same daemon", policy].filter(Boolean).join(", ")}`;
  return one.list.length === 1 ? `connection ${name(first)}` : `${one.list.length} connections on ${one.backend}, the first ${name(first)}`;
}

function lineOf(one) {
  const title = svg("title");
  const paths = [svg("path", { class: "hit" }), svg("path", { class: "line" })];
  const text = document.createTextNode("");
  const rate = svg("text", { class: "rate" }, text);
  const made = svg("g", { class: `edge ${one.kind === "service" ? "call" : "flow"} ${color(one.backend)}${one.foreign ? " foreign" : ""}`, tabindex: -1, role: "button",
    "data-edge": one.list[0].in, "data-key": `edge ${one.key}` }, title, paths);
  return { made, title, paths, rate, text };
}
