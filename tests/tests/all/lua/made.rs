//! `genomctl new --lang lua`.

use std::path::Path;
use std::process::Command;

use genom_tests::{Finished, Running, program};

fn run(words: &[&str], directory: &Path) -> Finished {
    let mut command = Command::new(program(words[0]));
    command.args(&words[1..]).current_dir(directory);
    Running::start(&mut command).finish()
}

#[test]
fn a_new_component_runs_and_passes_its_test() {
    let scratch = tempfile::tempdir().unwrap();
    let made = run(&["genomctl", "new", "arm", "--lang", "lua"], scratch.path());
    made.expect_code(0);
    assert!(made.out.ends_with("created arm/arm.lua\nnext: genomd arm/arm.lua\n"), "{}", made.out);
    let checked = run(&["genomd", "--check", "arm/arm.gen"], scratch.path());
    checked.expect_code(0);
    assert!(checked.out.starts_with("arm/arm.lua fits arm/arm.gen: "), "{}", checked.out);
    let tested = run(&["genomctl", "test", "arm/tests"], scratch.path());
    assert!(tested.out.ends_with("2 scenarios passed\n"), "{}\n{}", tested.out, tested.err);
    let refused =
        run(&["genomctl", "new", "leg", "--lang", "lua", "--with", "cmake"], scratch.path());
    refused.expect_code(2).expect_err("nothing builds codels in Lua");
}
