// The ways of connections through a drawing in layers: a wire in each layer that one passes, and
// lanes between bands of layers.

/** Room for a connection that passes a layer, and for one between two bands. */
const WIRE = 12;
const LANE = 9;
/** How far a way swings out where it turns. */
const TURN = 56;

/**
 * Adds a wire to each layer that an edge passes; edges of one out port share theirs. Links what
 * follows on each other, for the order in the layers. Wires against the flow are in no layer:
 * `backs` has them, by out port.
 *
 * `found` has, for each edge, its wires, and the layers at which it begins and ends.
 */
export function wire(layers, edges, width) {
  const at = new Map(layers.flatMap((layer, index) => layer.map((node) => [node.id, { node, index }])));
  const shared = new Map();
  const found = new Map();
  const backs = new Map();
  for (const edge of edges) {
    const [from, to] = [at.get(edge.from), at.get(edge.to)];
    const back = to.index <= from.index;
    const passed = [];
    if (back) for (let index = from.index; index >= to.index; index -= 1) passed.push(index);
    else for (let index = from.index + 1; index < to.index; index += 1) passed.push(index);
    let last = { item: from.node, at: edge.out };
    const wires = passed.map((index) => {
      const key = `${back} ${index} ${edge.via}`;
      if (!shared.has(key)) {
        const made = { back, height: WIRE, width, links: [] };
        shared.set(key, made);
        if (back) {
          backs.set(edge.via, [...(backs.get(edge.via) ?? []), { item: made, index }]);
        } else {
          layers[index].push(made);
          link(last, { item: made, at: WIRE / 2 });
        }
      }
      const item = shared.get(key);
      last = { item, at: WIRE / 2 };
      return { item, index };
    });
    if (!back) link(last, { item: to.node, at: edge.in });
    found.set(edge, { wires, begin: from.index, end: to.index });
  }
  return { found, backs };
}

function link(one, other) {
  one.item.links.push({ to: other.item, own: one.at, theirs: other.at });
  other.item.links.push({ to: one.item, own: other.at, theirs: one.at });
}

/** The lanes between bands, through which edges get from one to the next. */
export class Lanes {
  #bands;
  #used;
  #pitch;
  #gap;

  constructor(bands, width, gapX, gapY) {
    this.#bands = bands;
    this.#used = bands.map(() => new Map());
    this.#pitch = [width + gapX, gapX];
    this.#gap = gapY;
  }

  /** The stops of an edge: functions, which can be called after `open`. */
  lead(via, { wires, begin, end }) {
    const stops = [];
    const of = (layer) => this.#bands.findIndex((band) => layer < band.end);
    let band = of(begin);
    const go = (layer) => {
      for (const next = of(layer); band !== next; band += Math.sign(next - band)) {
        stops.push(this.#lane(via, Math.min(band, band + Math.sign(next - band)), next > band));
      }
    };
    for (const { item, index } of wires) {
      go(index);
      stops.push(() => {
        const [left, right, y] = [item.x, item.x + item.width, item.y + WIRE / 2];
        return item.back ? { from: right, to: left, y } : { from: left, to: right, y };
      });
    }
    go(end);
    return stops;
  }

  #lane(via, upper, down) {
    const used = this.#used[upper];
    if (!used.has(via)) used.set(via, used.size);
    const band = this.#bands[upper];
    const right = (band.end - band.begin) * this.#pitch[0] - this.#pitch[1];
    return () => {
      const y = band.bottom + band.more + this.#gap * 0.75 + used.get(via) * LANE;
      return down ? { from: right, to: 0, y } : { from: 0, to: right, y };
    };
  }

  /** Makes room for the lanes: bands below move down. */
  open() {
    let more = 0;
    this.#bands.forEach((band, at) => {
      band.more = more;
      band.shift += more;
      more += this.#used[at].size * LANE;
    });
  }
}

/** The line from an out port through stops to an in port. */
export function route(from, stops, to) {
  let d = `M${round(from.x)} ${round(from.y)}`;
  let [x, y, way] = [from.x, from.y, 1];
  const bend = (nextX, nextY, nextWay) => {
    const ahead = way === nextWay && (nextX - x) * way > 0;
    const swing = ahead ? Math.max(40, Math.abs(nextX - x) / 2) : TURN;
    d += ` C${round(x + way * swing)} ${round(y)} ${round(nextX - nextWay * swing)} ${round(nextY)} ${round(nextX)} ${round(nextY)}`;
  };
  for (const stop of stops) {
    const next = Math.sign(stop.to - stop.from);
    bend(stop.from, stop.y, next);
    d += ` H${round(stop.to)}`;
    [x, y, way] = [stop.to, stop.y, next];
  }
  bend(to.x, to.y, 1);
  return d;
}

const round = (number) => Math.round(number * 10) / 10;
