//! An independent fuzzer checks the control plane against its OpenAPI document.

use std::process::Command;

use genom_components::python;
use genom_tests::{Home, Running, WATCHDOG, component, path, program, repository, request};

/// Greatest number of requests per operation; enough for all boundary values of its parameters.
const EXAMPLES: &str = "10";

#[test]
fn the_control_plane_does_what_its_document_says() {
    let python =
        python::environment(&["schemathesis==4.32.5"]).unwrap_or_else(|error| panic!("{error}"));
    let home = Home::new();
    let mut command = Command::new(program("genomctl"));
    command.current_dir(home.path());
    command.args(["token", "fuzzer", "--rights", "admin", "--into", "tokens.toml"]);
    Running::start(&mut command).finish().expect_code(0);
    let text = std::fs::read_to_string(home.path().join("tokens.toml")).unwrap();
    let token = text.lines().find_map(|line| line.strip_prefix("token = ")).unwrap();
    let header = format!("Authorization: Bearer {}", token.trim_matches('"'));

    let demo = component("demo");
    let daemon = home.start(&[
        "--listen",
        "127.0.0.1:0",
        "--token-file",
        "tokens.toml",
        path(&demo.library),
    ]);
    let about = request(&daemon.home().socket(), "GET", "/", "").body;
    let url = format!("http://{}/openapi.json", about["listen"].as_str().unwrap());
    let config = repository().join("tests/fixtures/schemathesis.toml");
    let mut command = Command::new(python.with_file_name("schemathesis"));
    command.current_dir(daemon.home().path()).env_clear().env("PATH", "/usr/bin:/bin");
    command.args(["--config-file", path(&config), "run", &url, "--header", &header]);
    // What ends the daemon or the demo is tested elsewhere, and so are endless streams and
    // recordings, and binary samples, which a schema does not describe.
    for operation in [
        "post_shutdown",
        "delete_components_component",
        "get_events",
        "get_logs_stream",
        "get_timeline_stream",
        "get_components_component_plots",
        "get_components_component_ports_port_image",
        "post_recordings",
        "post_recordings_kept",
        "post_replay",
        "get_components_component_ports_port_stream",
    ] {
        command.args(["--exclude-operation-id", operation]);
    }
    command.args(["--max-examples", EXAMPLES, "--seed", "1", "--no-color"]);
    let finished = Running::start(&mut command).finish_within(WATCHDOG * 5);
    assert_eq!(finished.code, Some(0), "{}\n{}", finished.out, finished.err);
    // It still runs and works.
    daemon.ctl(&["list"]).expect_code(0);
}
