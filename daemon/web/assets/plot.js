// A plot of numbers over the last seconds: of each column a band from the least to the greatest of
// all samples, so that none is invisible, and a line through the last ones.

import { el, put } from "./dom.js";
import { count, duration, glance } from "./units.js";

/** What a plot may show, in seconds. */
const SPANS = [5, 20, 60, 300];
/** Lines in one plot: as many as there are colours. */
const LINES = 6;
/** Columns that are kept. */
const LONGEST = 6000;
/** Most columns in a second: the daemon allows 200. */
const FASTEST = 60;

const LEFT = 58;
const RIGHT = 8;
const BELOW = 18;

let plots = 0;

export class Plot {
  #columns = [];
  #lines = [];
  #width = 0;
  #span = 20;
  #canvas = el("canvas", { class: "plot", role: "img", tabindex: 0 });
  #legend = el("ul", { class: "legend" });
  #told = el("p", { class: "soft plot-told" });
  #read = el("output", { class: "soft plot-read" });
  #waits = false;
  #gone = false;
  #paused = false;
  #cursor = null;
  #lost = 0;
  #skipped = 0;
  #chosen = "";
  #known;

  /** `changed` is called when the daemon is to be asked for something else. */
  constructor(label, changed) {
    this.label = label;
    this.#canvas.setAttribute("aria-label", `${label}: no sample yet`);
    const list = `plot-numbers-${plots += 1}`;
    this.#known = el("datalist", { id: list });
    const numbers = el("input", { type: "text", list, spellcheck: "false", autocomplete: "off", placeholder: "the first six",
      "aria-label": `Numbers of ${label} to plot, separated by commas`, onchange: () => {
        this.#chosen = numbers.value.split(",").map((one) => one.trim()).filter(Boolean).join(",");
        this.#columns = [];
        changed();
      } });
    const span = el("select", { "aria-label": `Time that the plot of ${label} shows`, onchange: () => {
      this.#span = Number(span.value);
      changed();
      this.#later();
    } }, SPANS.map((one) => el("option", { value: one, selected: one === this.#span }, `${duration(one * 1e9)}`)));
    span.value = this.#span;
    const pause = el("button", { type: "button", "aria-pressed": "false", onclick: () => {
      this.#paused = !this.#paused;
      pause.setAttribute("aria-pressed", String(this.#paused));
      this.#later();
    } }, "Hold");
    this.node = el("div", { class: "plotted" }, this.#canvas, this.#legend,
      el("div", { class: "row plot-tools" }, el("label", { class: "field inline" }, "Numbers", numbers), this.#known,
        el("label", { class: "field inline" }, "Last", span), pause, this.#read), this.#told);
    this.#canvas.addEventListener("pointermove", (event) => this.#point(event.offsetX));
    this.#canvas.addEventListener("pointerleave", () => this.#point(null));
    this.#canvas.addEventListener("blur", () => this.#point(null));
    this.#canvas.addEventListener("keydown", (event) => {
      const step = { ArrowLeft: -1, ArrowRight: 1 }[event.key];
      if (step === undefined) return;
      event.preventDefault();
      this.#point((this.#cursor ?? this.#canvas.clientWidth - RIGHT) + step * (event.shiftKey ? 20 : 2));
    });
  }

  close() {
    this.#gone = true;
  }

  /** What of the port it shows, as the daemon is asked for it. */
  get wanted() {
    return this.#chosen ? `#${this.#chosen}` : "";
  }

  /** Columns in a second that it draws. */
  get rate() {
    const pixels = Math.max(50, (this.#canvas.clientWidth - LEFT - RIGHT) * (devicePixelRatio || 1));
    return Math.min(FASTEST, Math.max(0.1, pixels / this.#span));
  }

  /** The daemon tells what it sends. */
  begin({ leaves, known }, width) {
    this.#width = width / 1e9;
    const same = this.#lines.map(({ key }) => key).join() === leaves.slice(0, LINES).join();
    if (!same) {
      this.#columns = [];
      this.#lines = leaves.slice(0, LINES).map((key) => ({ key, shown: el("output", {}) }));
      put(this.#legend, this.#lines.map(({ key, shown }, at) =>
        el("li", {}, el("span", { class: `key k${at + 1}` }), el("bdi", {}, key), " ", shown)));
      put(this.#known, known.map((one) => el("option", { value: one })));
    }
    // Losses are counted anew.
    this.#lost = 0;
    this.#skipped = 0;
  }

  /** What went wrong. */
  fail(message) {
    put(this.#told, el("span", { class: "bad" }, message));
  }

  /** Adds columns. */
  add({ columns, lost }, skipped) {
    for (const { at, samples, values } of columns) {
      this.#columns.push({ at: at / 1e9, width: this.#width, samples, values });
    }
    this.#columns.splice(0, Math.max(0, this.#columns.length - LONGEST));
    this.#lost = lost;
    this.#skipped = skipped;
    if (!this.#paused) this.#later();
  }

  #point(x) {
    this.#cursor = x === null ? null : Math.min(Math.max(x, LEFT), this.#canvas.clientWidth - RIGHT);
    this.#later();
  }

  #later() {
    if (this.#waits || this.#gone) return;
    this.#waits = true;
    requestAnimationFrame(() => {
      this.#waits = false;
      if (!this.#gone && this.#columns.length > 0) this.#draw();
    });
  }

  #end = 0;

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
    const last = this.#columns.at(-1);
    if (!this.#paused || this.#end === 0) this.#end = last.at + last.width;
    const end = this.#end;
    const begin = end - this.#span;
    const seen = this.#columns.filter(({ at, width: wide }) => at + wide >= begin && at <= end);
    const range = this.#range(seen);
    const x = (at) => LEFT + (width - LEFT - RIGHT) * (at - begin) / this.#span;
    const y = (number) => height - BELOW - (height - BELOW - 8) * (number - range[0]) / (range[1] - range[0]);
    this.#axes(pen, style, width, y, range, x, end, height);
    pen.save();
    pen.beginPath();
    pen.rect(LEFT, 0, width - LEFT - RIGHT, height);
    pen.clip();
    this.#lines.forEach((line, at) => this.#line(pen, style.getPropertyValue(`--line-${at + 1}`), seen, at, x, y));
    pen.restore();
    this.#legends(seen);
    this.#reading(pen, style, seen, x, end, height);
    const samples = seen.reduce((sum, one) => sum + one.samples, 0);
    const time = seen.length > 0 ? last.at + last.width - seen[0].at : 0;
    put(this.#told, `${count(samples)} samples in ${duration(Math.round(time * 1e9))}, all of them in the plot`,
      this.#lost > 0 && el("span", { class: "warn" }, ` · ${count(this.#lost)} samples came too fast and are lost`),
      this.#skipped > 0 && el("span", { class: "warn" }, ` · ${count(this.#skipped)} columns were left out: this page was too slow`));
  }

  #range(seen) {
    let [least, most] = [Infinity, -Infinity];
    for (const { values } of seen) {
      for (let at = 0; at < this.#lines.length; at += 1) {
        if (values[at]) [least, most] = [Math.min(least, values[at][1]), Math.max(most, values[at][2])];
      }
    }
    if (!(most > least)) [least, most] = least === most ? [least - 1, most + 1] : [-1, 1];
    const pad = (most - least) * 0.08;
    return [least - pad, most + pad];
  }

  #axes(pen, style, width, y, [least, most], x, end, height) {
    pen.font = "11px system-ui, sans-serif";
    pen.fillStyle = style.getPropertyValue("--soft");
    pen.strokeStyle = style.getPropertyValue("--rule");
    pen.lineWidth = 1;
    pen.textAlign = "right";
    for (let step = 0; step <= 3; step += 1) {
      const number = least + (most - least) * step / 3;
      const level = Math.round(y(number)) + 0.5;
      pen.beginPath();
      pen.moveTo(LEFT, level);
      pen.lineTo(width - RIGHT, level);
      pen.stroke();
      pen.fillText(glance(Number(number.toPrecision(3))), LEFT - 6, level + 4);
    }
    pen.textAlign = "center";
    for (let part = 0; part <= 4; part += 1) {
      const back = this.#span * part / 4;
      const text = back === 0 ? (this.#paused ? "held" : "now") : `−${duration(back * 1e9)}`;
      pen.fillText(text, Math.min(Math.max(x(end - back), LEFT + 16), width - 18), height - 4);
    }
  }

  #line(pen, color, seen, index, x, y) {
    pen.fillStyle = color;
    pen.globalAlpha = 0.4;
    for (const { at, width, values } of seen) {
      if (!values[index]) continue;
      const [, least, most] = values[index];
      const [top, bottom] = [y(most), y(least)];
      if (bottom - top > 1) pen.fillRect(x(at), top, Math.max(1, x(at + width) - x(at)), bottom - top);
    }
    pen.globalAlpha = 1;
    pen.strokeStyle = color;
    pen.lineWidth = 1.4;
    pen.lineJoin = "round";
    pen.beginPath();
    let down = false;
    for (const { at, width, values } of seen) {
      if (!values[index]) {
        down = false;
        continue;
      }
      const [first, , , last] = values[index];
      if (down) pen.lineTo(x(at), y(first));
      else pen.moveTo(x(at), y(first));
      pen.lineTo(x(at + width), y(last));
      down = true;
    }
    pen.stroke();
  }

  #legends(seen) {
    this.#lines.forEach(({ shown }, index) => {
      const mine = seen.map(({ values }) => values[index]).filter(Boolean);
      if (mine.length === 0) return put(shown, "no number");
      const least = mine.reduce((all, [, one]) => Math.min(all, one), Infinity);
      const most = mine.reduce((all, [, , one]) => Math.max(all, one), -Infinity);
      put(shown, `${glance(mine.at(-1)[3])}  [${glance(least)} … ${glance(most)}]`);
    });
    this.#canvas.setAttribute("aria-label", `${this.label}, the last ${duration(this.#span * 1e9)}: `
      + this.#lines.map(({ key, shown }) => `${key} ${shown.textContent}`).join("; "));
  }

  #reading(pen, style, seen, x, end, height) {
    if (this.#cursor === null) return put(this.#read, "");
    const here = seen.findLast((one) => x(one.at) <= this.#cursor) ?? seen[0];
    if (!here) return;
    pen.strokeStyle = style.getPropertyValue("--focus");
    pen.lineWidth = 1;
    pen.beginPath();
    pen.moveTo(Math.round(this.#cursor) + 0.5, 4);
    pen.lineTo(Math.round(this.#cursor) + 0.5, height - BELOW);
    pen.stroke();
    const each = this.#lines.map(({ key }, at) => {
      const value = here.values[at];
      if (!value) return `${key} –`;
      return value[1] === value[2] ? `${key} ${glance(value[3])}` : `${key} ${glance(value[1])} … ${glance(value[2])}`;
    });
    const back = Math.max(0, end - here.at - here.width);
    put(this.#read, `−${duration(Math.round(back * 1e3) * 1e6)}: ${each.join("; ")} · ${count(here.samples)} samples`);
  }
}
