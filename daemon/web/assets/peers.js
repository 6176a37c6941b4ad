// What other programs have on the middlewares, as far as discovery tells.

/** Services that every component or ROS 2 node has, and that nobody draws. */
const USUAL = new Set(["kill", "abort_activity", "connect_port", "connect_service", "connect_remote", "describe_parameters",
  "get_parameters", "get_parameter_types", "list_parameters", "set_parameters", "set_parameters_atomically", "get_type_description"]);

/**
 * `middlewares`: the reply of the control plane. `ours`: `{ components, connections }`. Returns
 * `[{ id, name, backend, in, out, note }]`, one for each name that others use on a middleware.
 */
export function peers(middlewares, { components, connections }) {
  const calls = components.some((one) => one.remotes?.length > 0);
  const found = new Map();
  const peer = (backend, name, note) => {
    const id = `peer ${backend} ${name}`;
    if (!found.has(id)) found.set(id, { id, name, backend, in: new Map(), out: new Map(), note });
    return found.get(id);
  };
  const own = new Set(components.map((one) => one.name));
  for (const { name: backend, endpoints = [], strangers = [] } of middlewares) {
    const readers = new Map();
    for (const { kind, address, ty } of endpoints) {
      const at = plain(address, own);
      if (kind === "subscription") readers.set(at, (readers.get(at) ?? 0) + 1);
      else if (!own.has(first(at)) && (kind !== "service" || (calls && !USUAL.has(at.split("/").at(-1))))) {
        const side = peer(backend, first(at)).out;
        side.set(at, { address: at, type: ty, service: kind === "service", backend });
      }
    }
    for (const [address, count] of readers) {
      const mine = connections.filter((one) => one.kind === "port" && one.out === address && one.backend === backend).length;
      if (count > mine) reads(peer(backend, "other programs"), address, count - mine);
    }
    for (const stranger of strangers) {
      if (stranger.kind === "reader") reads(peer(backend, "other programs"), plain(stranger.address, own));
      else peer(backend, stranger.name, `${stranger.role}; what it opened cannot be seen`);
    }
  }
  for (const one of connections) {
    const from = first(one.out);
    // A port that reads its own address is fed by whoever publishes there.
    if (one.out === one.in && one.kind === "port") peer(one.backend, "other programs").out.set(one.out, { address: one.out, backend: one.backend });
    else if (!own.has(from)) {
      const side = peer(one.backend ?? "", from).out;
      if (!side.has(one.out)) side.set(one.out, { address: one.out, service: one.kind === "service", backend: one.backend, awaited: true });
    }
  }
  return [...found.values()].map((one) => ({ ...one, in: [...one.in.values()].sort(ordered), out: [...one.out.values()].sort(ordered) }));
}

/** Ports before services, by name: discovery has no order of its own. */
const ordered = (one, other) => Number(one.service ?? false) - Number(other.service ?? false) || one.address.localeCompare(other.address);

function reads(peer, address, count) {
  peer.in.set(address, { address, count });
}

const first = (address) => address.split("/")[0];

/** An address without the namespace that a middleware puts before those of our components. */
function plain(address, own) {
  const names = address.replace(/^\//, "").split("/");
  const at = names.findIndex((name) => own.has(name));
  return at > 0 && names.length - at <= 3 ? names.slice(at).join("/") : names.join("/");
}
