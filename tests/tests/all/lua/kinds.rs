//! Values of each kind of type, as codels in Lua have them.

use std::fs;

use genom_tests::{Daemon, path};

/// A description with a type of each kind, in scopes.
const KINDS: &str = r#"module geometry {
  struct point { double x; double y; };
  enum axis { X, Y };
};
const unsigned long JOINTS = 6;
component all {
  lang "lua";
  enum speed { SLOW, FAST };
  union choice switch (speed) { case SLOW: long steps; case FAST: geometry::point at; };
  typedef double gains[JOINTS];
  exception TOO_FAR { double limit; string<16> from; };
  exception MOVING;
  ids {
    geometry::point at; geometry::axis along; gains all; speed fast; choice chosen;
    sequence<geometry::point> path; sequence<long, 4> few; optional<double> maybe; string name;
    geometry::point corners[4]; boolean halted; octet byte; long while; char letter; float small;
    sequence<string> names; unsigned long long large;
  };
  function go(in string what, out string said) {
    codel all_go(inout ::ids, in what, out said);
    throw TOO_FAR, MOVING;
  };
  attribute look(out at, out along, out fast, out chosen, out path, out few, out maybe, out name,
                 out names, out letter, out large);
};
"#;

/// Codels that use all of them.
const SCRIPT: &str = r#"
local genom = require "genom"
local all = require "all_types"
local codels = {}

local function refused(told, change)
    local well, why = pcall(change)
    assert(not well, "not refused: " .. told)
    assert(tostring(why):find(told, 1, true), tostring(why))
end

function codels.all_go(ids, what, said)
    if what == "wrong" then
        refused("a double is needed, not `east`", function() ids.at = { x = 1, y = "east" } end)
        refused("point has no member `z`; there are: x, y", function() ids.at.z = 1 end)
        refused("axis has no `Z`", function() ids.along = "Z" end)
        refused("6 elements are needed, not 2", function() ids.all = { 1, 2 } end)
        refused("there is no element 7, only 6", function() ids.all[7] = 1 end)
        refused("has at most 4", function() ids.few = { 1, 2, 3, 4, 5 } end)
        refused("element 2: a long is needed, not 1.5", function() ids.few = { 1, 1.5 } end)
        refused("256 is no octet: 0 to 255", function() ids.byte = 256 end)
        refused("-1 is no unsigned long long", function() ids.large = -1 end)
        refused("a boolean is needed", function() ids.halted = 1 end)
        refused("no NUL inside", function() ids.name = "a\0b" end)
        refused("UTF-8", function() ids.name = "\xff" end)
        refused("one character", function() ids.letter = "ab" end)
        refused("d is 1: it has `at`", function() ids.chosen.steps = 1 end)
        refused("is not that of d = 0", function()
            ids.chosen = { d = all.SLOW, at = { x = 1 } }
        end)
        refused("element 2: a string is needed", function() ids.names = { "x", 1 } end)
        refused("has no length", function() return #ids end)
        return
    end
    if what == "moving" then error(all.MOVING) end
    if what == "far" then error(all.TOO_FAR { limit = 2, from = "here" }) end
    if what == "long" then error(all.TOO_FAR { limit = 2, from = ("x"):rep(16) }) end
    ids.at = { x = 1, y = ids.at.x + 1 }
    ids.along = all.geometry.axis.Y
    ids.all[all.JOINTS] = 2.5
    ids.fast = all.FAST
    ids.chosen = { at = ids.at }
    ids.chosen.at.y = 8
    ids.path[#ids.path + 1] = { x = 3 }
    ids.path[1].y = ids.path[#ids.path].x
    ids.path = ids.path
    ids.few = { 1, 2 }
    genom.resize(ids.few, 3)
    ids.few[4] = 9
    ids.maybe = ids.maybe == nil and 1.5 or nil
    ids.name = ids.name .. "é!"
    ids.names = { "a", ids.name }
    ids.names[3] = "c"
    ids.names = ids.names
    ids.corners[4].x = 4
    ids.corners = ids.corners
    ids["while"] = 7
    ids.letter = "z"
    ids.small = 0.5
    ids.large = 2.0 ^ 63
    local sum, count = 0, 0
    for name, value in pairs(ids.at) do sum, count = sum + value, count + 1 end
    for _, corner in ipairs(ids.corners) do sum, count = sum + corner.x, count + 1 end
    said.value = ("%g %d %s %g %s"):format(
        sum, count, ids.along, ids.all[6], genom.copy(ids.path)[1].y
    )
end

return codels
"#;

#[test]
fn values_of_all_kinds_are_read_and_written_and_checked() {
    let scratch = tempfile::tempdir().unwrap();
    fs::write(scratch.path().join("all.gen"), KINDS).unwrap();
    fs::write(scratch.path().join("all.lua"), SCRIPT).unwrap();
    let daemon = Daemon::start(&[path(&scratch.path().join("all.gen"))]);
    let go = |what: &str| daemon.ctl(&["call", "all", "go", &format!("what={what}")]);
    go("well").expect_code(0).expect_out("said = \"6 6 Y 2.5 3.0\"\n");
    go("well").expect_code(0);
    let look = daemon.json(&["call", "all", "look"]);
    let seen = &look["result"];
    let wanted = serde_json::json!({
        "at": { "x": 1.0, "y": 2.0 }, "along": "Y", "fast": "FAST",
        "chosen": { "d": "FAST", "u": { "at": { "x": 1.0, "y": 8.0 } } },
        "path": [{ "x": 3.0, "y": 3.0 }, { "x": 3.0, "y": 0.0 }],
        "few": [1, 2, 0, 9], "maybe": null, "name": "é!é!", "names": ["a", "é!é!", "c"],
        "letter": "z", "large": 9_223_372_036_854_775_808u64,
    });
    assert_eq!(seen, &wanted, "{look}");
    go("wrong").expect_code(0);
    go("moving").expect_code(1).expect_err("ended with ::all::MOVING");
    go("far").expect_code(1).expect_err("::all::TOO_FAR {\"limit\":2.0,\"from\":\"here\"}");
    let long = go("long");
    long.expect_code(1).expect_err("::genom::unkex").expect_err("is longer than 15 bytes");
}
