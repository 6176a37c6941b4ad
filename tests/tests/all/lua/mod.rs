//! Components with codels in Lua.

mod errors;
mod kinds;
mod made;
mod refused;
mod reloaded;
mod remotes;
mod sandboxed;

use std::fs;
use std::path::PathBuf;

use genom_tests::{Daemon, Home, path};
use tempfile::TempDir;

/// A component with a function and an activity, each of which does what its input says.
const DESCRIPTION: &str = r#"component axis {
  lang "lua";
  exception REFUSED { long code; };
  struct pose { double x; double y; };
  ids { pose at; long n; };
  port out pose where;
  task main {
    period 10 ms;
    codel<start> axis_start(out ::ids, out where) yield ether;
  };
  function how(in string<16> what, out long tries) {
    codel axis_how(in what, inout n, out tries);
    throw REFUSED;
  };
  activity run(in string<16> what) {
    task main;
    codel<start> axis_run(in what, inout at) yield pause::start, ether;
    codel<stop> axis_stop(in what) yield ether;
    throw REFUSED;
  };
};
"#;

/// Its codels.
const SCRIPT: &str = r#"
local types = require "axis_types"
local kept

local function divided(a, b)
    return a // b
end

function axis_start(ids, where)
    ids.at.x = 1
    where:write(ids.at)
    return "ether"
end

function axis_how(what, n, tries)
    n.value = n.value + 1
    tries.value = n.value
    if what == "refuse" then error(types.REFUSED { code = 7 }) end
    if what == "divide" then n.value = divided(1, 0) end
    if what == "exit" then os.exit(3) end
    if what == "range" then n.value = 2 ^ 31 end
    if what == "print" then print(("x"):rep(3000000)) end
    if what == "member" then error(types.REFUSED { cod = 7 }) end
    if what == "caught" then
        local well, why = pcall(divided, 1, 0)
        assert(not well and why:find "by zero", why)
    end
end

function axis_run(what, at)
    if what == "type" then return #what end
    if what == "block" then while true do end end
    if what == "keep" then kept = at return "ether" end
    if what == "kept" then return kept.x end
    if what == "const" then at.x = "east" end
    if what == "yield" then coroutine.yield() end
    return "pause::start"
end

function axis_stop(what)
    if what == "stop" then error "it does not stop" end
    return "ether"
end
"#;

/// A directory with the component.
fn axis(description: &str, script: &str) -> (TempDir, PathBuf) {
    let scratch = tempfile::tempdir().unwrap();
    let file = scratch.path().join("axis.gen");
    fs::write(&file, description).unwrap();
    fs::write(scratch.path().join("axis.lua"), script).unwrap();
    (scratch, file)
}

/// A daemon with the component, and a directory that it needs.
fn started(options: &[&str]) -> (Daemon, TempDir) {
    let (scratch, file) = axis(DESCRIPTION, SCRIPT);
    let daemon = Home::new().start(&[options, &[path(&file)]].concat());
    (daemon, scratch)
}
