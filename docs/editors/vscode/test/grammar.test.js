"use strict";
// The grammar, in the engine that editors have.

const assert = require("node:assert/strict");
const fs = require("fs");
const path = require("path");
const { test } = require("node:test");
const { tokenizer } = require("./scopes");

/** Lines of a description, with pieces of them and the scope that each has (null: none). */
const EXPECTED = [
  ['#include "types.gen"', ["#", "meta.preprocessor", "include", "keyword.control.directive", "types.gen", "string.quoted.double"]],
  ["#include <types.gen>", ["<types.gen>", "string.quoted.other"]],
  ['#pragma require "idl >= 2.0"', ["require", "keyword.other.pragma", "idl >= 2.0", "string.quoted.double"]],
  ["#define RATE 100 // per second", ["define", "keyword.control.directive", "RATE", "meta.preprocessor", "100", "constant.numeric", "per second", "comment.line"]],
  ["  /* component in a comment */", ["component in a comment", "comment.block"]],
  ["struct point { unsigned long x; string<64> name; };", ["struct", "storage.type", "point", "entity.name.type", "unsigned", "support.type", "long", "support.type", " x;", null, "string", "support.type", "64", "constant.numeric"]],
  ["typedef sequence<point, 8> points;", ["typedef", "storage.type", "sequence", "support.type", "points;", null]],
  ["const boolean fast = TRUE xor FALSE;", ["const", "storage.type", "boolean", "support.type", "TRUE", "constant.language", "xor", "keyword.operator.word", "FALSE", "constant.language"]],
  ["component arm {", ["component", "storage.type", "arm", "entity.name.type"]],
  ['  version "1.0"; clock-rate 1 ms; codels-require "a \\"b\\"";', ["version", "keyword.other.property", "1.0", "string.quoted.double", "clock-rate", "keyword.other.property", "ms", "keyword.other.unit", "codels-require", "keyword.other.property", '\\"', "constant.character.escape"]],
  ["  ids { point goal; };", ["ids", "storage.modifier", "goal", null]],
  ['  port out point tip { doc "task in a text"; };', ["port", "storage.modifier", "out", "storage.modifier", "doc", "keyword.other.property", "task in a text", "string.quoted.double"]],
  ["  task main { period 10 ms; scheduling real-time; };", ["task", "storage.type", "main", "entity.name.type", "period", "keyword.other.property", "10", "constant.numeric", "ms", "keyword.other.unit", "real-time", "keyword.other.property"]],
  ["  activity go(in point goal) {", ["activity", "storage.type", "go", "entity.name.type", "in", "storage.modifier"]],
  ["    async codel<start, again> f(local in goal) yield pause::again, ether wcet 1 ms;", ["async", "storage.modifier", "codel", "keyword.control.codel", "start", "entity.name.label", "again", "entity.name.label", "f(", null, "local", "storage.modifier", "yield", "keyword.control", "pause", "keyword.control.pause", "again", "entity.name.label", "wcet", "keyword.other.property"]],
  ["    throw out_of_reach; interrupts go;", ["throw", "keyword.other.property", "out_of_reach", null, "interrupts", "keyword.other.property"]],
];

test("words, types, strings, comments and directives have their scopes", async () => {
  const tokenize = await tokenizer();
  for (const [line, pieces] of EXPECTED) {
    const [tokens] = tokenize(line);
    let from = 0;
    for (let at = 0; at < pieces.length; at += 2) {
      const [piece, scope] = pieces.slice(at, at + 2);
      const start = line.indexOf(piece, from);
      const found = start < 0 ? line.indexOf(piece) : start;
      assert.ok(found >= 0, `${piece} in ${line}`);
      from = found;
      const { scopes } = tokens.find((token) => token.from <= found && found < token.to);
      if (scope === null) assert.equal(scopes, "source.gen", `${piece} in ${line}`);
      else assert.ok(scopes.includes(scope), `${piece} in ${line}: ${scopes}, not ${scope}`);
    }
  }
});

test("a comment and a text over several lines end where they end", async () => {
  const tokenize = await tokenizer();
  const lines = tokenize('/* a\n task b */ task c;\n#define x \\\n  struct\nstruct y {};');
  const scopes = (line) => lines[line].map((token) => token.scopes).join(";");
  assert.match(scopes(1), /^source\.gen comment\.block.*storage\.type/);
  assert.match(scopes(3), /^source\.gen meta\.preprocessor/);
  assert.match(scopes(4), /^source\.gen storage\.type/);
});

/** Offsets of comments and texts, as the preprocessor of genomctl finds them. */
function quoted(text) {
  return [...text.matchAll(/\/\*[^]*?\*\/|\/\/.*|"(?:\\.|[^"\\\n])*"/g)];
}

/** Descriptions of the repository, given as directories in GENOM_DESCRIPTIONS. */
function descriptions() {
  const all = [];
  for (const root of (process.env.GENOM_DESCRIPTIONS ?? "").split(":").filter(Boolean)) {
    for (const name of fs.readdirSync(root, { recursive: true })) {
      if (name.endsWith(".gen")) all.push(path.join(root, name));
    }
  }
  return all;
}

test("comments, texts, directives and reserved words of real descriptions have their scopes", async () => {
  const tokenize = await tokenizer();
  const files = descriptions();
  assert.ok(files.length > 20, `${files.length} descriptions; set GENOM_DESCRIPTIONS`);
  const reserved =
    /\b(module|unsigned|short|long|float|double|char|string|boolean|octet|const|enum|union|struct|sequence|optional|typedef|TRUE|FALSE|switch|case|default)\b/g;
  let seen = 0;
  for (const file of files) {
    const text = fs.readFileSync(file, "utf8");
    const lines = tokenize(text);
    const starts = [0];
    for (const line of text.split("\n")) starts.push(starts.at(-1) + line.length + 1);
    const scopes = (offset) => {
      const line = starts.findIndex((start, at) => offset < starts[at + 1]);
      const column = offset - starts[line];
      return lines[line].find((it) => it.from <= column && column < it.to)?.scopes ?? "";
    };
    const where = (offset) => `${file}:${text.slice(0, offset).split("\n").length}`;
    let plain = text;
    for (const { 0: piece, index } of quoted(text)) {
      const wanted = piece[0] === '"' ? /string\.quoted/ : /comment\./;
      for (const offset of [index, index + (piece.length >> 1), index + piece.length - 1]) {
        if (text[offset] === "\n") continue;
        assert.match(scopes(offset), wanted, where(offset));
        assert.doesNotMatch(scopes(offset), /keyword|storage|support/, where(offset));
      }
      plain = plain.slice(0, index) + piece.replace(/[^\n]/g, " ") + plain.slice(index + piece.length);
    }
    for (const { index } of plain.matchAll(/^[ \t]*#[ \t]*(include|define|if|endif|pragma)/gm)) {
      const hash = text.indexOf("#", index);
      assert.match(scopes(hash), /meta\.preprocessor/, where(hash));
      plain = plain.slice(0, index) + plain.slice(index).replace(/.*(\\\n.*)*/, (it) => it.replace(/[^\n]/g, " "));
    }
    for (const { 0: word, index } of plain.matchAll(reserved)) {
      seen += 1;
      assert.match(scopes(index), /keyword|storage|support|constant/, `${where(index)}: ${word}`);
    }
  }
  assert.ok(seen > 200, `${seen} reserved words`);
});
