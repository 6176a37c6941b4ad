// Elements of pages. What comes from the daemon is shown as text: nothing here, or anywhere in the
// console, makes markup of a value.

const SVG = "http://www.w3.org/2000/svg";

// Characters that would not be seen, or would change how their neighbours are read (controls,
// directions of text, byte order marks).
const UNSEEN =
  /[\u0000-\u0008\u000b-\u001f\u007f-\u009f\u061c\u200b-\u200f\u2028-\u202e\u2060-\u2069\ufeff]/g;

// Longest text that is shown whole.
const LONGEST = 2000;

/** A text with its unseen characters spelled out, and cut where it is very long. */
export function visible(value, longest = LONGEST) {
  const text = String(value);
  const shown = text.length > longest ? text.slice(0, longest) : text;
  const spelled = shown.replace(UNSEEN, (sign) =>
    `⟨U+${sign.codePointAt(0).toString(16).toUpperCase().padStart(4, "0")}⟩`);
  if (text.length <= longest) return spelled;
  return `${spelled}… (${text.length.toLocaleString("en")} characters)`;
}

/** A text of its own length: what is appended as a string is cut sooner. */
export function text(value, longest) {
  return document.createTextNode(visible(value, longest));
}

function fill(made, attributes, children) {
  for (const [name, value] of Object.entries(attributes ?? {})) {
    if (value === undefined || value === null || value === false) continue;
    if (name.startsWith("on")) made.addEventListener(name.slice(2), value);
    else if (name === "value" || name === "checked") made[name] = value;
    else made.setAttribute(name, value === true ? "" : String(value));
  }
  append(made, children);
  return made;
}

/** Appends nodes; anything else becomes text. */
export function append(to, children) {
  for (const child of children.flat(Infinity)) {
    if (child === undefined || child === null || child === false) continue;
    to.append(child instanceof Node ? child : visible(child));
  }
}

/** An element. `onclick: …` adds a listener, `undefined` leaves an attribute out. */
export function el(name, attributes, ...children) {
  return fill(document.createElement(name), attributes, children);
}

/** An element of a drawing. */
export function svg(name, attributes, ...children) {
  return fill(document.createElementNS(SVG, name), attributes, children);
}

/** A name from the daemon: isolated, so that its direction does not spread. */
export function name(text) {
  return el("bdi", { class: "name" }, text);
}

/** The head of a table; `#` begins the names of columns of numbers. */
export function heads(names) {
  const one = (text) => text.startsWith("#")
    ? el("th", { scope: "col", class: "number" }, text.slice(1)) : el("th", { scope: "col" }, text);
  return el("thead", {}, el("tr", {}, names.map(one)));
}

/** A link within the console. */
export function link(to, ...children) {
  return el("a", { href: to, "data-within": true }, ...children);
}

/** Address of the page of a component. */
export function pageOf(component) {
  return `/component/${encodeURIComponent(component)}`;
}

/** Address of the page that says why a port is silent. */
export function whyOf(port) {
  return `/doctor?${new URLSearchParams({ port })}`;
}

/** Replaces the children of a node. */
export function put(into, ...children) {
  into.replaceChildren();
  append(into, children);
  return into;
}

/** Shows a short message to the user; screen readers speak it. */
export function note(message, kind = "info") {
  const notes = document.getElementById("notes");
  const close = () => shown.remove();
  const shown = el("div", { class: `note ${kind}` }, el("span", {}, message),
    el("button", { type: "button", class: "plain", "aria-label": "Dismiss", onclick: close }, "×"));
  notes.append(shown);
  while (notes.children.length > 4) notes.firstChild.remove();
  if (kind !== "error") setTimeout(close, 6000);
}
