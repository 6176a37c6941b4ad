// Rates of ports, as differences of their counters.

/** Milliseconds over which a rate is taken, and that there must be for one. */
const SPAN = 4000;
const LEAST = 400;

export class Rates {
  #past = new Map();

  /** Takes a reading of the counters of all ports. */
  take(ports, now = performance.now()) {
    const there = new Set();
    for (const { address, traffic } of ports) {
      if (traffic?.samples === undefined) continue;
      there.add(address);
      const past = this.#past.get(address) ?? [];
      // A counter that begins again is another port's.
      if (past.length > 0 && past.at(-1)[1] > traffic.samples) past.length = 0;
      past.push([now, traffic.samples]);
      while (now - past[0][0] > SPAN && past.length > 2) past.shift();
      this.#past.set(address, past);
    }
    for (const address of this.#past.keys()) if (!there.has(address)) this.#past.delete(address);
  }

  /** Samples in a second; undefined while that is not known. */
  of(address) {
    const past = this.#past.get(address);
    if (!past || past.length < 2) return undefined;
    const [[begin, first], [end, last]] = [past[0], past.at(-1)];
    return end - begin > LEAST ? 1000 * (last - first) / (end - begin) : undefined;
  }
}
