// Recordings that the daemon keeps: made, downloaded, replayed and removed here.

import { get, path, post, remove, told } from "./api.js";
import { el, heads, name, note, put } from "./dom.js";
import { bytes, count, seconds, timeOfDay } from "./units.js";

const TONES = { recording: "warn", whole: "good", cut: "bad", damaged: "bad" };

/** The name of a file without its ending. */
const plain = (file) => file.replace(/\.mcap$/, "");

/** Seconds since 1970 as a date with time, as it stands in the place of the browser. */
function date(when) {
  const at = new Date(when * 1000);
  const two = (number) => String(number).padStart(2, "0");
  return `${at.getFullYear()}-${two(at.getMonth() + 1)}-${two(at.getDate())} ${timeOfDay(when).slice(0, 8)}`;
}

export async function recordings(page, context) {
  const call = context.may("call");
  const rows = new Map();
  const body = el("tbody");
  const summary = el("p", { class: "soft", id: "room", role: "status" });
  const empty = el("p", { class: "empty" }, "No recording is kept.");
  const table = el("table", { class: "cards", id: "recordings" },
    heads(["Recording", "State", "Written", "#Size", "#Duration", "#Messages", "#Lost", "Actions"]), body);
  const made = call ? form() : null;
  put(page, el("h1", {}, "Recordings"),
    el("p", { class: "soft" }, "The daemon records ports, calls, activities and exceptions into MCAP files of its directory, which Foxglove and PlotJuggler read."),
    made?.node ?? el("p", {}, "Your rights do not allow to record or to replay."),
    el("section", { "aria-labelledby": "kept-title" }, el("h2", { id: "kept-title" }, "Kept recordings"), summary,
      el("div", { class: "wide" }, table), empty));

  function form() {
    const file = el("input", { id: "name", type: "text", autocomplete: "off", spellcheck: "false", maxlength: 70, placeholder: "the date" });
    const time = el("input", { id: "seconds", type: "number", min: 0, max: 86400, step: "any", placeholder: "until it is ended" });
    const what = el("select", { id: "what", multiple: true, size: 6, "aria-describedby": "what-help" });
    const problem = el("p", { class: "error", role: "alert", id: "problem" });
    const node = el("form", { class: "card stack", id: "record", novalidate: true },
      el("div", { class: "field" }, el("label", { for: "what" }, "What"), what,
        el("span", { class: "help", id: "what-help" }, "everything, if nothing is chosen")),
      el("div", { class: "field" }, el("label", { for: "name" }, "Name"), file,
        el("span", { class: "help" }, "letters, digits, . _ -")),
      el("div", { class: "field" }, el("label", { for: "seconds" }, "Duration, s"), time),
      el("div", { class: "row" }, el("button", { type: "submit", class: "main", id: "begin" }, "Record")), problem);
    node.addEventListener("submit", async (event) => {
      event.preventDefault();
      put(problem);
      try {
        const request = { ports: [...what.selectedOptions].map((one) => one.value) };
        if (file.value.trim()) request.name = file.value.trim();
        if (time.value !== "") request.seconds = Number(time.value);
        const begun = await post("/recordings/kept", JSON.stringify(request));
        note(`${begun.file} is being recorded`);
        file.value = "";
      } catch (error) {
        put(problem, told(error));
      }
    });
    return { node, what };
  }

  /** What can be recorded: components, and each of their ports. */
  async function choices() {
    const [{ components }, { ports }] = await Promise.all([get("/components"), get("/ports?values=false")]);
    put(made.what, components.map(({ name: component }) => el("optgroup", { label: component },
      el("option", { value: component }, `all of ${component}`),
      ports.filter(({ address }) => address.startsWith(`${component}/`)).map(({ address }) => el("option", { value: address }, address)))));
  }

  const own = (file) => path("recordings", "kept", file);

  /** A button that asks for something; its name says of which recording. */
  function button(text, file, act, attributes = {}) {
    const shown = el("button", { type: "button", "aria-label": `${text} ${file}`, "data-act": text, ...attributes }, text);
    shown.addEventListener("click", async () => {
      shown.disabled = true;
      try {
        await act();
      } catch (error) {
        note(told(error), "error");
      } finally {
        shown.disabled = false;
      }
    });
    return shown;
  }

  /** Asked about once more, since nothing brings it back. */
  function removal(file) {
    let sure = false;
    const shown = button("Remove", file, async () => {
      if (!sure) {
        sure = true;
        put(shown, "Press again to remove");
        return;
      }
      await remove(own(file));
      note(`${file} was removed`);
    }, { class: "danger" });
    return shown;
  }

  function buttons(one) {
    const { file, state, replay } = one;
    if (state === "recording") {
      return [call && button("End", file, () => post(`${own(file)}/end`), { class: "main" })];
    }
    return [
      el("a", { href: `/api${own(file)}`, download: file, "aria-label": `Download ${file}` }, "Download"),
      call && state !== "damaged" && (replay?.goes_on
        ? button("End the replay", file, () => remove(`${own(file)}/replay`))
        : button("Replay", file, async () => {
          const begun = await post(`${own(file)}/replay`, "{}");
          note(`${plain(file)} is published to ${begun.ports.join(", ")}`);
        })),
      context.may("admin") && !replay?.goes_on && removal(file),
    ];
  }

  /** How a replay is, or was. */
  function played(replay) {
    if (!replay) return null;
    const state = replay.goes_on ? "Replayed now" : "Replayed";
    return el("p", { class: "soft", "data-replay": replay.goes_on ? "on" : "over" },
      `${state}: ${count(replay.published)} samples, ${seconds(replay.seconds)}, to `, replay.ports.map((port) => [name(port), " "]),
      replay.left_out?.length > 0 && el("details", {}, el("summary", {}, `${replay.left_out.length} left out`),
        el("ul", {}, replay.left_out.map((why) => el("li", {}, name(why))))),
      replay.problem && el("span", { class: "warn" }, " ", replay.problem));
  }

  function row(one) {
    const cell = (label, extra) => el("td", { "data-label": label, ...extra });
    const number = { class: "number" };
    const shown = { state: cell("State"), written: cell("Written"), bytes: cell("Size", number), seconds: cell("Duration", number),
      messages: cell("Messages", number), lost: cell("Lost", number), does: cell("Actions", { class: "does" }), more: el("div") };
    shown.row = el("tr", { "data-file": one.file }, el("th", { scope: "row" }, name(one.file), shown.more),
      shown.state, shown.written, shown.bytes, shown.seconds, shown.messages, shown.lost, shown.does);
    return shown;
  }

  function take({ directory, most, most_bytes: mostBytes, bytes: taken, recordings: all }) {
    const there = new Set(all.map((one) => one.file));
    for (const [file, shown] of rows) {
      if (!there.has(file)) {
        shown.row.remove();
        rows.delete(file);
      }
    }
    all.forEach((one, at) => {
      const shown = rows.get(one.file) ?? row(one);
      rows.set(one.file, shown);
      if (body.children[at] !== shown.row) body.insertBefore(shown.row, body.children[at] ?? null);
      put(shown.state, el("span", { class: `pill ${TONES[one.state] ?? ""}`, title: one.why }, one.state));
      put(shown.written, date(one.written));
      put(shown.bytes, bytes(one.bytes));
      put(shown.seconds, one.seconds === undefined ? "–" : seconds(one.seconds));
      put(shown.messages, one.messages === undefined ? "–" : count(one.messages));
      put(shown.lost, one.lost === undefined ? "–" : count(one.lost));
      shown.lost.className = one.lost > 0 ? "number warn" : "number";
      // What can be done is drawn anew only when it is something else, so that the focus stays.
      const kind = `${one.state} ${one.replay?.goes_on}`;
      if (shown.kind !== kind) put(shown.does, el("div", { class: "row" }, buttons(one)));
      shown.kind = kind;
      const about = JSON.stringify([one.replay, one.state, one.why]);
      if (shown.about !== about) {
        put(shown.more, one.why && one.state !== "recording" && one.why !== "asked" && el("p", { class: "soft" }, one.why),
          one.state === "cut" && el("p", { class: "soft" }, "Its end is missing: ", el("code", {}, "genomctl recover"), " makes a whole one of it."),
          played(one.replay));
      }
      shown.about = about;
    });
    table.hidden = all.length === 0;
    empty.hidden = all.length > 0;
    put(summary, `${all.length} of ${count(most)} recordings, ${bytes(taken)} of ${bytes(mostBytes)}`,
      directory ? [", in ", el("bdi", { class: "path" }, directory)] : ". There is no directory for them: set recordings.directory.");
  }

  if (made) await choices();
  context.watch([{ path: "/recordings/kept", take: (answer, status) => status === 200 && take(answer) }], 2);
}
