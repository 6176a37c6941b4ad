// Places components in layers, so that data flows from left to right with few crossings, and leads
// connections around what lies between their ends.

import { level, order, under } from "./level.js";
import { Lanes, wire } from "./wires.js";

/** Width of a component, heights of its title and of a row of ports. */
export const WIDTH = 216;
export const TITLE = 38;
export const ROW = 24;
const GAP_X = 124;
const GAP_Y = 30;
/** A drawing that is this many times as wide as fits is cut into bands one below the other. */
const WIDEST = 1.7;
/** With more components than this, and as many layers between their ends for each, connections go straight. */
const MOST = 30;
const LONGEST = 5;

/** Height of a component with this many rows. */
export const heightOf = (rows) => rows === 0 ? TITLE + 4 : TITLE + rows * ROW + 8;

/**
 * `nodes`: `{ id, height }`. `edges`: `{ from, to, via, out, in }` with ids, what shares its way
 * with others (its out port), and how far below the tops of the nodes it begins and ends. `aspect`:
 * width by height of where it is shown.
 *
 * Returns the top left corner of each node, and for each edge the stops between its ends: `{ from,
 * to, y }`, horizontal pieces that it passes, from left to right or back. What is connected to
 * nothing comes last, in rows below.
 */
export function layout(nodes, edges, aspect) {
  const groups = apart(nodes, edges);
  const loose = groups.filter(({ ways }) => ways.length === 0).flatMap((group) => group.nodes);
  const made = groups.filter(({ ways }) => ways.length > 0).map((group) => flow(group, aspect));
  if (loose.length > 0) made.push(rows(loose, aspect));
  const places = new Map();
  const stops = new Map();
  for (const { part, x, y } of shelves(made, aspect)) {
    for (const [id, place] of part.places) places.set(id, { x: place.x - part.x + x, y: place.y - part.y + y });
    for (const [edge, list] of part.stops) {
      stops.set(edge, list.map((stop) => ({ from: stop.from - part.x + x, to: stop.to - part.x + x, y: stop.y - part.y + y })));
    }
  }
  return { places, stops: edges.map((edge) => stops.get(edge) ?? []), dense: made.some(({ dense }) => dense) };
}

/** Groups of nodes that edges lead between. */
function apart(nodes, edges) {
  const group = new Map(nodes.map((node) => [node.id, { nodes: [node], ways: [] }]));
  for (const edge of edges) {
    let [into, from] = [group.get(edge.from), group.get(edge.to)];
    if (!into || !from) continue;
    if (into !== from) {
      if (into.nodes.length < from.nodes.length) [into, from] = [from, into];
      for (const node of from.nodes) group.set(node.id, into);
      into.nodes.push(...from.nodes);
      into.ways.push(...from.ways);
    }
    into.ways.push(edge);
  }
  const order = new Map(nodes.map(({ id }, at) => [id, at]));
  const all = [...new Set(group.values())];
  for (const one of all) one.nodes.sort((node, other) => order.get(node.id) - order.get(other.id));
  return all;
}

/** Puts parts beside and below each other, so that they fill a place of this shape. */
function shelves(parts, aspect) {
  const area = parts.reduce((sum, { width, height }) => sum + (width + GAP_X) * (height + GAP_Y), 0);
  const wide = Math.max(Math.sqrt(area * aspect), ...parts.map(({ width }) => width));
  const placed = [];
  let [x, y, high] = [0, 0, 0];
  for (const part of parts) {
    if (x > 0 && x + part.width > wide * 1.1) [x, y, high] = [0, y + high + GAP_Y * 1.5, 0];
    placed.push({ part, x, y });
    x += part.width + GAP_X;
    high = Math.max(high, part.height);
  }
  return placed;
}

/** Places what is connected, in layers. */
function flow({ nodes, ways }, aspect) {
  const flowing = nodes.map((node) => ({ ...node, links: [] }));
  const layers = layered(flowing, forward(flowing, ways));
  if (flowing.length > MOST && passes(layers, ways) > flowing.length * LONGEST) return packed(layers, ways, aspect);
  const { found: wires, backs } = wire(layers, ways, WIDTH);
  order(layers);
  const reach = level(layers, GAP_Y);
  under(backs, reach, GAP_Y);
  for (const { item, index } of [...backs.values()].flat()) layers[index].push(item);
  const bands = cut(reach, aspect);
  const lanes = new Lanes(bands, WIDTH, GAP_X, GAP_Y);
  for (const { begin, end } of bands) {
    for (let at = begin; at < end; at += 1) for (const item of layers[at]) item.x = (at - begin) * (WIDTH + GAP_X);
  }
  const led = ways.map((edge) => [edge, lanes.lead(edge.via, wires.get(edge))]);
  lanes.open();
  bands.forEach((band) => layers.slice(band.begin, band.end).flat().forEach((item) => { item.y += band.shift; }));
  const stops = new Map(led.map(([edge, list]) => [edge, list.map((stop) => stop())]));
  return boxed(layers.flat(), stops);
}

/** A part with its outer measures. */
function boxed(items, stops, dense) {
  const [x, y] = [Math.min(...items.map((one) => one.x)), Math.min(...items.map((one) => one.y))];
  const below = Math.max(...items.map((one) => one.y + one.height), ...[...stops.values()].flat().map((stop) => stop.y));
  const places = new Map(items.filter(({ id }) => id !== undefined).map(({ id, ...place }) => [id, { x: place.x, y: place.y }]));
  return { places, stops, dense, x, y, width: Math.max(...items.map((one) => one.x)) + WIDTH - x, height: below - y };
}

/** The ways without those that close a circle. */
function forward(nodes, ways) {
  const out = new Map(nodes.map(({ id }) => [id, []]));
  for (const { from, to } of ways) out.get(from).push(to);
  const state = new Map();
  const kept = [];
  const visit = (id) => {
    // By hand instead of by recursion: a chain may be long.
    const stack = [[id, 0]];
    state.set(id, "open");
    while (stack.length > 0) {
      const top = stack.at(-1);
      const next = out.get(top[0])[top[1]];
      top[1] += 1;
      if (next === undefined) {
        state.set(top[0], "done");
        stack.pop();
      } else if (state.get(next) !== "open") {
        kept.push([top[0], next]);
        if (!state.has(next)) {
          state.set(next, "open");
          stack.push([next, 0]);
        }
      }
    }
  };
  for (const { id } of nodes) if (!state.has(id)) visit(id);
  return kept;
}

/** Layers by the longest way to each node; what nothing leads to stands just before what it feeds. */
function layered(nodes, ways) {
  const before = new Map(nodes.map(({ id }) => [id, 0]));
  const out = new Map(nodes.map(({ id }) => [id, []]));
  for (const [from, to] of ways) {
    before.set(to, before.get(to) + 1);
    out.get(from).push(to);
  }
  const first = nodes.map(({ id }) => id).filter((id) => before.get(id) === 0);
  const depth = new Map(nodes.map(({ id }) => [id, 0]));
  const ready = [...first];
  for (let at = 0; at < ready.length; at += 1) {
    for (const to of out.get(ready[at])) {
      depth.set(to, Math.max(depth.get(to), depth.get(ready[at]) + 1));
      before.set(to, before.get(to) - 1);
      if (before.get(to) === 0) ready.push(to);
    }
  }
  for (const id of first) {
    const next = out.get(id).map((to) => depth.get(to));
    if (next.length > 0) depth.set(id, Math.max(0, Math.min(...next) - 1));
  }
  const layers = [];
  for (const node of nodes) (layers[depth.get(node.id)] ??= []).push(node);
  return layers.filter(Boolean);
}

/** The bands that layers with these first and last heights are cut into. */
function cut(reach, aspect) {
  if (reach.length === 0) return [];
  const made = (per) => {
    const bands = [];
    let top = 0;
    for (let begin = 0; begin < reach.length; begin += per) {
      const inside = reach.slice(begin, begin + per);
      const high = Math.min(...inside.map(([first]) => first));
      const bottom = top + Math.max(...inside.map(([, last]) => last)) - high;
      bands.push({ begin, end: begin + inside.length, top, bottom, shift: top - high });
      top = bottom + GAP_Y * 2;
    }
    return bands;
  };
  const shape = (bands, per) => per * (WIDTH + GAP_X) / bands.at(-1).bottom;
  let best = made(reach.length);
  if (shape(best, reach.length) <= WIDEST * aspect || reach.length <= 5) return best;
  let least = Infinity;
  for (let per = reach.length; per > 2; per -= 1) {
    const bands = made(per);
    const off = Math.abs(Math.log(shape(bands, per) / aspect));
    if (off < least) [best, least] = [bands, off];
  }
  return best;
}

/** How many layers all edges together pass. */
function passes(layers, ways) {
  const at = new Map(layers.flatMap((layer, index) => layer.map(({ id }) => [id, index])));
  return ways.reduce((sum, { from, to }) => sum + Math.abs(at.get(to) - at.get(from)), 0);
}

/**
 * Very dense graphs have no room for ways around components: these stand close, in columns in the
 * order of the flow, and connections pass below them.
 */
function packed(layers, ways, aspect) {
  const all = layers.flat();
  const total = all.reduce((sum, { height }) => sum + height + GAP_Y, 0);
  const count = Math.max(1, Math.round(Math.sqrt(aspect * total / (WIDTH + GAP_X))));
  const columns = [[]];
  let full = 0;
  for (const item of all) {
    if (full + item.height / 2 > total / count && columns.length < count) {
      columns.push([]);
      full = 0;
    }
    columns.at(-1).push(item);
    full += item.height + GAP_Y;
  }
  const by = new Map(all.map((item) => [item.id, item]));
  for (const { from, to } of ways) {
    by.get(from).links.push({ to: by.get(to) });
    by.get(to).links.push({ to: by.get(from) });
  }
  order(columns);
  const high = Math.max(...columns.map((column) => column.reduce((sum, { height }) => sum + height + GAP_Y, 0)));
  columns.forEach((column, at) => {
    const room = (high - column.reduce((sum, { height }) => sum + height, 0)) / column.length;
    let y = room / 2;
    for (const item of column) {
      [item.x, item.y] = [at * (WIDTH + GAP_X), y];
      y += item.height + room;
    }
  });
  return boxed(all, new Map(), true);
}

/** Rows of what is connected to nothing. */
function rows(nodes, aspect) {
  const per = Math.max(3, Math.ceil(Math.sqrt(nodes.length * aspect * 0.3)));
  const placed = [];
  let y = 0;
  for (let at = 0; at < nodes.length; at += per) {
    const row = nodes.slice(at, at + per);
    row.forEach((node, index) => placed.push({ ...node, x: index * (WIDTH + GAP_Y), y }));
    y += Math.max(...row.map(({ height }) => height)) + GAP_Y;
  }
  return boxed(placed, new Map());
}
