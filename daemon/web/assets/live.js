// The live stream of the page: one connection, which names all that the page shows. It is closed
// while nobody looks at the page, and comes back by itself when the daemon does.

import { session } from "./api.js";

const SOONEST = 300;
const LATEST = 3000;

export class Live {
  #watched = [];
  #rate;
  #source;
  #timer;
  #delay = SOONEST;
  #closed = false;
  #wasAway = false;
  #tell;
  #read = new Set();
  #complete = false;
  #seen = () => this.#seeing();

  /**
   * `watched`: `{ path, take(body, status) }` for what is read, `{ path, hear(data, kind),
   * ended(reason) }` for streams, `ended` if it is refused for good. `tell(state)` hears "live",
   * "away", "back" (after it was away: what the page shows may be of another daemon), "values" (the
   * first reading of everything is there) and "over" (the session has ended).
   */
  constructor(watched, tell, rate = 10) {
    this.#watched = watched;
    this.#rate = rate;
    this.#tell = tell;
    document.addEventListener("visibilitychange", this.#seen);
    this.#seeing();
  }

  close() {
    this.#closed = true;
    document.removeEventListener("visibilitychange", this.#seen);
    this.#stop();
  }

  /** Watches something else from now on. */
  watch(watched) {
    this.#watched = watched;
    this.#stop();
    this.#seeing();
  }

  #stop() {
    clearTimeout(this.#timer);
    this.#source?.close();
    this.#source = undefined;
  }

  #seeing() {
    if (this.#closed) return;
    if (document.hidden) this.#stop();
    else if (!this.#source) this.#open();
  }

  #open() {
    const query = new URLSearchParams([["rate", this.#rate]]);
    for (const one of this.#watched) query.append("watch", one.path);
    const source = new EventSource(`/live?${query}`);
    this.#source = source;
    source.onopen = () => {
      this.#delay = SOONEST;
      const back = this.#wasAway;
      this.#wasAway = false;
      this.#tell(back ? "back" : "live");
    };
    source.onmessage = (event) => this.#take(JSON.parse(event.data));
    source.onerror = () => this.#lost();
  }

  #take(told) {
    if (told.over) {
      this.#stop();
      this.#tell("over");
      return;
    }
    if (told.skipped !== undefined) {
      this.#tell("skipped", told.skipped);
      return;
    }
    const one = this.#watched[told.watch];
    if (told.ended) {
      // What is asked for cannot be: asking again does not help.
      if (told.status === 422) return one?.ended?.(told.error);
      // What was streamed is gone, or the stream was refused: the page asks again.
      clearTimeout(this.#timer);
      this.#timer = setTimeout(() => this.watch(this.#watched), 1000);
      return;
    }
    if (told.told !== undefined) one?.hear?.(told.told, told.kind, told.id);
    else one?.take?.(told.body, told.status);
    if (!this.#complete) this.#count(told.watch);
  }

  #count(watch) {
    this.#read.add(watch);
    if (this.#watched.some((one, at) => one.take && !this.#read.has(at))) return;
    this.#complete = true;
    this.#tell("values");
  }

  async #lost() {
    this.#stop();
    if (this.#closed) return;
    try {
      await session.look();
      // It answers: the stream alone was lost, or the daemon is back.
    } catch (error) {
      if (error.status === 401) return this.#tell("over");
      this.#wasAway = true;
      this.#tell("away");
      if (this.#closed || document.hidden) return;
      this.#timer = setTimeout(() => this.#lost(), this.#delay);
      this.#delay = Math.min(this.#delay * 1.5, LATEST);
      return;
    }
    if (this.#closed) return;
    this.#wasAway = true;
    this.#timer = setTimeout(() => this.#seeing(), this.#wasAway ? SOONEST : 0);
  }
}
