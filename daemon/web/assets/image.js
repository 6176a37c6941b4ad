// The value of a port as an image: asked for again and again while it is seen, at a bounded rate,
// at most as wide as it is shown.

import { bytes, told } from "./api.js";
import { el, put } from "./dom.js";
import { frequency } from "./units.js";

/** Least time between two images, in ms. */
const SOONEST = 100;
/** Time until it asks again after a refusal, in ms. */
const LATER = 2000;
/** Widest image that is asked for, in pixels. */
const WIDEST = 1280;

/** Whether values of a type are images, by its ROS 2 definition. */
export function isImage(definition) {
  const own = String(definition ?? "").split("\n===")[0];
  const names = own.split("\n").map((line) => line.replace(/#.*/, "").trim().split(/\s+/)[1]);
  const has = (...all) => all.every((one) => names.includes(one));
  return has("height", "width", "encoding", "step", "data") || has("format", "data");
}

export class Picture {
  #canvas = el("canvas", { class: "picture", role: "img", width: 320, height: 180 });
  #told = el("figcaption", { class: "soft" }, "no image yet");
  #gone = false;
  #seen;
  #dates = [];
  #timer;

  constructor(address, path, query) {
    this.address = address;
    this.path = path;
    this.query = query;
    this.#canvas.setAttribute("aria-label", `Image of ${address}: none yet`);
    this.node = el("figure", { class: "pictured" }, this.#canvas, this.#told);
    this.#ask();
  }

  close() {
    this.#gone = true;
    clearTimeout(this.#timer);
  }

  async #ask() {
    const began = performance.now();
    let wait = SOONEST;
    try {
      // What nobody sees is not asked for.
      if (!document.hidden) await this.#show();
    } catch (error) {
      put(this.#told, el("span", { class: "bad" }, told(error)));
      wait = LATER;
    }
    if (this.#gone) return;
    this.#timer = setTimeout(() => this.#ask(), Math.max(0, wait - (performance.now() - began)));
  }

  async #show() {
    const wide = Math.min(WIDEST, Math.max(64, Math.round((this.node.clientWidth || 640) * (devicePixelRatio || 1))));
    const query = new URLSearchParams([...this.query, ["width", wide]]);
    if (this.#seen !== undefined) query.append("seen", this.#seen);
    const { headers, buffer } = await bytes(`${this.path}?${query}`);
    const sample = headers.get("image-sample");
    if (this.#gone || sample === null) return;
    this.#seen = sample;
    const [width, height, whole] = headers.get("content-type") === "application/octet-stream"
      ? this.#pixels(headers, new Uint8Array(buffer)) : await this.#compressed(headers, buffer);
    const now = performance.now();
    this.#dates = [...this.#dates.filter((date) => now - date < 3000), now];
    const rate = this.#dates.length > 1 ? 1000 * (this.#dates.length - 1) / (now - this.#dates[0]) : 0;
    const size = `${width} × ${height} px`;
    put(this.#told, size, whole && ` of ${whole}`, ` · sample ${sample}`, rate > 0 && ` · ${frequency(rate)} shown`);
    this.#canvas.setAttribute("aria-label", `Image of ${this.address}: ${size}, sample ${sample}`);
  }

  #size(width, height) {
    if (this.#canvas.width !== width || this.#canvas.height !== height) {
      this.#canvas.width = width;
      this.#canvas.height = height;
    }
  }

  #pixels(headers, rgb) {
    const [width, height] = [Number(headers.get("image-width")), Number(headers.get("image-height"))];
    const whole = headers.get("image-whole");
    if (width > 0 && height > 0 && rgb.length === 3 * width * height) {
      this.#size(width, height);
      const image = new ImageData(width, height);
      for (let from = 0, to = 0; from < rgb.length; from += 3, to += 4) {
        image.data[to] = rgb[from];
        image.data[to + 1] = rgb[from + 1];
        image.data[to + 2] = rgb[from + 2];
        image.data[to + 3] = 255;
      }
      this.#canvas.getContext("2d").putImageData(image, 0, 0);
    }
    return [width, height, whole === `${width}x${height}` ? null : whole.replace("x", " × ")];
  }

  async #compressed(headers, buffer) {
    const blob = new Blob([buffer], { type: headers.get("content-type") });
    let bitmap;
    try {
      bitmap = await createImageBitmap(blob);
    } catch {
      throw new Error("the compressed image is damaged");
    }
    const smaller = Math.min(1, WIDEST / bitmap.width);
    this.#size(Math.max(1, Math.round(bitmap.width * smaller)), Math.max(1, Math.round(bitmap.height * smaller)));
    this.#canvas.getContext("2d").drawImage(bitmap, 0, 0, this.#canvas.width, this.#canvas.height);
    const sizes = [bitmap.width, bitmap.height, "a compressed one"];
    bitmap.close();
    return sizes;
  }
}
