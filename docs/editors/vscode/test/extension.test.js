"use strict";
// The extension in an editor of which only the interface is there:
// its server is started as it says, its tasks are run, and its matcher reads what they print.
// GENOMCTL is the program.

const assert = require("node:assert/strict");
const { spawn, spawnSync } = require("child_process");
const fs = require("fs");
const Module = require("module");
const os = require("os");
const path = require("path");
const { after, test } = require("node:test");
const rpc = require("vscode-languageserver-protocol/node");

const GENOMCTL = process.env.GENOMCTL ?? "genomctl";
const manifest = require("../package.json");
const BAD = 'component arm {\n  version "1"; lang "c"; email "a@b.org"; require "genom3 >= 2.99";\n  ids { lonk a; };\n};\n';

/** A folder that is open, with these files. */
function folder(files) {
  const root = fs.mkdtempSync(path.join(os.tmpdir(), "genom-"));
  for (const [name, text] of Object.entries(files)) {
    fs.mkdirSync(path.dirname(path.join(root, name)), { recursive: true });
    fs.writeFileSync(path.join(root, name), text);
  }
  after(() => fs.rmSync(root, { recursive: true, force: true }));
  return { uri: { fsPath: root }, name: "folder", index: 0 };
}

/** What of the interface `vscode` the extension uses, and what it did with it. */
function editor(folder, values) {
  const did = { clients: [], errors: [], providers: {}, commands: {} };
  const list = (pattern) => {
    const all = fs.readdirSync(folder.uri.fsPath, { recursive: true });
    return all.filter((name) => matches(name, pattern));
  };
  const vscode = {
    workspace: {
      workspaceFolders: [folder],
      getConfiguration: () => ({ get: (key, none) => values[key] ?? none }),
      findFiles: async ({ pattern }) =>
        list(pattern).map((name) => ({ fsPath: path.join(folder.uri.fsPath, name) })),
      onDidChangeConfiguration: () => ({ dispose() {} }),
    },
    window: { showErrorMessage: (text) => did.errors.push(text) },
    tasks: { registerTaskProvider: (type, provider) => void (did.providers[type] = provider) },
    commands: { registerCommand: (name, run) => void (did.commands[name] = run) },
    RelativePattern: class { constructor(base, pattern) { Object.assign(this, { base, pattern }); } },
    ProcessExecution: class { constructor(process, args, options) { Object.assign(this, { process, args, options }); } },
    Task: class {
      constructor(definition, scope, name, source, execution, problemMatchers) {
        Object.assign(this, { definition, scope, name, source, execution, problemMatchers });
      }
    },
    TaskGroup: { Build: "build", Test: "test" },
  };
  class LanguageClient {
    constructor(id, name, server, options) {
      Object.assign(this, { id, name, server, options });
      did.clients.push(this);
    }
    async start() { if (values.command === "none") throw new Error("spawn none ENOENT"); }
    async stop() { this.stopped = true; }
  }
  const load = Module._load;
  Module._load = (name, ...rest) => {
    if (name === "vscode") return vscode;
    if (name === "vscode-languageclient/node") return { LanguageClient };
    return load(name, ...rest);
  };
  delete require.cache[require.resolve("../extension.js")];
  did.extension = require("../extension.js");
  Module._load = load;
  return did;
}

/** Whether a path fits a pattern of VS Code, of those with `**`, `*` and `{a,b}`. */
function matches(name, pattern) {
  const regexp = pattern
    .replace(/[.]/g, "\\.")
    .replace(/\*\*\//g, "(?:.*/)?")
    .replace(/\*(?![/)])/g, "[^/]*")
    .replace(/\{([^}]*)\}/g, (_, all) => `(?:${all.replace(/,/g, "|")})`);
  return new RegExp(`^${regexp}$`).test(name);
}

test("the server starts as the extension says, and tells mistakes with the settings", async () => {
  const open = folder({ "idl/types.idl": "struct point { double x; };\n" });
  const values = { command: GENOMCTL, include: ["idl"], defines: ["KIND=point"] };
  const { clients, extension } = editor(open, values);
  await extension.activate({ subscriptions: [] });
  const { server, options } = clients[0];
  assert.deepEqual(options.documentSelector, [{ language: manifest.contributes.languages[0].id }]);
  const child = spawn(server.command, server.args, server.options);
  const connection = rpc.createProtocolConnection(
    new rpc.StreamMessageReader(child.stdout),
    new rpc.StreamMessageWriter(child.stdin),
  );
  const published = new Promise((resolve) =>
    connection.onNotification("textDocument/publishDiagnostics", resolve),
  );
  connection.listen();
  const root = `file://${open.uri.fsPath}`;
  const hello = await connection.sendRequest("initialize", {
    processId: process.pid,
    rootUri: root,
    workspaceFolders: [{ uri: root, name: "folder" }],
    capabilities: {},
    initializationOptions: options.initializationOptions,
  });
  assert.equal(hello.capabilities.hoverProvider, true);
  connection.sendNotification("initialized", {});
  const text = '#include "types.idl"\ntypedef sequence<KIND> path;\ntypedef lonk wrong;\n';
  const textDocument = { uri: `${root}/arm.gen`, languageId: "genom", version: 1, text };
  connection.sendNotification("textDocument/didOpen", { textDocument });
  const { diagnostics } = await published;
  assert.deepEqual(diagnostics.map((it) => [it.range.start.line, it.code]), [[2, "E0206"]]);
  await connection.sendRequest("shutdown");
  const ended = new Promise((resolve) => child.on("exit", resolve));
  connection.sendNotification("exit");
  assert.equal(await ended, 0);
  await extension.deactivate();
  assert.equal(clients[0].stopped, true);
});

test("a command that is not there is told, with the setting that names it", async () => {
  const { errors, extension } = editor(folder({}), { command: "none" });
  await extension.activate({ subscriptions: [] });
  assert.match(errors.join(), /none lsp.*genom\.command/);
});

test("each description is checked by a task, and the matcher reads what it prints", async () => {
  const open = folder({ "a/arm.gen": BAD, "idl/good.gen": "struct p { double x; };\n" });
  const did = editor(open, { command: GENOMCTL, include: ["idl"] });
  await did.extension.activate({ subscriptions: [] });
  const provider = did.providers[manifest.contributes.taskDefinitions[0].type];
  const tasks = await provider.provideTasks();
  assert.deepEqual(tasks.map((task) => task.name), ["check a/arm.gen", "check idl/good.gen"]);
  const run = ({ execution }) => {
    const { process: program, args, options } = execution;
    return spawnSync(program, args, { ...options, encoding: "utf8" });
  };
  assert.equal(run(tasks[1]).status, 0);
  const bad = run(tasks[0]);
  assert.notEqual(bad.status, 0);
  const [matcher] = manifest.contributes.problemMatchers;
  assert.deepEqual(tasks[0].problemMatchers, [`$${matcher.name}`]);
  const pattern = manifest.contributes.problemPatterns.find((it) => `$${it.name}` === matcher.pattern);
  const found = `${bad.stdout}${bad.stderr}`.split("\n").flatMap((line) => {
    const match = new RegExp(pattern.regexp).exec(line);
    return match ? [["file", "line", "column", "severity", "message", "code"].map((key) => match[pattern[key]])] : [];
  });
  assert.deepEqual(found, [["a/arm.gen", "3", "9", "error", "unknown type `lonk`", "E0206"]]);
  const same = await provider.resolveTask({ definition: tasks[0].definition, scope: open });
  assert.deepEqual(same.execution, tasks[0].execution);
});

test("a component is built by the build file in or above its directory", async () => {
  const open = folder({
    "Makefile": "all:\n\t@echo built above\n",
    "arm/arm.gen": BAD,
    "arm/Makefile": "all:\n\t@echo never\n",
    "arm/meson.build": "",
    "leg/leg.gen": BAD,
    "leg/Cargo.toml": '[package]\nname = "leg"\nedition = "1815"\n',
    "other/Makefile": "all:\n",
  });
  const did = editor(open, { command: GENOMCTL });
  await did.extension.activate({ subscriptions: [] });
  const tasks = await did.providers.genom.provideTasks();
  const builds = tasks.filter((task) => task.definition.task === "build");
  assert.deepEqual(
    builds.map(({ name, execution }) => [name, execution.process, ...execution.args]).sort(),
    [["build Makefile", "make"], ["build arm", GENOMCTL, "build"], ["build leg", GENOMCTL, "build"]],
  );
  const { execution } = builds.find((task) => task.name === "build Makefile");
  const made = spawnSync(execution.process, execution.args, { ...execution.options, encoding: "utf8" });
  assert.match(made.stdout, /built above/);
  // It is run in the directory, and what it runs there is told.
  const leg = builds.find((task) => task.name === "build leg").execution;
  const refused = spawnSync(leg.process, leg.args, { ...leg.options, encoding: "utf8" });
  assert.notEqual(refused.status, 0);
  assert.match(refused.stderr, /^cargo build$/m);
  const definition = { type: "genom", task: "build", directory: "arm" };
  const resolved = await did.providers.genom.resolveTask({ definition, scope: open });
  assert.deepEqual([resolved.execution.process, ...resolved.execution.args], [GENOMCTL, "build"]);
});

/** A snippet as it stands after the user pressed Tab until its end. */
function expanded(body) {
  const chosen = {};
  let text = body.join("\n").replace(/\$\{(\d+)\|([^,|]*)[^}]*\}/g, "${$1:$2}");
  text = text.replace(/\$\{(\d+):([^}]*)\}/g, (_, at, value) => (chosen[at] = value));
  return text.replace(/\$(\d)/g, (_, at) => chosen[at] ?? "");
}

test("every snippet is a description without mistakes in its place", () => {
  const snippets = require("../snippets.json");
  const component = expanded(snippets.Component.body).trim().replace(/\};$/, "");
  const places = {
    Component: (text) => text,
    // A port wants a type with a name, and a codel that uses it.
    Port: (text) => `typedef double point;\n${component}\n${text}
      task other { period 1 ms; codel<start> use(out position) yield ether; };\n};`,
    Codel: (text) => `${component} task other { period 1 ms; ${text} };\n};`,
  };
  const open = folder({});
  for (const [name, { body, prefix }] of Object.entries(snippets)) {
    const text = (places[name] ?? ((it) => `${component}\n${it}\n};`))(expanded(body));
    assert.ok(text.includes(prefix), name);
    const file = path.join(open.uri.fsPath, `${prefix}.gen`);
    fs.writeFileSync(file, text);
    const { status, stdout, stderr } = spawnSync(GENOMCTL, ["check", "--short", "--deny-warnings", file], { encoding: "utf8" });
    assert.equal(status, 0, `${name}: ${stdout}${stderr}\n${text}`);
  }
});

test("the packaged program loads and has the entries that the editor calls", () => {
  const anything = () =>
    new Proxy(class {}, { get: (it, key) => (key in it ? it[key] : (it[key] = anything())) });
  const load = Module._load;
  Module._load = (name, ...rest) => (name === "vscode" ? anything() : load(name, ...rest));
  const packaged = require(path.join("..", manifest.main));
  Module._load = load;
  assert.deepEqual(Object.keys(packaged).sort(), ["activate", "deactivate"]);
});
