//! What a call of a codel in Lua costs: `cargo bench -p genom-lua --bench calls`.
//!
//! C calls the codel as genomd does. Printed is the shortest mean time of a call in several rounds, as
//! `clients/python/benches/codels.py` prints it for Python.

#![forbid(unsafe_code)]
#![allow(clippy::expect_used, clippy::print_stdout, reason = "a benchmark")]

use std::time::Instant;

use genom_lua::measured::Called;
use serde_json::{Value, json};

const CALLS: u32 = 20_000;
const ROUNDS: u32 = 7;

/// A struct of doubles `a`, `b`, and `pose` with `x` and `y`; and an array of eight.
fn types() -> Value {
    let member = |name, offset, ty| json!({"name": name, "offset": offset, "type": ty});
    json!([
        {"kind": "double", "name": "double", "size": 8, "fixed": true},
        {"kind": "struct", "name": "pose", "size": 16, "fixed": true,
         "members": [member("x", 0, 0), member("y", 8, 0)]},
        {"kind": "array", "name": "joints", "size": 64, "fixed": true, "element": 0, "length": 8},
        {"kind": "struct", "name": "ids", "size": 96, "fixed": true,
         "members": [member("a", 0, 0), member("b", 8, 0), member("pose", 16, 1),
                     member("joints", 32, 2)]},
    ])
}

/// Microseconds of a call of a codel with this body.
fn cost(body: &str, with_ids: bool) -> f64 {
    let ids = json!({"name": "ids", "place": "b.gen:2", "from": "data", "direction": "inout",
                     "type": 3, "rank": null});
    let parameters = if with_ids { json!([ids]) } else { json!([]) };
    let request = json!({
        "path": "/b.lua",
        "text": format!("function f({}) {body} return 'main' end", if with_ids { "ids" } else { "" }),
        "component": "b", "ports": [], "remotes": [], "exceptions": [], "declared": [],
        "constants": [], "types": types(),
        "codels": [{"name": "f", "place": "b.gen:1", "owner": "task main", "yields": ["main"],
                    "parameters": parameters}],
    });
    let mut called = Called::new(&request, "f", 96).expect("the script is loaded");
    let mut call = || {
        if with_ids { called.with_memory() } else { called.without_arguments() }
    };
    assert!(call(), "it returns its event");
    let round = |_| {
        let begin = Instant::now();
        (0..CALLS).for_each(|_| _ = call());
        begin.elapsed().as_secs_f64() / f64::from(CALLS)
    };
    (0..ROUNDS).map(round).fold(f64::INFINITY, f64::min) * 1e6
}

fn main() {
    println!("Lua 5.4, microseconds a call");
    for (what, body, with_ids) in [
        ("empty, no arguments", "", false),
        ("the IDS, not used", "", true),
        (
            "three doubles read and written",
            "ids.a = ids.a + 1 ids.b = ids.b + 1 ids.pose.x = ids.pose.x + 1",
            true,
        ),
        ("an element of an array read and written", "ids.joints[1] = ids.joints[1] + 1", true),
    ] {
        println!("{:6.2}  {what}", cost(body, with_ids));
    }
}
