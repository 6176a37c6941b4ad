// Forms made of JSON Schemas. What they hold is written as JSON text and not as numbers of
// JavaScript, which would change integers of 64 bits.

import { el, name } from "./dom.js";

let last = 0;

/** A value that a field does not accept. */
export class Mistake extends Error {
  constructor(field, message) {
    super(message);
    this.field = field;
  }
}

const TOKENS = { inf: '"inf"', "+inf": '"inf"', "-inf": '"-inf"', nan: "null" };

function resolve(schema, root) {
  let found = schema;
  for (let depth = 0; found?.$ref && depth < 32; depth += 1) {
    const { $ref, ...beside } = found;
    const named = root.$defs?.[$ref.replace("#/$defs/", "")] ?? {};
    // Docs of members stand beside the reference to their type.
    const properties = beside.properties && named.properties
      ? { properties: Object.fromEntries(Object.entries(named.properties).map(([key, one]) =>
        [key, { ...one, ...(beside.properties[key] ?? {}) }])) } : {};
    found = { ...named, ...beside, ...properties };
  }
  return found ?? {};
}

const isNumber = (schema) => schema.anyOf?.some((one) => one.type === "number");
const isOptional = (schema) => schema.anyOf?.length === 2 && schema.anyOf[1].type === "null";

/** The range of an integer, as far as a reader wants to know it. */
function range({ minimum, maximum }) {
  if (minimum === undefined || maximum === undefined) return "";
  return maximum > 4294967295 ? (minimum === 0 ? "0 or more" : "") : `${minimum} to ${maximum}`;
}

function labelled(key, schema, input, hint) {
  last += 1;
  input.id = `field-${last}`;
  const doc = schema.description;
  const about = [doc, hint].filter(Boolean).join(" · ");
  const help = about && el("span", { class: "help", id: `${input.id}-help` }, about);
  if (help) input.setAttribute("aria-describedby", help.id);
  return el("div", { class: "field" }, el("label", { for: input.id }, name(key)), input, help);
}

function typed(key, schema, hint, start, read, attributes = {}) {
  const shown = start === undefined ? "" : String(start);
  const input = el("input", { type: "text", autocomplete: "off", spellcheck: "false", value: shown, ...attributes });
  return {
    node: labelled(key, schema, input, hint),
    json() {
      input.removeAttribute("aria-invalid");
      try {
        return read(input.value);
      } catch (error) {
        input.setAttribute("aria-invalid", "true");
        throw new Mistake(input, `${key}: ${error.message}`);
      }
    },
  };
}

function number(text) {
  const word = text.trim().toLowerCase();
  if (word === "") return undefined;
  if (TOKENS[word]) return TOKENS[word];
  if (!/^[+-]?(\d+\.?\d*|\.\d+)(e[+-]?\d+)?$/.test(word)) throw new Error(`“${text}” is no number`);
  return String(Number(word));
}

function integer(text, { minimum, maximum }) {
  const word = text.trim().replace(/^\+/, "");
  if (word === "") return undefined;
  if (!/^-?\d+$/.test(word)) throw new Error(`“${text}” is no integer`);
  const value = BigInt(word);
  if (minimum !== undefined && (value < BigInt(minimum) || value > BigInt(maximum))) {
    throw new Error(`${word} is not between ${minimum} and ${maximum}`);
  }
  return value.toString();
}

function any(text) {
  if (text.trim() === "") return undefined;
  try {
    JSON.parse(text);
  } catch {
    throw new Error("this is no JSON");
  }
  return text;
}

function whole(key, schema, start) {
  const value = start === undefined ? "" : JSON.stringify(start);
  const input = el("textarea", { rows: 2, spellcheck: "false", value });
  return {
    node: labelled(key, schema, input, "JSON"),
    json() {
      try {
        return any(input.value);
      } catch (error) {
        throw new Mistake(input, `${key}: ${error.message}`);
      }
    },
  };
}

function choice(key, schema, start) {
  const option = (value) => el("option", { value, selected: value === start }, value);
  const input = el("select", {}, start === undefined && el("option", { value: "" }, "–"), schema.enum.map(option));
  return { node: labelled(key, schema, input), json: () => input.value === "" ? undefined : JSON.stringify(input.value) };
}

function box(key, schema, start) {
  const input = el("input", { type: "checkbox", checked: start === true });
  return { node: labelled(key, schema, input), json: () => String(input.checked) };
}

function maybe(key, schema, root, start) {
  const inner = field(key, schema.anyOf[0], root, start ?? undefined);
  const given = el("input", { type: "checkbox", checked: start !== undefined && start !== null });
  const shown = el("div", {}, inner.node);
  const follow = () => { shown.hidden = !given.checked; };
  given.addEventListener("change", follow);
  follow();
  return {
    node: el("div", {}, labelled(`${key} is given`, {}, given), shown),
    json: () => given.checked ? inner.json() : "null",
  };
}

function members(key, schema, root, start) {
  const fields = Object.entries(schema.properties).map(([member, one]) =>
    [member, field(member, one, root, start?.[member])]);
  const doc = schema.description;
  return {
    node: el("fieldset", {}, el("legend", {}, name(key)), doc && el("p", { class: "help" }, doc),
      fields.map(([, one]) => one.node)),
    json: () => written(fields),
  };
}

function written(fields) {
  const all = fields.map(([member, one]) => [member, one.json()]).filter(([, text]) => text !== undefined);
  return all.length === 0 && fields.length > 0 ? undefined
    : `{${all.map(([member, text]) => `${JSON.stringify(member)}:${text}`).join(",")}}`;
}

function field(key, schema, root, start) {
  const shape = resolve(schema, root);
  if (shape.type === "boolean") return box(key, shape, start);
  if (shape.enum) return choice(key, shape, start);
  if (shape.type === "integer") {
    return typed(key, shape, range(shape), start, (text) => integer(text, shape), { inputmode: "numeric" });
  }
  if (isNumber(shape)) {
    return typed(key, shape, "", start === null ? "nan" : start, number, { inputmode: "decimal" });
  }
  if (shape.type === "string") {
    const most = shape.maxLength;
    const hint = most ? `at most ${most} characters` : "";
    return typed(key, shape, hint, start, (text) => JSON.stringify(text), { maxlength: most });
  }
  if (isOptional(shape)) return maybe(key, shape, root, start);
  const plain = shape.properties && !(shape.properties.d && shape.properties.u);
  if (shape.type === "object" && plain) return members(key, shape, root, start);
  return whole(key, shape, start);
}

/**
 * A form for the inputs of a service: `{ nodes, json() }`. Each field starts with the present
 * value, or with the default; one that is left empty is left out of the request.
 */
export function inputs(service) {
  const schema = service.input_schema;
  const starts = new Map(service.parameters.map((one) => [one.name, one.current ?? one.default ?? undefined]));
  const fields = Object.entries(schema.properties ?? {}).map(([key, one]) =>
    [key, field(key, one, schema, starts.get(key))]);
  return { nodes: fields.map(([, one]) => one.node), json: () => written(fields) ?? "{}" };
}
