// Places components so that data flows from left to right, with few crossings.

/** Width of a component, heights of its title and of a row of ports. */
export const WIDTH = 216;
export const TITLE = 34;
export const ROW = 24;
const GAP_X = 110;
const GAP_Y = 34;

/** Height of a component with this many rows. */
export const heightOf = (rows) => TITLE + Math.max(1, rows) * ROW + 8;

/**
 * `nodes`: `{ id, rows }`, `edges`: pairs of ids. Returns the top left corner of each node. What is
 * connected to nothing comes last, in columns of its own.
 */
export function layout(nodes, edges) {
  const ways = edges.filter(([from, to]) => from !== to);
  const connected = new Set(ways.flat());
  const flowing = nodes.filter(({ id }) => connected.has(id));
  const layers = layered(flowing, forward(flowing, ways));
  order(layers, ways);
  const rest = nodes.filter(({ id }) => !connected.has(id));
  const high = Math.max(3, Math.ceil(Math.sqrt(rest.length)));
  for (let at = 0; at < rest.length; at += high) layers.push(rest.slice(at, at + high));
  const tall = layers.map((layer) => layer.reduce((sum, { rows }) => sum + heightOf(rows) + GAP_Y, -GAP_Y));
  const most = Math.max(0, ...tall);
  const places = new Map();
  layers.forEach((layer, column) => {
    let y = (most - tall[column]) / 2;
    for (const { id, rows } of layer) {
      places.set(id, { x: column * (WIDTH + GAP_X), y });
      y += heightOf(rows) + GAP_Y;
    }
  });
  return places;
}

/** The ways without those that close a circle. */
function forward(nodes, ways) {
  const out = new Map(nodes.map(({ id }) => [id, []]));
  for (const [from, to] of ways) out.get(from)?.push(to);
  const state = new Map();
  const kept = [];
  const visit = (id) => {
    // By hand instead of by recursion: a chain may be long.
    const stack = [[id, 0]];
    state.set(id, "open");
    while (stack.length > 0) {
      const top = stack.at(-1);
      const next = out.get(top[0])?.[top[1]];
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

/** Layers by the longest way to each node. */
function layered(nodes, ways) {
  const before = new Map(nodes.map(({ id }) => [id, 0]));
  const out = new Map(nodes.map(({ id }) => [id, []]));
  for (const [from, to] of ways) {
    before.set(to, before.get(to) + 1);
    out.get(from).push(to);
  }
  const depth = new Map(nodes.map(({ id }) => [id, 0]));
  const ready = nodes.map(({ id }) => id).filter((id) => before.get(id) === 0);
  for (let at = 0; at < ready.length; at += 1) {
    for (const to of out.get(ready[at])) {
      depth.set(to, Math.max(depth.get(to), depth.get(ready[at]) + 1));
      before.set(to, before.get(to) - 1);
      if (before.get(to) === 0) ready.push(to);
    }
  }
  const layers = [];
  for (const node of nodes) (layers[depth.get(node.id)] ??= []).push(node);
  return layers.filter(Boolean);
}

/** Orders each layer by the mean place of its neighbours, a few times in both directions. */
function order(layers, ways) {
  const near = new Map();
  for (const [from, to] of ways) {
    for (const [one, other] of [[from, to], [to, from]]) near.set(one, [...(near.get(one) ?? []), other]);
  }
  const place = new Map();
  const note = (layer) => layer.forEach(({ id }, at) => place.set(id, at / Math.max(1, layer.length)));
  layers.forEach(note);
  for (let round = 0; round < 6; round += 1) {
    const turn = round % 2 === 0 ? layers : [...layers].reverse();
    for (const layer of turn) {
      const mean = ({ id }) => {
        const all = (near.get(id) ?? []).map((one) => place.get(one) ?? 0);
        return all.length > 0 ? all.reduce((sum, one) => sum + one, 0) / all.length : place.get(id);
      };
      const means = new Map(layer.map((node) => [node.id, mean(node)]));
      layer.sort((one, other) => means.get(one.id) - means.get(other.id));
      note(layer);
    }
  }
}
