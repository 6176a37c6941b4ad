// Makes, changes, moves and removes connections, each after a question that Enter answers.

import { get, path, post, remove, replace } from "./api.js";
import { ask, choose } from "./dialog.js";
import { el, name, note } from "./dom.js";
import { parts } from "./port.js";
import { middlewares } from "./units.js";

const POLICIES = [["latest", "latest: only the newest sample"], ["queue", "queue: new ones dropped when full"], ["ring", "ring: old ones dropped when full"]];

/** Why an out port and an in port do not fit, as far as is known before they are connected. */
export function mismatch(from, to) {
  if (from.service || to.remote) {
    return from.service && to.remote ? undefined : "a remote calls a service, and an in port reads an out port";
  }
  if (!from.digest || !to.digest || from.digest === to.digest) return undefined;
  const type = (port) => port.type.replace(/^::/, "");
  return `${to.address} reads ${type(to)}, and ${from.address} carries ${type(from)}: only ports of equal types can be connected`;
}

const way = (out, into) => el("p", { class: "way" }, name(out), " → ", name(into));

/** Fields of a connection; `json()` is the request. */
function fields(from, to, now) {
  // An element of a multiple port begins with its connection.
  const whole = to.multiple && parts(to.address).element === undefined;
  const element = whole && el("input", { id: "element", type: "text", autocomplete: "off", required: true });
  const named = whole && el("div", { class: "field" }, el("label", { for: "element" }, "Element"), element, el("span", { class: "help" }, "a name of your choice"));
  const into = () => whole ? `${to.address}/${element.value}` : to.address;
  if (to.remote) return { nodes: [], json: () => JSON.stringify({ in: to.address, out: from.address }) };
  const [had, size] = (now?.policy ?? "latest").split(":");
  const policy = choose("policy", "Policy", POLICIES, had);
  const count = el("input", { id: "size", type: "number", min: 1, max: 65536, value: size ?? "10", required: true });
  const sized = el("div", { class: "field", hidden: had === "latest" }, el("label", { for: "size" }, "Samples kept"), count, el("span", { class: "help" }, "1 to 65536"));
  policy.input.addEventListener("change", () => { sized.hidden = policy.input.value === "latest"; });
  const known = middlewares(from.backend);
  const usual = known.length > 1 ? [["", "the first that both have"]] : [];
  const backend = choose("backend", "Middleware", [...usual, ...known.map((one) => [one, one])], now?.backend ?? "",
    known.length > 1 ? undefined : "of the out port");
  return {
    nodes: [named, policy.node, sized, backend.node],
    json() {
      const request = { in: into(), out: from.address, policy: policy.input.value === "latest" ? "latest" : `${policy.input.value}:${count.value}` };
      if (from.foreign || known.length > 1) request.over = backend.input.value || undefined;
      return JSON.stringify(request);
    },
  };
}

/** Connects two ends that fit, or tells why they do not. */
export function connect(from, to, connections) {
  const why = mismatch(from, to);
  if (why) return note(why, "error");
  const now = connections.find((one) => one.in === to.address);
  if (now?.out === from.address) return change(now, from, to);
  const { nodes, json } = fields(from, to);
  const replaced = now && el("p", { class: "warn" }, `It takes the place of `, name(now.out), ".");
  return ask("Connect", [way(from.address, to.address), replaced, nodes], "Connect", async () => {
    await post("/connections", json());
    note(`${to.address} ${to.remote ? "calls" : "reads"} ${from.address}`);
  });
}

/** Another policy or middleware for a connection. */
export function change(one, from, to) {
  const { nodes, json } = fields(from, to, one);
  return ask("Change", [way(one.out, one.in), nodes], "Change", async () => {
    await post("/connections", json());
    note(`${one.in} reads ${one.out} anew`);
  });
}

export function disconnect(one) {
  const how = [one.backend ?? "same daemon", one.policy].filter(Boolean).join(", ");
  return ask("Disconnect", [way(one.out, one.in), el("p", { class: "soft" }, how)], "Disconnect", async () => {
    await cut(one);
    note(`${one.in} is disconnected`);
  }, { danger: true });
}

async function cut(one) {
  const { component, port, element } = parts(one.in);
  await remove(path("connections", component, port, ...(element ? [element] : [])));
}

/** Has `to` take the place of the reader of a connection, with the same policy and middleware. */
export function move(one, from, to, connections) {
  const why = mismatch(from, to);
  if (why) return note(why, "error");
  if (to.address === one.in) return undefined;
  const now = connections.find((other) => other.in === to.address);
  const replaced = now && el("p", { class: "warn" }, "It takes the place of ", name(now.out), ".");
  return ask("Move", [way(one.out, to.address), el("p", { class: "soft" }, "instead of ", name(one.in)), replaced], "Move", async () => {
    const request = { in: to.address, out: one.out };
    if (one.kind === "port") Object.assign(request, { policy: one.policy, backend: one.backend });
    // In this order nothing is lost where the new one is refused.
    await post("/connections", JSON.stringify(request));
    await cut(one);
    note(`${to.address} has the place of ${one.in}`);
  });
}

/** Asks which of `ends` to take, and goes on with it. */
export function pick(title, about, ends, act) {
  if (ends.length === 0) return note(`${title}: nothing here fits ${about}`);
  const end = choose("end", "End", ends.map((one, at) => [String(at), one.address]), "0");
  return ask(title, [el("p", { class: "way" }, name(about)), end.node], "Go on", async () => {
    const taken = ends[Number(end.input.value)];
    setTimeout(() => act(taken));
  });
}

/** The services of a component that are its own, as ends of connections. */
export async function servicesOf(component) {
  const { services } = await get(path("components", component));
  const own = services.filter((one) => !one.standard);
  return own.map((one) => ({ address: `${component}/${one.name}`, way: "out", service: true }));
}

/** Moves a component, or one of its ports, to another middleware. */
export function moveTo(component, port, now, all) {
  const had = middlewares(now);
  const boxes = all.map((one) => ({ one, box: el("input", { type: "checkbox", id: `on-${one}`, checked: had.includes(one) }) }));
  const target = port ? `${component}/${port}` : component;
  return ask("Move to another middleware", [el("p", { class: "way" }, name(target)),
    el("p", { class: "soft" }, "Its connections follow, and its codels go on."),
    el("fieldset", {}, el("legend", {}, "Middlewares"), boxes.map(({ one, box }) => el("div", { class: "row" }, box, el("label", { for: box.id }, one))))],
  "Move", async () => {
    const names = boxes.filter(({ box }) => box.checked).map(({ one }) => one);
    await replace(path("components", component, "backend"), JSON.stringify({ backend: names, port }));
    note(`${target} is on ${names.join(" and ")}`);
  });
}
