"use strict";
// Command lines of the language server and of the tasks. Nothing here needs an editor.

const path = require("path");

/** `-I` and `-D` of the settings. */
function flags(settings) {
  return [
    ...settings.include.flatMap((directory) => ["-I", directory]),
    ...settings.defines.flatMap((define) => ["-D", define]),
  ];
}

/** The language server; the settings are its initialization options. */
function server(settings) {
  return {
    command: settings.command,
    args: ["lsp"],
    options: { include: settings.include, defines: settings.defines },
  };
}

/** What `genomctl check` runs as for a description, in the folder that is open. */
function check(settings, file) {
  return {
    name: `check ${file}`,
    command: settings.command,
    args: ["check", "--short", ...flags(settings), file],
  };
}

/** Files that tell how a directory is built: by `genomctl build`, or by make where there is only a Makefile. */
const BUILD_FILES = ["Cargo.toml", "CMakeLists.txt", "meson.build", "configure.ac", "Makefile"];

/** How the directory of a build file (relative to the folder) is built. */
function build(settings, file) {
  const [directory, name] = [path.posix.dirname(file), path.posix.basename(file)];
  const [command, args] = name === "Makefile" ? ["make", []] : [settings.command, ["build"]];
  return { name: `build ${directory === "." ? name : directory}`, directory, command, args };
}

/** One build for each directory, by the first of its build files. */
function builds(settings, files) {
  const rank = (file) => BUILD_FILES.indexOf(path.posix.basename(file));
  const chosen = new Map();
  for (const file of [...files].sort((a, b) => rank(a) - rank(b))) {
    const directory = path.posix.dirname(file);
    if (rank(file) >= 0 && !chosen.has(directory)) chosen.set(directory, build(settings, file));
  }
  return [...chosen.values()];
}

module.exports = { server, check, builds, BUILD_FILES };
