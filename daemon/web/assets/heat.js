// Histograms of durations over time: each second a column, each bucket a row, darker the more of
// the durations it has.

import { el, put } from "./dom.js";
import { count, duration } from "./units.js";

/** Seconds that are shown, and rows in a power of two. */
const SECONDS = 120;
const ROWS = 2;
/** Shortest and longest duration that has a row of its own, as powers of two of nanoseconds. */
const [LEAST, MOST] = [7, 31];
const ALL = (MOST - LEAST) * ROWS;

const LEFT = 58;
const BELOW = 18;

const row = (ns) => Math.min(ALL - 1, Math.max(0, Math.floor((Math.log2(Math.max(1, ns)) - LEAST) * ROWS)));

/** A heat map of one kind of duration of a task; `period` is marked. */
class Heat {
  #canvas = el("canvas", { class: "heat", role: "img", tabindex: 0 });
  #told = el("figcaption", { class: "soft" });
  #columns = [];
  #before = null;

  constructor(label, period) {
    this.label = label;
    this.period = period;
    this.#canvas.setAttribute("aria-label", `${label} over time: nothing yet`);
    this.node = el("figure", {}, this.#canvas, this.#told);
  }

  /** The buckets since the start; what is new belongs to the present second. */
  take(buckets, second) {
    const now = new Map(buckets.map(({ most_ns: most, count: many }) => [most, many]));
    // A component that was reloaded counts anew.
    const again = this.#before && [...this.#before].some(([most, many]) => (now.get(most) ?? 0) < many);
    if (this.#before && !again) {
      let column = this.#columns.at(-1);
      if (column?.second !== second) {
        column = { second, rows: new Map(), exact: new Map() };
        this.#columns.push(column);
      }
      for (const [most, many] of now) {
        const news = many - (this.#before.get(most) ?? 0);
        if (news <= 0) continue;
        column.rows.set(row(most), (column.rows.get(row(most)) ?? 0) + news);
        column.exact.set(most, (column.exact.get(most) ?? 0) + news);
      }
      this.#columns = this.#columns.filter((one) => one.second > second - SECONDS);
    }
    this.#before = now;
    this.#draw(second);
  }

  #draw(second) {
    const canvas = this.#canvas;
    const scale = devicePixelRatio || 1;
    const [width, height] = [canvas.clientWidth, canvas.clientHeight];
    if (width === 0) return;
    canvas.width = Math.round(width * scale);
    canvas.height = Math.round(height * scale);
    const pen = canvas.getContext("2d");
    pen.setTransform(scale, 0, 0, scale, 0, 0);
    const style = getComputedStyle(canvas);
    const used = this.#columns.flatMap(({ rows }) => [...rows.keys()]);
    const low = Math.max(0, Math.min(...used, this.period ? row(this.period) : ALL) - 2);
    const high = Math.min(ALL, Math.max(...used, this.period ? row(this.period) : 0) + 3);
    const tall = (height - BELOW) / Math.max(1, high - low);
    const y = (one) => height - BELOW - (one - low + 1) * tall;
    const wide = (width - LEFT) / SECONDS;
    const most = Math.max(1, ...this.#columns.flatMap(({ rows }) => [...rows.values()]));
    pen.fillStyle = style.getPropertyValue("--main");
    for (const { second: at, rows } of this.#columns) {
      for (const [one, many] of rows) {
        pen.globalAlpha = 0.12 + 0.88 * Math.log1p(many) / Math.log1p(most);
        pen.fillRect(width - (second - at + 1) * wide, y(one), Math.max(1, wide), Math.max(1, tall - 0.5));
      }
    }
    pen.globalAlpha = 1;
    pen.font = "11px system-ui, sans-serif";
    pen.fillStyle = style.getPropertyValue("--soft");
    pen.textAlign = "right";
    const every = Math.max(ROWS, Math.ceil((high - low) / 5 / ROWS) * ROWS);
    for (let one = Math.ceil(low / every) * every; one < high; one += every) {
      pen.fillText(duration(Math.round(2 ** (one / ROWS + LEAST))), LEFT - 6, y(one) + tall + 3);
    }
    pen.textAlign = "center";
    for (let back = 0; back <= SECONDS; back += 30) {
      pen.fillText(back === 0 ? "now" : `−${back} s`, Math.min(Math.max(width - back * wide, LEFT + 16), width - 18), height - 4);
    }
    if (this.period) {
      pen.strokeStyle = style.getPropertyValue("--bad");
      pen.setLineDash([4, 4]);
      pen.beginPath();
      const level = Math.round(y(row(this.period))) + 0.5;
      pen.moveTo(LEFT, level);
      pen.lineTo(width, level);
      pen.stroke();
    }
    this.#tell();
  }

  #tell() {
    const all = new Map();
    for (const { exact } of this.#columns) for (const [most, many] of exact) all.set(most, (all.get(most) ?? 0) + many);
    const sorted = [...all].sort(([one], [other]) => one - other);
    const total = sorted.reduce((sum, [, many]) => sum + many, 0);
    const part = (share) => {
      let seen = 0;
      return sorted.find(([, many]) => (seen += many) >= total * share)?.[0];
    };
    const text = total === 0 ? "none in the last two minutes"
      : `${count(total)} in the last two minutes: half within ${duration(part(0.5))}, 99 % within ${duration(part(0.99))}, the longest ${duration(part(1))}`;
    put(this.#told, el("strong", {}, this.label), ` ${text}`);
    this.#canvas.setAttribute("aria-label", `${this.label} over time: ${text}`);
  }
}

/** `{ node, watched() }`: histograms of the tasks of a component, read while they are open. */
export function histograms(path, changed) {
  const maps = new Map();
  const body = el("div", { class: "stack" });
  const node = el("details", { class: "card histograms", id: "histograms" },
    el("summary", {}, el("h3", {}, "Histograms over time")),
    el("p", { class: "soft" }, "How late work began, and how long it took: a column for each second, darker where there is more. The dashed line is the period."),
    body);
  node.addEventListener("toggle", changed);

  function take({ tasks }, status) {
    if (status !== 200) return;
    const second = Math.floor(performance.now() / 1000);
    for (const task of tasks) {
      if (!maps.has(task.name)) {
        const made = { lateness: new Heat(`Lateness of ${task.name}`), cycles: new Heat(`Duration of ${task.name}`, task.period_ns) };
        maps.set(task.name, made);
        body.append(el("div", { class: "heats", "data-task": task.name }, made.lateness.node, made.cycles.node));
      }
      const { lateness, cycles } = maps.get(task.name);
      lateness.take(task.lateness, second);
      cycles.take(task.cycles, second);
    }
  }

  return { node, watched: () => node.open ? [{ path, take }] : [] };
}
