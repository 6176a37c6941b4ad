"use strict";
// The VS Code extension: a language client over `genomctl lsp`, and tasks.

const path = require("path");
const vscode = require("vscode");
const { LanguageClient } = require("vscode-languageclient/node");
const commands = require("./commands");

let client;

function settings(scope) {
  const all = vscode.workspace.getConfiguration("genom", scope);
  return {
    command: all.get("command", "genomctl"),
    include: all.get("include", []),
    defines: all.get("defines", []),
  };
}

async function start() {
  const folder = vscode.workspace.workspaceFolders?.[0];
  const { command, args, options } = commands.server(settings(folder?.uri));
  client = new LanguageClient(
    "genom",
    "GenoM descriptions",
    { command, args, options: { cwd: folder?.uri.fsPath } },
    { documentSelector: [{ language: "genom" }], initializationOptions: options },
  );
  try {
    await client.start();
  } catch (error) {
    vscode.window.showErrorMessage(
      `\`${command} lsp\` does not start: ${error.message}. Install genomd, or set genom.command.`,
    );
  }
}

async function stop() {
  const old = client;
  client = undefined;
  // A server that could not be started cannot be stopped either.
  await old?.stop().catch(() => {});
}

function task(folder, definition, { name, command, args }, directory) {
  const run = new vscode.ProcessExecution(command, args, { cwd: directory });
  const matchers = definition.task === "build" ? ["$gcc", "$genomctl"] : ["$genomctl"];
  const made = new vscode.Task({ type: "genom", ...definition }, folder, name, "genom", run, matchers);
  made.group = definition.task === "build" ? vscode.TaskGroup.Build : vscode.TaskGroup.Test;
  return made;
}

function checkTask(folder, definition) {
  const line = commands.check(settings(folder.uri), definition.file);
  return task(folder, definition, line, folder.uri.fsPath);
}

function buildTask(folder, definition, line) {
  return task(folder, definition, line, path.join(folder.uri.fsPath, line.directory));
}

async function found(folder, pattern) {
  const inFolder = new vscode.RelativePattern(folder, pattern);
  const uris = await vscode.workspace.findFiles(inFolder, "**/{node_modules,target,build}/**", 200);
  const relative = (uri) => path.relative(folder.uri.fsPath, uri.fsPath);
  return uris.map((uri) => relative(uri).split(path.sep).join("/")).sort();
}

/** Builds are offered for the directories of descriptions and those above them. */
function near(descriptions, files) {
  const above = (file) => path.posix.dirname(file);
  return files.filter((file) =>
    descriptions.some((it) => above(file) === "." || it.startsWith(`${above(file)}/`)),
  );
}

const tasks = {
  async provideTasks() {
    const all = [];
    for (const folder of vscode.workspace.workspaceFolders ?? []) {
      const descriptions = await found(folder, "**/*.gen");
      all.push(...descriptions.map((file) => checkTask(folder, { task: "check", file })));
      const files = await found(folder, `**/{${commands.BUILD_FILES.join(",")}}`);
      for (const line of commands.builds(settings(folder.uri), near(descriptions, files))) {
        all.push(buildTask(folder, { task: "build", directory: line.directory }, line));
      }
    }
    return all;
  },

  /** A task as it stands in `tasks.json`. */
  async resolveTask({ definition, scope }) {
    const folder = scope?.uri ? scope : vscode.workspace.workspaceFolders?.[0];
    if (!folder) return undefined;
    if (definition.task === "check" && definition.file) return checkTask(folder, definition);
    if (definition.task !== "build") return undefined;
    const directory = path.posix.normalize(definition.directory ?? ".");
    const below = directory === "." ? "" : `${directory}/`;
    const files = await found(folder, `${below}{${commands.BUILD_FILES.join(",")}}`);
    const [line] = commands.builds(settings(folder.uri), files);
    return line && buildTask(folder, definition, line);
  },
};

exports.activate = async (context) => {
  context.subscriptions.push(
    vscode.tasks.registerTaskProvider("genom", tasks),
    vscode.commands.registerCommand("genom.restart", async () => {
      await stop();
      await start();
    }),
    vscode.workspace.onDidChangeConfiguration(async (change) => {
      if (!change.affectsConfiguration("genom")) return;
      await stop();
      await start();
    }),
  );
  await start();
};

exports.deactivate = stop;
