// Sequences of structs within a value, as tables.

import { el, heads, text } from "./dom.js";
import { count, glance } from "./units.js";

/** Tables of a value, their rows and columns; what is more is counted. */
const TABLES = 3;
const ROWS = 100;
const COLUMNS = 16;
/** How deep sequences are looked for. */
const DEEPEST = 3;

const isRow = (one) => one !== null && typeof one === "object" && !Array.isArray(one);

/** The sequences of structs in a value, by their place in it. */
function sequences(value, at = "", depth = 0, found = []) {
  if (found.length >= TABLES || depth > DEEPEST) return found;
  if (Array.isArray(value)) {
    if (value.length > 0 && value.every(isRow)) found.push([at || "value", value]);
  } else if (isRow(value)) {
    for (const [key, one] of Object.entries(value)) sequences(one, at ? `${at}.${key}` : key, depth + 1, found);
  }
  return found;
}

/** The members of a row; those of a struct within it by their places. */
function members(row, at = "", found = new Map()) {
  for (const [key, one] of Object.entries(row)) {
    const place = at ? `${at}.${key}` : key;
    if (isRow(one) && !at) members(one, place, found);
    else found.set(place, one);
  }
  return found;
}

function cell(value) {
  const number = typeof value === "number";
  const shown = value === undefined ? "" : number ? glance(value) : typeof value === "string" ? value : JSON.stringify(value);
  return el("td", { class: number ? "number" : undefined }, text(shown, 120));
}

/** A table for each sequence of structs in a value; none if it has none. */
export function tables(value) {
  return sequences(value).map(([place, all]) => {
    const rows = all.slice(0, ROWS).map((row) => members(row));
    const columns = [...new Set(rows.flatMap((row) => [...row.keys()]))].slice(0, COLUMNS);
    const numbers = columns.map((column) => rows.every((row) => ["number", "undefined"].includes(typeof row.get(column))));
    const head = ["#", ...columns.map((column, at) => `${numbers[at] ? "#" : ""}${column}`)];
    const more = all.length - rows.length;
    return el("div", { class: "wide" }, el("table", { class: "sequence", "data-sequence": place },
      el("caption", {}, el("bdi", {}, place), ` · ${count(all.length)} elements`, more > 0 && `, the first ${count(ROWS)} shown`),
      heads(head),
      el("tbody", {}, rows.map((row, at) => el("tr", {}, el("th", { scope: "row", class: "number" }, String(at)),
        columns.map((column) => cell(row.get(column))))))));
  });
}
