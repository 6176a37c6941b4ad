// How long activities were in each state: from the dated changes of the last minutes.

import { el, heads, name, put } from "./dom.js";
import { count, duration } from "./units.js";

/** Sums of one service. */
export class Spent {
  #states = new Map();
  #running = new Map();
  #ended = 0;
  #body = el("tbody");

  constructor(service) {
    this.node = el("details", { class: "spent" },
      el("summary", {}, "Time in each state"),
      el("div", { class: "wide" }, el("table", {}, el("caption", {}, "Of the activities of the last minutes"),
        heads(["State", "#Entered", "#Time", "#Mean", "#Longest", "Now"]), this.#body)));
    this.service = service;
  }

  /** Forgets all: everything that is kept comes again. */
  reset() {
    this.#states.clear();
    this.#running.clear();
    this.#ended = 0;
  }

  /** A change of an activity of this service, with its date in seconds. */
  take(at, { event, activity, state, paused }) {
    if (event === "activity_started") this.#enter(activity, "waiting to start", at, false);
    if (event === "transition") this.#enter(activity, String(state), at, paused === true);
    if (event === "activity_ended") {
      this.#leave(activity, at);
      this.#running.delete(activity);
      this.#ended += 1;
    }
  }

  #enter(activity, state, at, paused) {
    const before = this.#running.get(activity);
    if (before?.state === state) {
      before.paused = paused;
      return;
    }
    this.#leave(activity, at);
    this.#running.set(activity, { state, since: at, paused });
    this.#of(state).entered += 1;
  }

  #leave(activity, at) {
    const before = this.#running.get(activity);
    if (!before) return;
    const sums = this.#of(before.state);
    const time = Math.max(0, at - before.since);
    sums.total += time;
    sums.left += 1;
    sums.longest = Math.max(sums.longest, time);
  }

  #of(state) {
    if (!this.#states.has(state)) this.#states.set(state, { entered: 0, left: 0, total: 0, longest: 0 });
    return this.#states.get(state);
  }

  /** Draws the sums at this time, in seconds. */
  draw(now = this.now) {
    this.now = now;
    if (!this.node.open || now === undefined) return;
    const cell = (shown) => el("td", { class: "number" }, shown);
    if (this.#states.size === 0) {
      put(this.#body, el("tr", {}, el("td", { colspan: 6, class: "soft" }, "No activity in the last minutes.")));
      return;
    }
    put(this.#body, [...this.#states].map(([state, { entered, left, total, longest }]) => {
      const here = [...this.#running].filter(([, one]) => one.state === state);
      const times = here.map(([, { since }]) => Math.max(0, now - since));
      const whole = times.reduce((sum, one) => sum + one, total);
      const most = times.reduce((all, one) => Math.max(all, one), longest);
      const shown = (seconds) => duration(Math.round(seconds * 1e9));
      return el("tr", { "data-spent": state }, el("th", { scope: "row" }, name(state)), cell(count(entered)), cell(shown(whole)),
        cell(left + here.length > 0 ? shown(whole / (left + here.length)) : "–"), cell(shown(most)),
        el("td", {}, here.map(([activity, { paused }]) => el("span", { class: "token" }, `#${activity}${paused ? " paused" : ""}`))));
    }));
  }
}
