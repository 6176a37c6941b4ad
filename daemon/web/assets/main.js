// The console: which page is shown, who is signed in, and whether the daemon answers.

import { Away, remove, session, told } from "./api.js";
import { el, link, name, note, put } from "./dom.js";
import { Live } from "./live.js";
import { component } from "./component.js";
import { graph } from "./graph.js";
import { logs } from "./logs.js";
import { overview } from "./overview.js";

const page = document.getElementById("page");
const bar = document.getElementById("bar");

/** A page whose script is loaded when it is first shown. */
const later = (load, name) => async (page, context) => {
  const loaded = await load().catch(() => { throw new Away(); });
  return context.stillShown() ? loaded[name](page, context) : null;
};

const PAGES = [
  [/^\/$/, "Overview", overview],
  [/^\/graph$/, "Graph", graph],
  [/^\/logs$/, "Logs and events", logs],
  [/^\/timeline$/, "Timeline", later(() => import("./timeline.js"), "timeline")],
  [/^\/doctor$/, "Doctor", later(() => import("./doctor.js"), "doctor")],
  [/^\/deployment$/, "Deployment", later(() => import("./deployment.js"), "deployment")],
  [/^\/recordings$/, "Recordings", later(() => import("./recordings.js"), "recordings")],
  [/^\/component\/([^/]+)$/, "Component", component],
];

let signed = null;
let live = null;
let leave = null;
let turn = 0;

const may = (right) => signed.rights.includes(right) || signed.rights.includes("admin");

function state(text, kind) {
  const pill = document.getElementById("state");
  if (pill) {
    put(pill, text);
    pill.className = `pill ${kind}`;
  }
}

function drawBar() {
  const at = location.pathname;
  const entry = (to, text) =>
    el("a", { href: to, "data-within": true, "aria-current": at === to ? "page" : undefined }, text);
  const stop = el("button", { type: "button", class: "danger", id: "stop-all", onclick: stopAll,
    title: "Ask all activities of all components to stop" }, "Stop all");
  const out = el("button", { type: "button", class: "plain", id: "sign-out", onclick: signOut }, "Sign out");
  const rights = signed?.rights.join(", ") || "no right";
  put(bar,
    el("div", { class: "brand" }, el("img", { src: "/assets/icon.svg", alt: "", width: 24, height: 24 }),
      link("/", "genomd")),
    signed && el("nav", { "aria-label": "Pages" },
      entry("/", "Overview"), entry("/graph", "Graph"), entry("/timeline", "Timeline"), entry("/logs", "Logs"),
      entry("/doctor", "Doctor"), entry("/deployment", "Deployment"), entry("/recordings", "Recordings")),
    el("span", { class: "gap" }),
    signed && el("span", { id: "state", class: "pill", role: "status" }, "…"),
    signed && may("call") && stop,
    signed && el("details", { class: "who" },
      el("summary", {}, "Session"),
      el("div", { class: "card" }, el("p", {}, name(signed.who)),
        el("p", {}, "Rights: ", el("strong", { id: "rights" }, rights)),
        el("p", { class: "soft" }, `genomd ${signed.genomd}`), out)));
}

async function stopAll() {
  try {
    const { aborted } = await remove("/activities");
    note(aborted.length === 1 ? "1 activity was asked to stop" : `${aborted.length} activities were asked to stop`);
  } catch (error) {
    note(told(error), "error");
  }
}

async function signOut() {
  try {
    await session.close();
  } finally {
    signed = null;
    show();
  }
}

/** What a page gets: where to draw, its rights, and its live stream. */
function context(turnOfPage) {
  return {
    may,
    redraw: show,
    title: (text) => { document.title = `${text} · genomd`; },
    stillShown: () => turn === turnOfPage,
    watch(watched, rate) {
      if (turn !== turnOfPage) return null;
      live?.close();
      live = new Live(watched, hear, rate);
      return live;
    },
    console: signed.console,
  };
}

function hear(what, count) {
  if (what === "live") state("live", "good");
  // What the page shows is complete with the next frame: programs that measure read this.
  if (what === "values") requestAnimationFrame(() => performance.mark("shown"));
  if (what === "skipped") state(`live, ${count} readings skipped`, "warn");
  if (what === "away") state("daemon away, trying again", "bad");
  if (what === "back") show();
  if (what === "over") { signed = null; show(); }
}

/** Shows the page of the present address. */
async function show() {
  turn += 1;
  const own = turn;
  live?.close();
  live = null;
  leave?.();
  leave = null;
  try {
    await comeIn();
  } catch (error) {
    if (own !== turn) return;
    if (error.status === undefined) return wait(own);
    signed = null;
    return signIn(error.code === "link_over" ? told(error) : undefined);
  }
  if (own !== turn) return;
  const found = PAGES.map(([pattern, title, draw]) => [location.pathname.match(pattern), title, draw])
    .find(([match]) => match);
  drawBar();
  if (!found) {
    put(page, el("h1", {}, "There is no such page"), el("p", {}, link("/", "Overview")));
    return;
  }
  const [match, title, draw] = found;
  document.title = `${title} · genomd`;
  try {
    const parts = match.slice(1).map(decodeURIComponent);
    const left = await draw(page, context(own), ...parts);
    if (own === turn) leave = left ?? null;
    else left?.();
  } catch (error) {
    if (own !== turn) return;
    if (error.status === undefined && error.name === "Error") return wait(own);
    if (error.status === undefined) throw error;
    put(page, el("h1", {}, title), el("p", { class: "error", role: "alert" }, told(error)),
      el("p", {}, link("/", "Overview")));
  }
}

/** No daemon answers: the page comes when it does. */
function wait(own) {
  if (signed) drawBar();
  state("daemon away, trying again", "bad");
  put(page, el("p", { class: "empty" }, "The daemon does not answer. This page comes back when it does."));
  setTimeout(() => own === turn && show(), 1000);
}

/** Makes sure of a session; a link's one-time token comes after `#`. */
async function comeIn() {
  const once = location.pathname === "/sign-in" ? location.hash.slice(1) : "";
  if (location.pathname === "/sign-in") history.replaceState(null, "", "/");
  if (!once) {
    signed = await session.look();
    return;
  }
  try {
    signed = await session.open({ link: once });
  } catch (refused) {
    // Whoever opened the link before in this browser is still signed in.
    if (refused.code !== "link_over") throw refused;
    signed = await session.look().catch(() => { throw refused; });
  }
}

function signIn(problem) {
  drawBar();
  document.title = "Sign in · genomd";
  const input = el("input", { id: "token", type: "password", autocomplete: "off", spellcheck: "false", required: true });
  const told_ = el("p", { class: "error", role: "alert" }, problem ?? "");
  const form = el("form", { class: "card sign-in" },
    el("h1", {}, "Sign in"),
    el("p", {}, "Run ", el("code", {}, "genomctl web"), " on the robot and open the link that it prints."),
    el("p", { class: "soft" }, "Or use a token of the daemon's token file:"),
    el("label", { for: "token" }, "Token"), input,
    el("button", { type: "submit", class: "main" }, "Sign in"), told_);
  form.addEventListener("submit", async (event) => {
    event.preventDefault();
    try {
      signed = await session.open({ token: input.value });
      show();
    } catch (error) {
      put(told_, told(error));
      input.value = "";
      input.focus();
    }
  });
  put(page, form);
  input.focus();
}

document.addEventListener("click", (event) => {
  const to = event.target.closest?.("a[data-within]");
  if (!to || event.defaultPrevented || event.button !== 0 || event.metaKey || event.ctrlKey || event.shiftKey) return;
  event.preventDefault();
  // Links in drawings have no `href` of text.
  const address = new URL(to.getAttribute("href"), location.href).href;
  if (address !== location.href) history.pushState(null, "", address);
  show();
  page.focus({ preventScroll: true });
  scrollTo(0, 0);
});
addEventListener("popstate", show);
addEventListener("hashchange", () => location.pathname === "/sign-in" && show());
addEventListener("signed-out", () => {
  if (signed) {
    signed = null;
    show();
  }
});
show();
