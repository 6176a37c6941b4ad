// A small plot of the numbers in a value, of the last seconds.

import { el, put } from "./dom.js";
import { glance } from "./units.js";

/** Seconds that a plot shows. */
const SPAN = 20;
/** Lines in one plot. */
const MOST = 6;
/** Samples that are kept of a line. */
const LONGEST = 1200;

/** The numbers within a value, by their place in it. */
export function numbers(value, at = "", found = []) {
  if (found.length >= MOST) return found;
  if (typeof value === "number") found.push([at || "value", value]);
  else if (typeof value === "boolean") found.push([at || "value", Number(value)]);
  else if (value && typeof value === "object") {
    for (const [key, one] of Object.entries(value)) {
      numbers(one, Array.isArray(value) ? `${at}[${key}]` : at ? `${at}.${key}` : key, found);
    }
  }
  return found;
}

export class Plot {
  #lines = new Map();
  #canvas = el("canvas", { class: "plot", role: "img" });
  #legend = el("ul", { class: "legend" });
  #waits = false;
  #gone = false;

  constructor(label) {
    this.label = label;
    this.node = el("div", { class: "plotted" }, this.#canvas, this.#legend);
  }

  close() {
    this.#gone = true;
  }

  /** Adds a value; `seconds` is its date. */
  add(value, seconds) {
    for (const [key, number] of numbers(value)) {
      if (!this.#lines.has(key)) this.#begin(key);
      const line = this.#lines.get(key);
      line.points.push([seconds, number]);
      if (line.points.length > LONGEST) line.points.shift();
    }
    this.#later();
  }

  #begin(key) {
    const shown = el("output", {});
    const line = { points: [], shown, color: `--line-${this.#lines.size + 1}` };
    this.#lines.set(key, line);
    this.#legend.append(el("li", {}, el("span", { class: `key k${this.#lines.size}` }), el("bdi", {}, key), " ", shown));
  }

  #later() {
    if (this.#waits || this.#gone) return;
    this.#waits = true;
    requestAnimationFrame(() => {
      this.#waits = false;
      if (!this.#gone) this.#draw();
    });
  }

  #draw() {
    const canvas = this.#canvas;
    const scale = devicePixelRatio || 1;
    const [width, height] = [canvas.clientWidth, canvas.clientHeight];
    if (width === 0) return;
    if (canvas.width !== Math.round(width * scale)) {
      canvas.width = Math.round(width * scale);
      canvas.height = Math.round(height * scale);
    }
    const pen = canvas.getContext("2d");
    pen.setTransform(scale, 0, 0, scale, 0, 0);
    pen.clearRect(0, 0, width, height);
    const style = getComputedStyle(canvas);
    const lines = [...this.#lines.values()];
    const end = Math.max(...lines.map(({ points }) => points.at(-1)[0]));
    for (const line of lines) line.points = line.points.filter(([at]) => at >= end - SPAN);
    const all = lines.flatMap(({ points }) => points.map(([, number]) => number)).filter(Number.isFinite);
    let [least, most] = [Math.min(...all), Math.max(...all)];
    if (!(most > least)) [least, most] = [least - 1, most + 1];
    const pad = (most - least) * 0.08;
    [least, most] = [least - pad, most + pad];
    const left = 54;
    const x = (at) => left + (width - left - 8) * (1 - (end - at) / SPAN);
    const y = (number) => height - 18 - (height - 26) * (number - least) / (most - least);
    pen.font = "11px system-ui, sans-serif";
    pen.fillStyle = style.getPropertyValue("--soft");
    pen.strokeStyle = style.getPropertyValue("--rule");
    pen.lineWidth = 1;
    pen.textAlign = "right";
    for (let step = 0; step <= 3; step += 1) {
      const number = least + (most - least) * step / 3;
      const level = Math.round(y(number)) + 0.5;
      pen.beginPath();
      pen.moveTo(left, level);
      pen.lineTo(width - 8, level);
      pen.stroke();
      pen.fillText(glance(Number(number.toPrecision(3))), left - 6, level + 4);
    }
    pen.textAlign = "center";
    for (let back = 0; back <= SPAN; back += 5) pen.fillText(back === 0 ? "now" : `−${back} s`, Math.min(x(end - back), width - 18), height - 4);
    pen.lineWidth = 1.8;
    pen.lineJoin = "round";
    for (const { points, shown, color } of lines) {
      pen.strokeStyle = style.getPropertyValue(color);
      pen.beginPath();
      let down = false;
      for (const [at, number] of points) {
        if (!Number.isFinite(number)) down = false;
        else if (down) pen.lineTo(x(at), y(number));
        else {
          pen.moveTo(x(at), y(number));
          down = true;
        }
      }
      pen.stroke();
      const own = points.map(([, number]) => number);
      put(shown, `${glance(own.at(-1))}  [${glance(Math.min(...own))} … ${glance(Math.max(...own))}]`);
    }
    canvas.setAttribute("aria-label", `${this.label}, the last ${SPAN} s: `
      + [...this.#lines].map(([key, { shown }]) => `${key} ${shown.textContent}`).join("; "));
  }
}
