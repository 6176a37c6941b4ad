//! Verbs that work on descriptions; no daemon runs.

use std::fs;
use std::process::Command;

use genom_tests::{Finished, Running, path, program, repository};

fn genomctl(arguments: &[&str]) -> Finished {
    let mut command = Command::new(program("genomctl"));
    command.env_clear().args(arguments);
    Running::start(&mut command).finish()
}

fn demo() -> String {
    path(&repository().join("components/demo/demo.gen")).to_owned()
}

#[test]
fn check_says_what_it_read_and_what_is_wrong() {
    let checked = genomctl(&["check", &demo()]);
    checked.expect_code(0);
    assert!(checked.out.starts_with("component demo: 5 services, 3 ports, 1 tasks, digest "));
    let scratch = tempfile::tempdir().unwrap();
    let wrong = scratch.path().join("wrong.gen");
    fs::write(&wrong, "component c { port in nothing p; };\n").unwrap();
    let refused = genomctl(&["check", "--short", path(&wrong)]);
    refused.expect_code(1).expect_out("").expect_err("wrong.gen:1:23: error:");
    refused.expect_err("error: 1 error in the description");
    let refused = genomctl(&["--json", "check", path(&wrong)]);
    let told: serde_json::Value = serde_json::from_str(&refused.out).unwrap();
    assert_eq!(told["errors"], 1);
    genomctl(&["check", "nothing.gen"]).expect_code(2).expect_err("no such file");
}

#[test]
fn explain_knows_every_code_that_check_shows() {
    let all = genomctl(&["explain"]);
    all.expect_code(0);
    for line in all.out.lines() {
        let code = line.split(' ').next().unwrap();
        assert!(genomctl(&["explain", code]).out.starts_with(code));
        if code > "E0103" {
            break;
        }
    }
    genomctl(&["explain", "E9999"]).expect_code(2).expect_err("there is no code `E9999`");
}

#[test]
fn describe_digest_graph_and_header_are_made_of_the_description() {
    let demo = demo();
    for (arguments, wanted) in [
        (&["describe"][..], "goto(in goal: double = 1.0)"),
        (&["--json", "describe"], "\"name\":\"demo\""),
        (&["digest"], "demo/goto"),
        (&["graph"], "digraph"),
        (&["graph", "--format", "mermaid"], "flowchart LR"),
        (&["header"], "genom_event demo_brake(demo_state *current"),
        (&["header", "--lang", "rust"], "extern \"C\""),
    ] {
        let made = genomctl(&[arguments, &[&demo]].concat());
        made.expect_code(0);
        assert!(made.out.contains(wanted), "{arguments:?}: no `{wanted}` in\n{}", made.out);
    }
    let refused = genomctl(&["header", &demo, "--component", "dmo"]);
    refused.expect_code(1).expect_err("there is no component `dmo`");
}

#[test]
fn fmt_changes_blanks_once() {
    let scratch = tempfile::tempdir().unwrap();
    let file = scratch.path().join("x.gen");
    fs::write(&file, "component   x {\n      doc \"d\" ;\n};\n").unwrap();
    let file = path(&file);
    genomctl(&["fmt", "--check", file]).expect_code(1).expect_err("error: 1 file to format");
    let shown = genomctl(&["fmt", "--stdout", file]);
    genomctl(&["fmt", file]).expect_code(0).expect_out("");
    assert_eq!(fs::read_to_string(file).unwrap(), shown.out);
    genomctl(&["fmt", "--check", file]).expect_code(0);
}
