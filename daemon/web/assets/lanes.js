// What a timeline shows, made of dated changes: lanes of bars (activities with their states) and
// marks (exceptions, missed periods, connections and other changes).

import { visible } from "./dom.js";
import { exception } from "./units.js";

/** Activities, marks and states that are kept; of more, the latest. */
const MOST = 20000;
/** Longest text of a value. */
const LONGEST = 80;

const word = (value) => visible(value ?? "?", LONGEST);

/** Marks by kind of change: lane, what is told, and how grave it is. */
const MARKS = {
  overrun: (one) => [`${word(one.component)} · ${word(one.task)}`, `${word(one.ticks)} missed periods of ${word(one.task)}`, "warn"],
  connected: (one) => ["Connections", `${word(one.in)} reads ${word(one.out)} on ${word(one.backend)}`, "good"],
  disconnected: (one) => ["Connections", `${word(one.in)} was disconnected`, "info"],
  remote_connected: (one) => ["Connections", `${word(one.remote)} calls ${word(one.service)}`, "good"],
  remote_disconnected: (one) => ["Connections", `${word(one.remote)} was disconnected`, "info"],
  backend_changed: (one) => ["Connections", `${word(one.port ? `${one.component}/${one.port}` : one.component)} moved to ${word(one.backend)}`, "info"],
  exception: (one) => [`${word(one.component)} · ${word(one.service)}`, `${word(exception(one.exception))} of ${word(one.service)}`, "bad"],
  service_exception: (one) => [`${word(one.component)} · ${word(one.service)}`, `${word(exception(one.exception))} of ${word(one.service)}`, "bad"],
  codel_stuck: (one) => [`${word(one.component)} · ${word(one.owner)}`, `${word(one.codel)} is stuck`, "bad"],
  codel_spins: (one) => [`${word(one.component)} · ${word(one.owner)}`, `${word(one.codel)} spins`, "bad"],
  supervision_violated: (one) => [`${word(one.component)} · supervision`, `${word(one.rule)}: ${word(one.what)}`, "bad"],
  cell_ended: (one) => ["Cells", `cell ${word(one.cell)} ended: ${word(one.why)}`, "bad"],
  cell_crashed: (one) => ["Cells", `cell ${word(one.cell)} crashed: ${word(one.end)}`, "bad"],
  cell_runs: (one) => ["Cells", `cell ${word(one.cell)} runs`, "good"],
};

/** Changes that are no marks of their own. */
const QUIET = new Set(["deployment_step", "deployment_waits"]);

export class Lanes {
  constructor() {
    this.clear();
  }

  clear() {
    /** Activities, in the order of their begin: `{ lane, from, to, states, … }`. */
    this.bars = [];
    this.marks = [];
    this.components = new Set();
    this.running = new Map();
    this.first = Infinity;
    this.last = -Infinity;
  }

  /** Adds a change that happened at this time, in seconds. */
  add(at, change) {
    if (!Number.isFinite(at) || change === null || typeof change !== "object") return;
    this.first = Math.min(this.first, at);
    this.last = Math.max(this.last, at);
    if (typeof change.component === "string") this.components.add(word(change.component));
    if (change.event === "activity_started") this.#bar(at, change, false);
    else if (change.event === "transition") this.#enter(at, change);
    else if (change.event === "activity_ended") this.#end(at, change);
    else this.#mark(at, change);
    if (this.bars.length > MOST) this.bars.splice(0, MOST / 10);
    if (this.marks.length > MOST) this.marks.splice(0, MOST / 10);
  }

  #key({ component, service, activity }) {
    return `${component}/${service}/${activity}`;
  }

  #bar(at, change, cut) {
    const service = change.service === "" ? "task" : word(change.service);
    const bar = { lane: `${word(change.component)} · ${service}`, component: word(change.component), service,
      activity: word(change.activity), from: at, to: null, cut, states: [], exception: null };
    this.bars.push(bar);
    this.running.set(this.#key(change), bar);
    return bar;
  }

  #enter(at, change) {
    // It was there before the first change that is kept.
    const bar = this.running.get(this.#key(change)) ?? this.#bar(at, change, true);
    const last = bar.states.at(-1);
    if (last?.name === word(change.state)) last.paused = change.paused === true;
    else if (bar.states.length < MOST) bar.states.push({ name: word(change.state), from: at, paused: change.paused === true });
  }

  #end(at, change) {
    const bar = this.running.get(this.#key(change)) ?? this.#bar(at, change, true);
    bar.to = at;
    this.running.delete(this.#key(change));
    if (typeof change.exception === "string") {
      bar.exception = word(exception(change.exception));
      const what = `${bar.exception} of ${bar.service} #${bar.activity}`;
      this.marks.push({ at, lane: bar.lane, component: bar.component, what, tone: "bad" });
    }
  }

  #mark(at, change) {
    if (QUIET.has(change.event)) return;
    const known = Object.hasOwn(MARKS, change.event) ? MARKS[change.event] : null;
    const of = typeof change.component === "string" ? word(change.component) : "Daemon";
    const [lane, what, tone] = known ? known(change)
      : [`${of} · changes`, `${word(String(change.event).replaceAll("_", " "))} ${word(change.component ?? change.name ?? change.cell ?? "")}`.trim(), "info"];
    // The kind says the same as the exception of its activity.
    if (change.event === "exception" && change.activity !== undefined) return;
    const missed = change.event === "overrun" ? { task: word(change.task), periods: Number(change.ticks) || 0 } : null;
    this.marks.push({ at, lane, component: typeof change.component === "string" ? of : null, what, tone, missed });
  }

  /** The lanes of a time, with rows for activities of one service that overlap. */
  within(from, to, component) {
    const wanted = (one) => !component || one.component === component || one.component === null;
    const lanes = new Map();
    const lane = (name) => {
      if (!lanes.has(name)) lanes.set(name, { name, rows: [], bars: [], marks: [] });
      return lanes.get(name);
    };
    for (const bar of this.bars) {
      if (bar.from > to || (bar.to ?? Infinity) < from || !wanted(bar)) continue;
      const into = lane(bar.lane);
      let row = into.rows.findIndex((end) => end <= bar.from);
      if (row < 0) row = into.rows.push(0) - 1;
      into.rows[row] = bar.to ?? Infinity;
      into.bars.push({ bar, row });
    }
    for (const mark of this.marks) {
      if (mark.at >= from && mark.at <= to && wanted(mark)) lane(mark.lane).marks.push(mark);
    }
    return [...lanes.values()].sort((one, other) => one.name < other.name ? -1 : 1);
  }
}

/**
 * What a list of bars and marks has, latest first. Missed periods of one task with nothing else
 * between them are one entry; where there are more entries than `most`, those are left out first.
 */
export function entries(bars, marks, most) {
  const date = (one) => one.at ?? one.from;
  const others = [];
  const late = [];
  let open = new Map();
  for (const one of [...bars, ...marks].sort((one, other) => date(one) - date(other))) {
    if (!one.missed) {
      others.push(one);
      open = new Map();
      continue;
    }
    const group = open.get(one.lane);
    if (group) {
      group.until = one.at;
      group.times += 1;
      group.periods += one.missed.periods;
      group.what = `${group.periods} missed periods of ${one.missed.task}, ${group.times} times`;
    } else {
      open.set(one.lane, { ...one, until: one.at, times: 1, periods: one.missed.periods });
      late.push(open.get(one.lane));
    }
  }
  const first = others.slice(-most);
  const room = most - first.length;
  const rest = room > 0 ? late.slice(-room) : [];
  return [...first, ...rest].sort((one, other) => date(other) - date(one));
}

/** The state that an activity is in at this time, with when that begins and ends. */
export function stateAt({ states, to }, at) {
  const index = states.findLastIndex((one) => one.from <= at);
  if (index < 0) return null;
  return { ...states[index], to: states[index + 1]?.from ?? to };
}
