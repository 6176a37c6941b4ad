//! Files that are damaged, foreign, of a later version or too large.

use genom_tests::{Daemon, component, path, until};
use serde_json::{Value, json};

use super::{changed, empty, file, freeze, robot};

#[track_caller]
fn refuses(daemon: &Daemon, text: impl AsRef<[u8]>, code: i32, why: &str) {
    let file = file(daemon);
    std::fs::write(&file, text).unwrap();
    let told = daemon.ctl(&["thaw", path(&file)]);
    told.expect_code(code).expect_err(why);
    let left = daemon.json(&["list"]);
    assert_eq!(left["components"], json!([]), "nothing is left");
    assert_eq!(daemon.json(&["cells"])["cells"], json!([]), "no cell either");
}

#[test]
fn a_file_that_is_damaged_or_foreign_or_newer_is_refused_with_the_place() {
    let first = robot();
    first.ctl(&["start", "demo", "goto", "goal=0.1"]).expect_code(0);
    first.ctl(&["step", "20ms"]).expect_code(0);
    let (text, _) = freeze(&first);
    let daemon = empty();
    let usage = 2;
    refuses(&daemon, "", usage, "robot.json: this is no file of `genomctl freeze`: EOF");
    refuses(&daemon, [0xff_u8, 0xfe], usage, "robot.json: stream did not contain valid UTF-8");
    refuses(
        &daemon,
        "[[component]]\nlibrary = \"demo.so\"\n",
        usage,
        "no file of `genomctl freeze`",
    );
    refuses(&daemon, &text[..text.len() - 40], usage, "EOF while parsing");
    let newer = text.replacen("\"version\": 1", "\"version\": 2", 1);
    refuses(&daemon, newer, usage, "in version 2 of the format, and this one reads up to 1");
    let other = text.replacen("\"waits\": \"pause\"", "\"waits\": \"snooze\"", 1);
    refuses(&daemon, other, usage, "unknown variant `snooze`, expected one of `ready`, `pause`");
    let deep = format!("{{\"format\": {}", "[".repeat(100_000));
    refuses(&daemon, deep, usage, "no file of `genomctl freeze`");
    let edit = |change: fn(&mut Value)| changed(&text, change);
    refuses(
        &daemon,
        edit(|all| all["components"]["demo"]["ids"]["value"]["current"]["position"] = json!("x")),
        1,
        "components.demo.ids.value: current.position: \"x\" is not a number, although the \
         description is the same",
    );
    refuses(
        &daemon,
        edit(|all| {
            let far = &mut all["components"]["far"];
            far["ids"]["value"].as_object_mut().unwrap().remove("velocity");
        }),
        1,
        "components.far.ids.value: velocity is missing",
    );
    refuses(
        &daemon,
        edit(|all| {
            all["components"]["demo"]["activities"][0]["inputs"]["value"] = json!({"goal": [1]})
        }),
        1,
        "components.demo.activities[0].inputs.value: goal: a list of 1 is not a number",
    );
    refuses(
        &daemon,
        edit(|all| all["components"]["demo"]["component"] = json!("mission")),
        1,
        "components.demo.component: this is the state of a mission, and not of a demo",
    );
    refuses(
        &daemon,
        edit(|all| all["components"]["ghost"] = all["components"]["demo"].clone()),
        1,
        "components.ghost: the deployment of the file has no such component",
    );
}

#[test]
fn a_huge_file_is_not_even_read() {
    let daemon = empty();
    let file = file(&daemon);
    let huge = std::fs::File::create(&file).unwrap();
    huge.set_len(40 << 30).unwrap();
    let told = daemon.ctl(&["thaw", path(&file)]);
    told.expect_code(2).expect_err("42949672960 bytes are more than the 33554432 that are read");
}

#[test]
fn a_component_whose_codels_never_rest_is_not_frozen_and_the_codel_is_named() {
    let daemon = Daemon::start(&[path(&component("blocks").library)]);
    let _start = daemon.spawn(&["call", "blocks", "hang"]);
    until("it is in its codel", || {
        daemon.json(&["activities", "blocks"])["activities"][0]["state"] == "start"
    });
    let told = daemon.ctl(&["freeze", path(&file(&daemon))]);
    told.expect_code(1).expect_err("blocks cannot be frozen: ").expect_err("blocks_hang");
    assert!(!file(&daemon).exists(), "no file is left");
}
