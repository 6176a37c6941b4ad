//! Scripts in Lua that do not fit their description are refused before anything of them runs.

use genom_tests::{Home, component, path};

use super::{DESCRIPTION, SCRIPT, axis};

/// What is told of a script, by a daemon that is to run it and by one that only checks.
#[track_caller]
fn refused(description: &str, script: &str, told: &[&str]) {
    let (_scratch, file) = axis(description, script);
    for check in [&["--check"][..], &[]] {
        let refused = Home::new().refused(&[check, &[path(&file)]].concat());
        refused.expect_code(1);
        told.iter().for_each(|told| _ = refused.expect_err(told));
    }
}

#[test]
fn wrong_names_and_arguments_are_told_with_the_lines_of_both_files() {
    let script = SCRIPT
        .replace("function axis_stop(what)", "function axis_sotp(what)")
        .replace("function axis_run(what, at)", "function axis_run(what, att)")
        .replace("function axis_start(ids, where)", "function axis_start(ids, ...)");
    assert_ne!(script, SCRIPT);
    refused(
        DESCRIPTION,
        &script,
        &[
            "axis.lua: codel `axis_stop` (",
            "axis.gen:18) is not defined; did you mean `axis_sotp`?",
            "axis.gen:17), line 30: the description has no parameter `att`; did you mean `at`?",
            "axis.gen:17), line 30: it does not take parameter `at` (",
            "axis.gen:9), line 9: it takes any number of arguments",
        ],
    );
}

#[test]
fn a_script_that_does_not_run_is_told_with_its_line() {
    refused(DESCRIPTION, "function axis_start(:\n", &["axis.lua: line 1: "]);
    refused(DESCRIPTION, "local a\nlocal b = a.c\n", &["axis.lua: line 2: attempt to index a nil"]);
    refused(DESCRIPTION, "require 'no.such'\n", &["axis.lua: line 1: module 'no.such' not found"]);
    // Compiled code could do what no text does.
    refused(DESCRIPTION, "\u{1b}LuaT\0\0", &["axis.lua: "]);
}

#[test]
fn a_script_that_does_not_come_to_its_end_is_refused_also_where_it_catches_errors() {
    let loop_of = |body: &str| format!("local function spin() while true do end end\n{body}\n");
    for body in ["spin()", "while true do pcall(spin) end", "coroutine.wrap(spin)()"] {
        let (_scratch, file) = axis(DESCRIPTION, &loop_of(body));
        let refused = Home::new().refused(&["--set", "start_timeout=1", path(&file)]);
        refused.expect_code(1).expect_err("the script is here after 1 s (start_timeout)");
        refused.expect_err("axis.lua: line ");
    }
}

#[test]
fn description_and_file_agree_on_the_language() {
    for lang in ["c", "python"] {
        let other = DESCRIPTION.replace("\"lua\"", &format!("\"{lang}\""));
        let told = format!("has lang \"{lang}\": say lang \"lua\" there");
        refused(&other, SCRIPT, &["its codels are in lua, but component `axis`", &told]);
    }
}

#[test]
fn a_cell_of_another_language_refuses_a_script() {
    let (_scratch, file) = axis(DESCRIPTION, SCRIPT);
    let python = component("demo-py");
    let options = ["--cell", "both", path(&python.library), path(&file)];
    let refused = Home::new().refused(&options);
    refused.expect_code(1).expect_err("codels in lua run in a cell that begins with them");
}
