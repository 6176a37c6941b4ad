// Deployments: a file against what runs, the steps that it takes, and what runs as a file.

import { get, post, told } from "./api.js";
import { el, name, note, put, text as shown } from "./dom.js";

/** Larger files are no deployments; the daemon has a limit of its own. */
const LARGEST = 4 << 20;
/** Characters of what runs that are shown; all are saved. */
const SHOWN = 200000;
/** Seconds that connections may wait for their other side. */
const PATIENCE = "10";
/** What was written, so that it is still there when somebody has looked at another page. */
const draft = { text: "", file: "deployment.toml" };

/** Has the browser save a text as a file. */
function save(text, file, media) {
  const url = URL.createObjectURL(new Blob([text], { type: media }));
  el("a", { href: url, download: file }).click();
  setTimeout(() => URL.revokeObjectURL(url), 10000);
}

export async function deployment(page, context) {
  const may = context.may("admin");
  const running = el("pre", { class: "value", id: "running", tabindex: 0, "aria-label": "What runs, as a deployment file" });
  const mine = may ? form() : null;
  let runs = "";
  put(page, el("h1", {}, "Deployment"),
    el("p", { class: "soft" }, "A file names components, connections, calls and activities. What it says and is there already stays as it is."),
    mine?.node ?? el("p", {}, "Your rights do not allow to apply a file."),
    el("section", { "aria-labelledby": "running-title" },
      el("div", { class: "title" }, el("h2", { id: "running-title" }, "What runs"),
        el("button", { type: "button", id: "save-running", onclick: () => save(runs, "deployment.toml", "application/toml") }, "Save as a file"),
        may && el("button", { type: "button", id: "take-running", onclick: () => mine.write(runs) }, "Edit it above")),
      running));

  async function look() {
    ({ text: runs } = await get("/deployment"));
    put(running, shown(runs, SHOWN));
  }

  function form() {
    const text = el("textarea", { id: "text", rows: 14, spellcheck: "false", autocomplete: "off", wrap: "off" });
    text.value = draft.text;
    const file = el("input", { id: "file", type: "text", spellcheck: "false", autocomplete: "off", value: draft.file });
    const choose = el("input", { id: "choose", type: "file", accept: ".toml,text/plain" });
    const prune = el("input", { id: "prune", type: "checkbox" });
    const patience = el("input", { id: "patience", type: "number", min: 0, max: 86400, step: "any", value: PATIENCE });
    const plan = el("button", { type: "submit", class: "main", id: "plan" }, "Show the plan");
    const apply = el("button", { type: "button", class: "danger", id: "apply", disabled: true }, "Apply");
    const problem = el("p", { class: "error", role: "alert", id: "problem" });
    const outcome = el("p", { role: "status", id: "outcome" });
    const list = el("ol", { class: "steps", id: "steps", "aria-label": "Steps" });
    let planned = null;
    let items = [];
    let atWork = false;

    /** A plan is of one text: when anything changes, it is made again. */
    function forget() {
      Object.assign(draft, { text: text.value, file: file.value });
      planned = null;
      apply.disabled = true;
      put(outcome);
      put(list);
      put(problem);
      text.removeAttribute("aria-invalid");
    }

    function write(content) {
      text.value = content;
      forget();
      text.focus();
      text.setSelectionRange(0, 0);
      text.scrollTop = 0;
    }

    async function read() {
      const [chosen] = choose.files;
      if (!chosen) return;
      if (chosen.size > LARGEST) {
        put(problem, `${chosen.name} is larger than ${LARGEST >> 20} MiB`);
        return;
      }
      const content = await chosen.text();
      file.value = chosen.name;
      write(content);
    }

    const request = (dry) => ({ text: text.value, file: file.value || "deployment.toml", prune: prune.checked, dry_run: dry,
      timeout: patience.value === "" ? undefined : Number(patience.value) });

    function refused(error) {
      put(problem, told(error));
      // The place of a mistake is `FILE:LINE:` at the beginning of the message.
      const line = Number(/^[^\n]*?:(\d+):/.exec(error.message ?? "")?.[1]);
      if (!Number.isInteger(line) || line < 1) return;
      const lines = text.value.split("\n");
      if (line > lines.length) return;
      const begin = lines.slice(0, line - 1).reduce((sum, one) => sum + one.length + 1, 0);
      text.setAttribute("aria-invalid", "true");
      text.focus();
      text.setSelectionRange(begin, begin + lines[line - 1].length);
      text.scrollTop = (text.scrollHeight / lines.length) * (line - 3);
    }

    function draw(steps, status) {
      items = steps.map((step) => {
        const mark = el("span", { class: "pill" }, status);
        return { step, mark, node: el("li", { "data-status": status }, mark, " ", name(step)) };
      });
      put(list, items.map((one) => one.node));
    }

    function mark(one, status, tone = "") {
      one.node.dataset.status = status;
      one.mark.className = `pill ${tone}`;
      put(one.mark, status);
    }

    async function show(event) {
      event.preventDefault();
      forget();
      const asked = request(true);
      plan.disabled = true;
      try {
        const { steps, beside } = await post("/deployment", JSON.stringify(asked));
        planned = { ...asked, dry_run: false };
        draw(steps, "to do");
        const kept = beside.length > 0 ? ` Beside the file, and kept: ${beside.join(", ")}.` : "";
        put(outcome, (steps.length === 0 ? "Nothing to do: all that the file says is so."
          : `${steps.length} ${steps.length === 1 ? "step" : "steps"} to take.`) + kept);
        apply.disabled = steps.length === 0;
      } catch (error) {
        refused(error);
      } finally {
        plan.disabled = false;
      }
    }

    async function take() {
      const asked = planned;
      if (!asked) return;
      planned = null;
      atWork = true;
      [plan, apply, text, prune].forEach((one) => { one.disabled = true; });
      put(problem);
      put(outcome, "Being applied…");
      try {
        const { steps } = await post("/deployment", JSON.stringify(asked));
        // What the daemon did, also where something changed since the plan.
        draw(steps, "done");
        items.forEach((one) => mark(one, "done", "good"));
        put(outcome, `Applied: ${steps.length} ${steps.length === 1 ? "step was" : "steps were"} taken.`);
        note("The deployment was applied");
      } catch (error) {
        for (const one of items) {
          const status = one.node.dataset.status;
          if (status === "under way") mark(one, "refused", "bad");
          else mark(one, status === "done" ? "undone" : "not taken", "warn");
        }
        put(outcome, "Not applied.");
        text.disabled = false;
        refused(error);
      } finally {
        atWork = false;
        [plan, text, prune].forEach((one) => { one.disabled = false; });
        look().catch(() => {});
      }
    }

    /** What the daemon does meanwhile, step by step. */
    function hear({ event, step, status }) {
      if (!atWork) return;
      const found = items.find((one) => one.step === step && !["done", "refused"].includes(one.node.dataset.status));
      if (!found) return;
      if (event === "deployment_waits") mark(found, "waits", "warn");
      else if (status === "begun") mark(found, "under way", "warn");
      else mark(found, "done", "good");
    }

    for (const one of [text, file, patience]) one.addEventListener("input", forget);
    prune.addEventListener("change", forget);
    choose.addEventListener("change", () => read().catch(() => put(problem, "the file cannot be read")));
    apply.addEventListener("click", take);
    const node = el("form", { class: "card stack", id: "deploy", novalidate: true, onsubmit: show },
      el("div", { class: "field" }, el("label", { for: "choose" }, "Choose a file"), choose),
      el("label", { for: "text" }, "Or write it here"), text,
      el("div", { class: "field" }, el("label", { for: "file" }, "Its place on the robot"), file,
        el("span", { class: "help" }, "relative paths in it begin there")),
      el("div", { class: "field" }, el("label", { for: "patience" }, "Wait for connections, s"), patience,
        el("span", { class: "help" }, "for the other side of each")),
      el("div", { class: "field inline" }, prune, el("label", { for: "prune" }, "Remove components and connections that are not in the file")),
      el("div", { class: "row" }, plan, apply), problem, outcome, list);
    return { node, write, hear };
  }

  await look();
  context.watch([{ path: "/events?only=deployment_step,deployment_waits", hear: (change) => mine?.hear(change) }], 4);
}
