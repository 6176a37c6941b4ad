// What the graph shows: components, cells and peers with their ports, and the connections between
// them; folded ones stand for all that is in them.

import { peers } from "./peers.js";
import { parts } from "./port.js";

/** The port that every component has, which says how it is. */
const STATE = "genom_state";
/** With more components than this, they are folded at first. */
export const MANY = 30;

/** How much of each component is shown, unless it was folded or unfolded by itself. */
export const LEVELS = ["ports", "components", "cells"];

/**
 * `told`: `{ components, ports, connections, middlewares }`, as the control plane has them.
 * `wish`: `{ level, folds, states, peers, find }`.
 *
 * Returns `{ nodes, edges, hidden }`. A node is `{ id, name, kind, folded, rows: { in, out } }`,
 * an edge `{ key, from: { node, port }, to: { node, port }, list }` with all connections that it
 * stands for; `port` is the key of a row, or undefined where the end is folded.
 */
export function scene(told, wish) {
  const nodes = new Map();
  const home = new Map();
  for (const one of told.components) {
    const cell = one.cell && `cell ${one.cell}`;
    const inside = cell && (wish.folds.get(cell) ?? wish.level === "cells");
    const id = inside ? cell : `component ${one.name}`;
    home.set(one.name, id);
    if (inside) {
      if (!nodes.has(id)) nodes.set(id, { id, name: one.cell, kind: "cell", folded: true, inside: [], words: [], rows: { in: [], out: [] } });
      nodes.get(id).inside.push(one);
    } else {
      const folded = wish.folds.get(id) ?? wish.level !== "ports";
      nodes.set(id, { id, name: one.name, kind: "component", folded, component: one, words: [], rows: { in: [], out: [] } });
    }
  }
  const called = new Set(told.connections.filter((one) => one.kind === "service").map((one) => one.out));
  for (const port of told.ports) {
    const node = nodes.get(home.get(parts(port.address).component));
    node?.words.push(port.address, port.type);
    if (!node || node.folded || (port.name === STATE && !wish.states)) continue;
    node.rows[port.direction].push({ ...port, key: `${port.direction} ${port.address}`, way: port.direction });
  }
  for (const one of told.components) {
    const node = nodes.get(home.get(one.name));
    if (node.folded) continue;
    for (const remote of one.remotes ?? []) {
      const address = `${one.name}/${remote}`;
      node.rows.in.push({ key: `in ${address}`, address, way: "in", remote: true, backend: one.backend });
    }
    for (const address of called) {
      if (parts(address).component !== one.name) continue;
      node.rows.out.push({ key: `service ${address}`, address, way: "out", service: true, backend: one.backend });
    }
  }
  if (wish.peers) addPeers(told, wish, nodes, home);
  const edges = join(told.connections, nodes, home, wish);
  return narrowed(nodes, edges, wish.find);
}

function addPeers(told, wish, nodes, home) {
  for (const one of peers(told.middlewares, told)) {
    const out = one.out.filter((end) => wish.states || parts(end.address).port !== STATE).map((end) => ({ ...end, key: `${end.service ? "service" : "out"} ${end.address}`, way: "out", foreign: true }));
    const read = one.in.map((end) => ({ ...end, key: `reader ${end.address}`, way: "in", foreign: true, backend: one.backend }));
    nodes.set(one.id, { id: one.id, name: one.name, kind: "peer", backend: one.backend, note: one.note, folded: false, words: [...one.in, ...one.out].map((end) => end.address), rows: { in: read, out } });
    // Both sides of a name that several middlewares have lead to the first of them.
    for (const end of out) if (!home.has(`${one.backend} ${end.address}`)) home.set(`${one.backend} ${end.address}`, one.id);
  }
}

function join(connections, nodes, home, wish) {
  const edges = new Map();
  const add = (from, to, one, extra) => {
    const key = `${from.port ?? from.node} > ${to.port ?? to.node} ${one.backend ?? ""} ${one.kind}`;
    if (!edges.has(key)) edges.set(key, { key, from, to, kind: one.kind, backend: one.backend ?? "local", list: [], ...extra });
    edges.get(key).list.push(one);
  };
  const end = (id, port) => ({ node: id, port: nodes.get(id).folded ? undefined : port });
  for (const one of connections) {
    const target = home.get(parts(one.in).component);
    const outside = one.out === one.in && one.kind === "port";
    const source = (outside ? undefined : home.get(parts(one.out).component)) ?? home.get(`${one.backend ?? ""} ${one.out}`);
    if (!target || !source || !nodes.has(source)) continue;
    if (source === target && nodes.get(source).folded) continue;
    const from = end(source, `${one.kind === "service" ? "service" : "out"} ${one.out}`);
    if (from.port && !wish.states && parts(one.out).port === STATE && nodes.get(source).kind !== "peer") continue;
    add(from, end(target, `in ${one.in}`), one);
  }
  for (const node of nodes.values()) {
    if (node.kind !== "peer") continue;
    for (const { address, key, backend, count } of node.rows.in) {
      const source = home.get(parts(address).component) ?? home.get(`${backend} ${address}`);
      if (!source) continue;
      const from = end(source, `out ${address}`);
      add(from, { node: node.id, port: key }, { kind: "port", out: address, backend, count }, { foreign: true });
    }
  }
  return [...edges.values()];
}

/** Only what is looked for, with its neighbours, which are marked. */
function narrowed(nodes, edges, find) {
  const words = find.toLowerCase().split(/\s+/).filter(Boolean);
  if (words.length === 0) return { nodes: [...nodes.values()], edges, hidden: 0 };
  const fits = (node) => {
    const text = [node.name, node.kind, node.component?.component, node.component?.cell, node.component?.state, node.backend,
      ...(node.inside ?? []).map((one) => one.name), ...node.words];
    const whole = text.filter(Boolean).join("\n").toLowerCase();
    return words.every((word) => whole.includes(word));
  };
  const found = new Set([...nodes.values()].filter(fits).map(({ id }) => id));
  const kept = edges.filter(({ from, to }) => found.has(from.node) || found.has(to.node));
  const near = new Set(kept.flatMap(({ from, to }) => [from.node, to.node]));
  const shown = [...nodes.values()].filter(({ id }) => found.has(id) || near.has(id));
  return { nodes: shown.map((node) => ({ ...node, beside: !found.has(node.id) })), edges: kept, hidden: nodes.size - shown.length };
}
