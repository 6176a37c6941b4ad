// The part of a drawing that is seen: zoom and pan with wheel, mouse, fingers and keys.

/** Screen pixels a unit of the drawing has at most, and at least. */
const LARGEST = 2.5;
const SMALLEST = 0.02;
/** Below this scale only titles are shown, larger. */
const FAR = 0.55;

export class View {
  #canvas;
  #layer;
  #at = { x: 0, y: 0, scale: 1 };
  #size = { width: 1, height: 1 };
  #waits = false;
  #moved;
  /** Whether the user chose what is seen. */
  chosen = false;

  /** `layer` is what moves within `canvas`; `moved(box)` hears which part of it is seen. */
  constructor(canvas, layer, moved) {
    this.#canvas = canvas;
    this.#layer = layer;
    this.#moved = moved;
    canvas.addEventListener("wheel", (event) => {
      event.preventDefault();
      const step = event.deltaMode === 1 ? event.deltaY * 30 : event.deltaY;
      this.zoom(Math.exp(-Math.max(-120, Math.min(120, step)) / 400), event);
    }, { passive: false });
    canvas.addEventListener("pointerdown", (event) => this.#grab(event));
  }

  /** The place of a pointer in the drawing. */
  point({ clientX, clientY }) {
    const box = this.#canvas.getBoundingClientRect();
    const { x, y, scale } = this.#at;
    return { x: (clientX - box.left - x) / scale, y: (clientY - box.top - y) / scale };
  }

  /** Where a point of the drawing is on the screen. */
  screen(point) {
    const box = this.#canvas.getBoundingClientRect();
    const { x, y, scale } = this.#at;
    return { x: box.left + x + point.x * scale, y: box.top + y + point.y * scale };
  }

  #grab(event) {
    if (event.button !== 0 || event.target.closest("[data-key]")) return;
    const fingers = new Map([[event.pointerId, event]]);
    const move = (now) => {
      const past = fingers.get(now.pointerId);
      if (!past) return;
      if (fingers.size === 2) {
        const other = [...fingers].find(([id]) => id !== now.pointerId)[1];
        const apart = (one) => Math.hypot(one.clientX - other.clientX, one.clientY - other.clientY);
        this.zoom(apart(now) / Math.max(1, apart(past)), { clientX: (now.clientX + other.clientX) / 2, clientY: (now.clientY + other.clientY) / 2 });
      }
      this.pan((now.clientX - past.clientX) / fingers.size, (now.clientY - past.clientY) / fingers.size);
      fingers.set(now.pointerId, now);
    };
    const more = (next) => fingers.size < 2 && fingers.set(next.pointerId, next);
    const end = (gone) => {
      fingers.delete(gone.pointerId);
      if (fingers.size > 0) return;
      for (const [kind, act] of acts) removeEventListener(kind, act);
    };
    const acts = [["pointermove", move], ["pointerdown", more], ["pointerup", end], ["pointercancel", end]];
    for (const [kind, act] of acts) addEventListener(kind, act);
  }

  pan(x, y) {
    this.chosen = true;
    this.#show({ ...this.#at, x: this.#at.x + x, y: this.#at.y + y });
  }

  /** Zooms around a pointer, or around the middle. */
  zoom(by, pointer) {
    const box = this.#canvas.getBoundingClientRect();
    const [x, y] = pointer ? [pointer.clientX - box.left, pointer.clientY - box.top] : [box.width / 2, box.height / 2];
    const scale = Math.max(SMALLEST, Math.min(LARGEST, this.#at.scale * by));
    const real = scale / this.#at.scale;
    this.chosen = true;
    this.#show({ x: x - (x - this.#at.x) * real, y: y - (y - this.#at.y) * real, scale });
  }

  /** Shows all of `box`, `{ x, y, width, height }`; few things are not blown up. */
  fit(box) {
    this.resize();
    const { width, height } = this.#size;
    if (!width || !height) return;
    const scale = Math.max(SMALLEST, Math.min(1.15, width / box.width, height / box.height));
    this.#at = { scale, x: (width - box.width * scale) / 2 - box.x * scale, y: (height - box.height * scale) / 2 - box.y * scale };
    // Not with the next frame: what has just been drawn would be seen, and clicked, elsewhere first.
    this.#apply();
  }

  /** Moves what is in `box` into the window, if it is not there. */
  reveal(box) {
    const { width, height } = this.#canvas.getBoundingClientRect();
    const { x, y, scale } = this.#at;
    const [left, top] = [box.x * scale + x, box.y * scale + y];
    const inside = left >= 0 && top >= 0 && left + box.width * scale <= width && top + box.height * scale <= height;
    if (inside) return;
    const near = Math.max(scale, 0.7);
    this.chosen = true;
    this.#show({ scale: near, x: width / 2 - (box.x + box.width / 2) * near, y: height / 2 - (box.y + box.height / 2) * near });
  }

  #show(at) {
    this.#at = at;
    if (this.#waits) return;
    this.#waits = true;
    requestAnimationFrame(() => {
      this.#waits = false;
      this.#apply();
    });
  }

  #apply() {
    const { x, y, scale } = this.#at;
    this.#layer.setAttribute("transform", `translate(${x.toFixed(1)} ${y.toFixed(1)}) scale(${scale.toFixed(4)})`);
    this.#canvas.classList.toggle("far", scale < FAR);
    this.#moved(this.seen());
  }

  /** The part of the drawing that is seen. */
  seen() {
    const { width, height } = this.#size;
    const { x, y, scale } = this.#at;
    return { x: -x / scale, y: -y / scale, width: width / scale, height: height / scale };
  }

  /** Measures the window anew: asked in each frame, its size would cost a layout. */
  resize() {
    const { width, height } = this.#canvas.getBoundingClientRect();
    this.#size = { width, height };
  }
}
