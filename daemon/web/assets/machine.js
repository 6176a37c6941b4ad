// The state machine of an activity: a node for each state with its codel, drawn from the
// description; the state in which an activity is now is lit.

import { svg } from "./dom.js";

const HEIGHT = 46;
const ROW = 82;
const GAP = 64;

/** Number of drawings: each has a name of its own for its arrow. */
let machines = 0;

/** States and the ways between them, of codels with `on` and `yields`. */
export function machine(codels) {
  const states = new Map();
  const state = (named) => {
    if (!states.has(named)) states.set(named, { name: named, codels: [], to: [] });
    return states.get(named);
  };
  for (const codel of codels) {
    for (const on of codel.on ?? []) {
      const from = state(on);
      from.codels.push(codel.name);
      for (const yielded of codel.yields ?? []) {
        const waits = yielded.startsWith("pause::");
        const to = yielded.replace(/^pause::/, "");
        state(to);
        from.to.push({ to, waits });
      }
    }
  }
  return states;
}

/** Columns by distance from `start`; what is entered otherwise (`stop`, events) begins rows below. */
function place(states) {
  const at = new Map();
  let row = 0;
  const from = (begin) => {
    let column = 0;
    let front = [begin];
    let used = 0;
    while (front.length > 0) {
      const next = [];
      front.forEach((named, index) => {
        at.set(named, { column, row: row + index });
        used = Math.max(used, index + 1);
        for (const { to } of states.get(named).to) {
          if (!at.has(to) && !next.includes(to) && !front.includes(to) && to !== "ether") next.push(to);
        }
      });
      front = next.filter((named) => !at.has(named));
      column += 1;
    }
    row += used;
  };
  for (const begin of ["start", "stop", ...states.keys()]) {
    if (states.has(begin) && begin !== "ether" && !at.has(begin)) from(begin);
  }
  const columns = Math.max(0, ...[...at.values()].map(({ column }) => column + 1));
  if (states.has("ether")) at.set("ether", { column: columns, row: Math.max(0, (row - 1) / 2) });
  return { at, rows: Math.max(1, row) };
}

const short = (text, most) => text.length > most ? `${text.slice(0, most - 1)}…` : text;

/** `{ node, light(states) }`: the drawing, and what shows where activities are. */
export function drawing(label, codels) {
  const states = machine(codels);
  const { at, rows } = place(states);
  const widths = [];
  for (const [named, { column }] of at) {
    const longest = Math.max(named.length * 8.4, ...states.get(named).codels.map((one) => Math.min(one.length, 24) * 6.6));
    widths[column] = Math.max(widths[column] ?? 64, longest + 24);
  }
  const lefts = [];
  widths.reduce((left, width, column) => {
    lefts[column] = left;
    return left + width + GAP;
  }, 14);
  const spot = (named) => {
    const { column, row } = at.get(named);
    const width = widths[column];
    const y = row * ROW + 40;
    return { x: lefts[column], y, width, right: lefts[column] + width, middle: y + HEIGHT / 2 };
  };
  const width = lefts.at(-1) + widths.at(-1) + 14;
  const height = rows * ROW + 30;
  const edges = svg("g", { class: "ways" });
  const nodes = svg("g");
  const lit = new Map();
  for (const [named, { to: ways }] of states) {
    for (const { to, waits } of ways) edges.append(way(spot(named), spot(to), named === to, waits));
  }
  for (const [named, { codels: own }] of states) {
    const { x, y, width: wide } = spot(named);
    const end = named === "ether";
    const node = svg("g", { class: `state${end ? " end" : ""}`, "data-state": named },
      svg("title", {}, end ? "ether: the activity has ended" : `${named}: ${own.join(", ") || "no codel"}`),
      svg("rect", { x, y, width: wide, height: HEIGHT, rx: end ? HEIGHT / 2 : 9 }),
      svg("text", { x: x + wide / 2, y: y + (own.length ? 19 : 28), class: "what" }, named),
      own.length > 0 && svg("text", { x: x + wide / 2, y: y + 36, class: "codel" }, short(own.join(", "), 24)));
    lit.set(named, node);
    nodes.append(node);
  }
  const mark = `arrow-${machines += 1}`;
  for (const edge of edges.children) edge.setAttribute("marker-end", `url(#${mark})`);
  const node = svg("svg", { class: "machine", viewBox: `0 0 ${width} ${height}`, width, height, role: "img", "aria-label": label },
    svg("defs", {}, svg("marker", { id: mark, viewBox: "0 0 8 8", refX: 7, refY: 4, markerWidth: 7, markerHeight: 7, orient: "auto-start-reverse" },
      svg("path", { d: "M0 0 8 4 0 8z", class: "arrow" }))), edges, nodes);
  return {
    node,
    light(now) {
      for (const [named, shown] of lit) shown.classList.toggle("lit", now.has(named));
      node.setAttribute("aria-label", now.size > 0 ? `${label}: in ${[...now].join(", ")}` : label);
    },
  };
}

function way(from, to, own, waits) {
  let d;
  if (own) {
    const x = from.x + from.width / 2;
    d = `M${x - 18} ${from.y} C${x - 34} ${from.y - 34} ${x + 34} ${from.y - 34} ${x + 18} ${from.y}`;
  } else if (to.x > from.right) {
    const bend = Math.max(28, (to.x - from.right) / 2);
    d = `M${from.right} ${from.middle} C${from.right + bend} ${from.middle} ${to.x - bend} ${to.middle} ${to.x} ${to.middle}`;
  } else if (to.x === from.x) {
    const x = from.x + from.width / 2;
    const down = to.y > from.y;
    d = `M${x} ${down ? from.y + HEIGHT : from.y} L${x} ${down ? to.y : to.y + HEIGHT}`;
  } else {
    const low = Math.max(from.y, to.y) + HEIGHT + 22;
    d = `M${from.x + from.width / 2} ${from.y + HEIGHT} C${from.x} ${low} ${to.x + to.width} ${low} ${to.x + to.width / 2} ${to.y + HEIGHT}`;
  }
  return svg("path", { d, class: waits ? "way waits" : "way" }, svg("title", {}, waits ? "at the next tick or event" : "at once"));
}
