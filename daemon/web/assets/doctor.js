// What keeps components from running well, and why a port is silent: findings of the daemon, with
// the requests that mend them.

import { get, path, request, told } from "./api.js";
import { el, link, name, note, pageOf, put, whyOf } from "./dom.js";
import { parts } from "./port.js";

const LEVELS = { problem: "bad", note: "warn", ok: "good" };

/** Advice: what stands between backticks is to be typed. */
function advice(text) {
  return text.split("`").map((part, at) => at % 2 === 1 ? el("code", {}, part) : part);
}

export async function doctor(page, context) {
  const asked = new URLSearchParams(location.search).get("port") ?? "";
  const findings = el("div", { class: "stack", id: "findings", "aria-live": "polite" });
  const silent = el("div", { class: "stack", id: "why", "aria-live": "polite" });
  // Its times change all the while: it is not read aloud.
  const flows = el("div", { id: "flows" });
  const way = el("p");
  const cards = new Map();
  let live = null;
  const again = el("button", { type: "button", id: "again", onclick: () => examine() }, "Examine again");
  const choice = el("select", { id: "port" });
  put(page,
    el("h1", {}, "Doctor"),
    el("section", { "aria-labelledby": "why-title" }, el("h2", { id: "why-title" }, "Why is a port silent?"),
      el("div", { class: "field" }, el("label", { for: "port" }, "Port or remote"), choice), flows, silent, way),
    el("section", { "aria-labelledby": "findings-title" },
      el("div", { class: "title" }, el("h2", { id: "findings-title" }, "This daemon and its machine"), again), findings));

  let ports = [];

  /** All ports, and remotes, as they are now. */
  async function choices() {
    const [of, { components }] = await Promise.all([get("/ports?values=false"), get("/components")]);
    ports = of.ports;
    const remotes = components.flatMap((one) => (one.remotes ?? []).map((remote) => `${one.name}/${remote}`));
    // Elements of a multiple port are told with it.
    const known = [...new Set(ports.map(({ address }) => address.split("/").slice(0, 2).join("/"))), ...remotes];
    const port = choice.value || asked;
    const all = !port || known.includes(port) ? known : [port, ...known];
    put(choice, el("option", { value: "" }, "choose one"), all.map((one) => el("option", { value: one, selected: one === port }, one)));
  }

  /** What the page reads all the time: findings on the port that was chosen come and go. */
  function watched() {
    const port = choice.value;
    if (!port) return [{ path: "/cells", take() {} }];
    const { component, port: own } = parts(port);
    return [{ path: `${path("components", component, "ports", own ?? "")}/why`, take: (found, status) => tell(port, found, status) }];
  }

  function why() {
    const port = choice.value;
    history.replaceState(null, "", port ? whyOf(port) : "/doctor");
    put(flows);
    put(silent);
    put(way, port && link(pageOf(parts(port).component), "Page of ", name(parts(port).component)));
    cards.clear();
    if (live) live.watch(watched());
    else live = context.watch(watched(), 1);
  }

  function tell(port, found, status) {
    if (choice.value !== port) return;
    if (status !== 200) {
      cards.clear();
      put(flows);
      put(silent, el("p", { class: "error", role: "alert" }, found?.error ? told(found.error) : `the daemon answers ${status}`));
      return;
    }
    put(flows, (found.flows ?? []).map((flow) => el("p", { class: "good" }, "Data flows: ", flow)),
      found.findings.length === 0 && !found.flows?.length && el("p", { class: "good" }, "Nothing is wrong."));
    if (cards.size === 0) put(silent);
    // A finding that stays keeps its element, and its buttons the focus, while its numbers change.
    const now = new Map();
    for (const one of found.findings) {
      const kind = JSON.stringify(one).replace(/\d+/g, "#");
      let key = kind;
      for (let next = 2; now.has(key); next += 1) key = `${kind} ${next}`;
      now.set(key, one);
    }
    for (const [key, shown] of cards) {
      if (now.has(key) && shown.remedies === JSON.stringify(now.get(key).remedies)) continue;
      shown.node.remove();
      cards.delete(key);
    }
    let at = 0;
    for (const [key, one] of now) {
      const shown = cards.get(key) ?? { remedies: JSON.stringify(one.remedies),
        node: card({ ...one, level: one.unmet ? "problem" : "note", about: port }) };
      cards.set(key, shown);
      put(shown.node.querySelector(".what"), name(one.what));
      if (silent.children[at] !== shown.node) silent.insertBefore(shown.node, silent.children[at] ?? null);
      at += 1;
    }
  }

  async function examine() {
    again.disabled = true;
    put(findings, el("p", { class: "soft" }, "Examining…"));
    try {
      const { machine, daemon } = await get("/doctor");
      if (!context.stillShown()) return;
      const all = [...daemon, ...machine];
      const wrong = ["problem", "note"].flatMap((level) => all.filter((one) => one.level === level));
      const fine = all.filter((one) => one.level === "ok");
      put(findings,
        wrong.length === 0 && el("p", { class: "good" }, "Nothing is wrong."),
        wrong.map(card),
        el("details", {}, el("summary", {}, `In order: ${fine.length}`),
          el("ul", {}, fine.map((one) => el("li", {}, name(one.about), ": ", name(one.what))))));
    } catch (error) {
      put(findings, el("p", { class: "error", role: "alert" }, told(error)));
    } finally {
      again.disabled = false;
    }
  }

  function card(one) {
    const mine = (one.remedies ?? []).filter((remedy) => context.may(remedy.right));
    return el("article", { class: "card finding", "data-level": one.level },
      el("p", {}, el("span", { class: `pill ${LEVELS[one.level] ?? ""}` }, one.level), " ",
        el("strong", {}, name(one.about)), " ", el("span", { class: "what" }, name(one.what))),
      one.fix && el("p", { class: "fix" }, advice(one.fix)),
      one.see && el("p", {}, link(whyOf(one.see), "Why is ", name(one.see), " silent?")),
      mine.length > 0 && el("div", { class: "row" }, mine.map(button)));
  }

  /** A request that may help; one that ends something is asked about once more. */
  function button(remedy) {
    const removes = remedy.method === "DELETE";
    const fitting = remedy.choose === "out_port" ? outPorts(remedy.body?.in) : null;
    if (fitting?.length === 0) return el("span", { class: "soft" }, "No out port here has its type.");
    const from = fitting && el("select", { "aria-label": `Out port for ${remedy.body.in}` },
      fitting.map((one) => el("option", { value: one }, one)));
    let sure = !removes;
    const made = el("button", { type: "button", class: removes ? "danger" : "main", "data-does": remedy.does }, remedy.does);
    made.addEventListener("blur", () => {
      if (!removes || made.disabled) return;
      sure = false;
      put(made, remedy.does);
    });
    made.addEventListener("click", async () => {
      if (!sure) {
        sure = true;
        put(made, remedy.does, ": press again to do it");
        return;
      }
      made.disabled = true;
      try {
        const body = from ? { ...remedy.body, out: from.value } : remedy.body;
        await request(remedy.method, remedy.path, body === undefined ? "" : JSON.stringify(body));
        note(`Done: ${remedy.does}`);
        await Promise.all([choices(), examine()]);
      } catch (error) {
        note(told(error), "error");
      } finally {
        made.disabled = false;
        sure = !removes;
        put(made, remedy.does);
      }
    });
    return [from, made];
  }

  /** Out ports that an in port can read. */
  function outPorts(inport) {
    const base = inport?.split("/").slice(0, 2).join("/");
    const reader = ports.find((one) => one.address === inport) ?? ports.find((one) => one.address.startsWith(`${base}/`) || one.address === base);
    return ports.filter((one) => one.direction === "out" && one.digest === reader?.digest).map((one) => one.address);
  }

  choice.addEventListener("change", why);
  await choices();
  if (!context.stillShown()) return;
  why();
  // May take a while; the page is there meanwhile.
  examine();
}
