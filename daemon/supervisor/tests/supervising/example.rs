//! Runs `examples/ten_lines.rs`.

use genom_components::{Paths, Purpose, build};

#[path = "../../examples/ten_lines.rs"]
#[allow(dead_code, reason = "its `main` reads the command line")]
mod ten_lines;

#[test]
fn ten_lines_start_the_demo_and_call_its_services() {
    let demo = build(&Paths::of_workspace().unwrap(), "demo", Purpose::Test).unwrap();
    let told = ten_lines::run(demo.library).unwrap();
    assert!(told.contains("\"position\": Number(0.1"), "{told}");
}
