//! Codels in Lua call services of components in C, and are told their exceptions.

use std::fs;

use genom_tests::{Daemon, component, path};

const DESCRIPTION: &str = r#"interface axis {
  exception OUT_OF_RANGE { double value, lower, upper; string<64> what; };
  exception HALTED;
  activity goto(in double goal) { throw OUT_OF_RANGE, HALTED; };
};
component guide {
  lang "lua";
  uses axis;
  ids { long sent; };
  task main {};
  activity send(in double goal, out string<64> what) {
    task main;
    async codel<start> guide_send(in goal, remote in goto, out what) yield ether;
    throw axis::HALTED, genom::no_such_service, genom::remote_io;
  };
};
"#;

const SCRIPT: &str = r#"
local genom = require "genom"

-- In a coroutine of its own, which passes the wait for the service on.
local function there(goto_, goal)
    return coroutine.wrap(function() goto_ { goal = goal } end)()
end

function guide_send(goal, goto_, what)
    if goal == 7 then goto_ { gaol = 7 } end
    local well, refused = pcall(there, goto_, goal)
    if not well then
        if goal < 10 then error(refused) end
        -- An exception of the demo, which the description does not know.
        what.value = genom.event(refused) .. " " .. refused.what
    end
    return "ether"
end
"#;

#[test]
fn a_service_of_a_component_in_c_is_called() {
    let scratch = tempfile::tempdir().unwrap();
    let file = scratch.path().join("guide.gen");
    fs::write(&file, DESCRIPTION).unwrap();
    fs::write(scratch.path().join("guide.lua"), SCRIPT).unwrap();
    let demo = component("demo");
    let daemon = Daemon::start(&["--backend", "shm", path(&demo.library), path(&file)]);
    let send = |goal: &str| daemon.ctl(&["call", "guide", "send", goal]);
    send("goal=0.1").expect_code(1).expect_err("::genom::no_such_service");
    daemon.ctl(&["connect", "guide/goto", "demo/goto"]).expect_code(0);
    send("goal=0.05").expect_code(0).expect_out("what = \"\"\n");
    assert_eq!(daemon.port("demo", "position")["value"]["position"], 0.05);
    send("goal=7").expect_code(1).expect_err(
        "unkex {\"what\":\"goto has no input `gaol`; did you mean `goal`? (guide.lua:10)\"}",
    );
    send("goal=11").expect_code(0).expect_out("what = \"::genom::unkex ::demo::OUT_OF_RANGE\"\n");
}
