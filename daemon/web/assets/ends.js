// The ends of connections: ports, remotes and services, drawn or not.

import { mismatch, servicesOf } from "./wiring.js";

/** Whether a connection can be begun from this end, and whether it can end there. */
export const isStart = (port) => port.way === "out" || Boolean(port.remote);
export const isEnd = (port) => port.way === "in" && !port.foreign;
/** Two ends in the order of a connection, from what is read or called to who reads or calls. */
export const ordered = (one, other) => one.remote && other.service ? [other, one] : [one, other];

export class Ends {
  #told;
  #drawing;

  /** `told` is what the control plane told, and changes; `drawing` has what is drawn. */
  constructor(told, drawing) {
    this.#told = told;
    this.#drawing = drawing;
  }

  /** The end that is drawn under a key. */
  at = (key) => this.#drawing.ports.get(key)?.port;

  /** The connection of an in port or a remote. */
  of = (port) => port.way === "in" && !port.foreign ? this.#told.connections.find((one) => one.in === port.address) : undefined;

  /** What a connection reads or calls. */
  source({ kind, out, backend }) {
    const service = kind === "service";
    return this.at(`${service ? "service" : "out"} ${out}`) ?? this.#port(out, "out")
      ?? { address: out, way: "out", backend, service, foreign: true };
  }

  /** Who reads or calls in a connection. */
  reader({ kind, in: address }) {
    return this.at(`in ${address}`) ?? this.#port(address, "in") ?? { address, way: "in", remote: kind === "service" };
  }

  #port(address, way) {
    const found = this.#told.ports.find((port) => port.address === address && port.direction === way);
    return found && { ...found, way };
  }

  /** All ends that fit this one; services of all components for a remote, of which the daemon alone knows. */
  async fitting(port) {
    const { ports, components } = this.#told;
    if (port.remote) {
      const all = await Promise.allSettled(components.map((one) => servicesOf(one.name)));
      return likely(port, all.flatMap((one) => one.value ?? []));
    }
    if (port.service) {
      return components.flatMap((one) => (one.remotes ?? []).map((remote) => ({ address: `${one.name}/${remote}`, way: "in", remote: true })));
    }
    const way = port.way === "out" ? "in" : "out";
    const own = ports.filter((one) => one.direction === way).map((one) => ({ ...one, way }));
    const foreign = [...this.#drawing.ports.values()].map((row) => row.port).filter((one) => one.foreign && one.way === "out" && !one.service);
    return way === "in" ? own.filter((one) => !mismatch(port, one)) : [...own, ...foreign].filter((one) => !mismatch(one, port));
  }
}

/** Services with the one first that has the name of the remote. */
export function likely(remote, services) {
  const named = `/${remote.address.split("/").at(-1)}`;
  return services.sort((one, other) => Number(other.address.endsWith(named)) - Number(one.address.endsWith(named)));
}
