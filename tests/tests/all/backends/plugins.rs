//! Middlewares in libraries of their own: named when a daemon starts, opened in gateways.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use genom_tests::{Daemon, Finished, Home, Running, component, path, program, repository, until};
use serde_json::Value;

/// Compiles a text in C into `libgenomd_NAME.so` in a directory.
fn compile(directory: &Path, name: &str, text: &str) -> PathBuf {
    let source = directory.join(format!("{name}.c"));
    fs::write(&source, text).unwrap();
    let library = directory.join(format!("libgenomd_{name}.so"));
    let built = Command::new("cc")
        .args(["-shared", "-fPIC", "-I"])
        .arg(repository().join("plugin-api/include"))
        .arg("-o")
        .args([&library, &source])
        .output()
        .unwrap();
    assert!(built.status.success(), "{}", String::from_utf8_lossy(&built.stderr));
    library
}

/// The board of docs/plugins.md.
fn board() -> String {
    fs::read_to_string(repository().join("plugin-api/examples/board.c")).unwrap()
}

/// The demo and the mission, one connected to the other, and a motion that lasts.
fn moving(daemon: &Daemon) {
    for name in ["demo", "mission"] {
        daemon.ctl(&["load", path(&component(name).library)]).expect_code(0);
    }
    daemon.ctl(&["connect", "mission/position", "demo/position"]).expect_code(0);
    daemon.ctl(&["call", "demo", "set_speed", "velocity=0.01"]).expect_code(0);
    daemon.ctl(&["start", "demo", "goto", "goal=1"]).expect_code(0);
}

fn flows(daemon: &Daemon) {
    let seen = || daemon.port("mission", "position")["value"].clone();
    let before = seen();
    until("new positions come", || seen() != before);
}

fn gateway(daemon: &Daemon) -> Value {
    let all = daemon.json(&["cells"]);
    let mut all = all["cells"].as_array().unwrap().iter();
    all.find(|cell| cell["name"] == "gateway-board").expect("a gateway").clone()
}

#[test]
fn a_library_in_c_is_named_by_its_path_and_carries_ports_through_a_gateway() {
    let home = Home::new();
    compile(home.path(), "board", &board());
    let daemon = home.start(&["--backend", "./libgenomd_board.so"]);
    moving(&daemon);
    flows(&daemon);
    let known = daemon.json(&["backends"]);
    assert_eq!(known["default"], "board");
    let all = known["middlewares"].as_array().unwrap();
    assert!(all.iter().any(|one| one["name"] == "board" && one["version"] == "board 1"), "{known}");
    // What ends the library ends its gateway, and no component.
    let pid = gateway(&daemon)["pid"].clone();
    assert!(genom_tests::signal(&pid, "KILL"), "there is no process {pid}");
    until("another gateway runs", || {
        let now = gateway(&daemon);
        now["pid"] != pid && now["state"] == "running"
    });
    flows(&daemon);
}

#[test]
fn a_library_is_found_under_its_name_and_opened_without_a_gateway_if_there_are_none() {
    let home = Home::new().configured("[gateways]\nof = []\n");
    compile(home.path(), "board", &board());
    let variable = format!("GENOMD_BACKEND_PATH={}", home.path().display());
    let daemon = home.start_by(&["env", &variable], &["--backend", "board"]);
    moving(&daemon);
    flows(&daemon);
    assert_eq!(daemon.json(&["cells"])["cells"], serde_json::json!([]));
}

#[test]
fn a_configuration_says_where_a_library_is() {
    let home = Home::new();
    fs::create_dir(home.path().join("lib")).unwrap();
    let library = compile(home.path(), "board", &board());
    fs::rename(library, home.path().join("lib/other.so")).unwrap();
    let home = home.configured("[backends.board]\nlibrary = \"lib/other.so\"\nroom = 1\n");
    let daemon = home.start(&["--backend", "board"]);
    moving(&daemon);
    flows(&daemon);
}

#[test]
fn zenoh_in_a_library_serves_a_daemon_and_its_cells_through_one_gateway() {
    let home = Home::new();
    let meeting = home.path().join("meeting");
    fs::create_dir(&meeting).unwrap();
    let library = program("genomd").with_file_name("libgenomd_zenoh_plugin.so");
    let home = home.configured(&format!(
        "[backends.zenoh_plugin]\nlibrary = {library:?}\nrendezvous = {meeting:?}\n"
    ));
    let daemon = home.start(&["--backend", "zenoh_plugin"]);
    daemon.ctl(&["load", "--isolated", path(&component("demo").library)]).expect_code(0);
    daemon.ctl(&["load", path(&component("mission").library)]).expect_code(0);
    daemon.ctl(&["connect", "mission/position", "demo/position"]).expect_code(0);
    daemon.ctl(&["connect", "mission/goto", "demo/goto"]).expect_code(0);
    daemon.ctl(&["call", "demo", "set_speed", "velocity=0.01"]).expect_code(0);
    daemon.ctl(&["start", "demo", "goto", "goal=1"]).expect_code(0);
    flows(&daemon);
    let all = daemon.json(&["cells"]);
    let names = all["cells"].as_array().unwrap().iter().map(|cell| cell["name"].clone());
    assert_eq!(names.collect::<Vec<_>>(), ["demo", "gateway-zenoh_plugin"]);
}

/// The board, which writes into a file what it is told of components.
fn telling(file: &Path) -> String {
    let tells = format!(
        r#"
static void tell(const char *what, genom_mw_str of, genom_mw_str name, genom_mw_str text)
{{
  FILE *file = fopen({file:?}, "a");
  fprintf(file, "%s %.*s %.*s %.*s\n", what, (int)of.len, of.ptr, (int)name.len, name.ptr,
          (int)text.len, text.ptr);
  fclose(file);
}}
static void board_log(genom_mw_backend *backend, const genom_mw_entry *entry)
{{ (void)backend, tell("log", entry->instance, entry->place, entry->message); }}
static void board_diagnose(genom_mw_backend *backend, const genom_mw_diagnosis *const *parts,
                           size_t count)
{{
  (void)backend;
  for (size_t i = 0; i < count; i++)
    tell(parts[i]->part == GENOM_MW_TASK ? "task" : "cell", parts[i]->instance, parts[i]->name,
         parts[i]->message);
}}
static void board_simulated_time(genom_mw_backend *backend)
{{
  genom_mw_str none = {{ 0, 0 }};
  (void)backend, tell("simulated", none, none, none);
}}
const genom_mw_plugin"#
    );
    let more = board().replacen("const genom_mw_plugin", &tells, 1);
    let (before, table) = more.split_once("= GENOM_MW_VARIABLE,").expect("its capabilities");
    format!(
        "{before}= GENOM_MW_VARIABLE | GENOM_MW_REPORTS, .log = board_log, \
         .diagnose = board_diagnose, .simulated_time = board_simulated_time,{table}"
    )
}

#[test]
fn a_library_is_told_what_components_log_how_they_fare_and_that_their_time_is_simulated() {
    let without_gateways = "[gateways]\nof = []\n";
    for (configuration, options) in [("", &["--isolated"][..]), (without_gateways, &[])] {
        let home = Home::new().configured(configuration);
        let told = home.path().join("told");
        compile(home.path(), "board", &telling(&told));
        let demo = component("demo").library;
        let arguments = ["--backend", "./libgenomd_board.so", "--clock", "ros"];
        let _daemon = home.start(&[&arguments, options, &[path(&demo)]].concat());
        let is_told = |begins: &str, holds: &str| {
            until(&format!("it is told `{begins}... {holds}`"), || {
                let told = fs::read_to_string(&told).unwrap_or_default();
                told.lines().any(|line| line.starts_with(begins) && line.contains(holds))
            });
        };
        is_told("simulated ", "");
        is_told("log demo ", " runs on board");
        is_told("task demo main ", "");
        if !options.is_empty() {
            is_told("cell demo demo ", "its process runs");
        }
    }
}

#[test]
fn a_daemon_does_not_start_with_a_library_that_is_no_middleware() {
    let home = Home::new();
    let refused = |backend: &str, told: &str| {
        home.refused(&["--backend", backend]).expect_code(2).expect_err(told);
    };
    refused("./libgenomd_no.so", "cannot read ./libgenomd_no.so: No such file");
    compile(home.path(), "plain", "int nothing;");
    refused("./libgenomd_plain.so", "does not export `genom_middleware_plugin`");
    let next = board().replace(".major = GENOM_MW_MAJOR", ".major = 2");
    compile(home.path(), "next", &next);
    refused("./libgenomd_next.so", "built for version 2.2");
    let own = board().replace("GENOM_MW_STR(\"board\")", "GENOM_MW_STR(\"zenoh\")");
    compile(home.path(), "own", &own);
    refused("./libgenomd_own.so", "this daemon has one already");
    refused("board", "unknown backend `board`");
}

#[test]
fn a_request_cannot_name_a_library() {
    let home = Home::new();
    let library = compile(home.path(), "board", &board());
    let daemon = home.start(&[]);
    let demo = component("demo").library;
    for backend in [path(&library), "./libgenomd_board.so", "board"] {
        let refused = daemon.ctl(&["load", "--backend", backend, path(&demo)]);
        refused.expect_code(1).expect_err("unknown backend");
    }
    daemon
        .ctl(&["load", "--backend", path(&library), path(&demo)])
        .expect_err("A library is named when a daemon starts");
}

fn conformance(arguments: &[&str]) -> Finished {
    Running::start(Command::new(program("genomctl")).arg("conformance").args(arguments)).finish()
}

#[test]
fn the_conformance_suite_runs_on_a_library_and_tells_what_does_not_hold() {
    let place = tempfile::tempdir().unwrap();
    let good = compile(place.path(), "board", &board());
    let told = conformance(&[path(&good), "--only", "reader"]);
    told.expect_code(0);
    assert!(told.out.starts_with("board (board 1)\n") && told.out.contains(" holds\n"), "{told:?}");
    told.expect_err("a_reader_sees_what_was_written");
    let bad = |name: &str, instead: &str, told: &str| {
        let text = board().replace("host->sample(one->to, sample);", instead);
        let bad = compile(place.path(), name, &text);
        let ran = conformance(&[path(&bad), "--only", "a_reader_sees_what_was_written"]);
        assert!(ran.out.contains("does not hold") && ran.out.contains(told), "{ran:?}");
        ran.expect_code(1).expect_err("1 of 1 properties do not hold");
    };
    bad("loses", "(void)one;", "never: ");
    bad("dies", "abort();", "signal: 6");
    conformance(&[path(&good), "--options", "3"]).expect_code(1).expect_err("no JSON object");
    conformance(&[path(&good), "--only", "xyz"]).expect_code(1).expect_err("no property has");
    conformance(&["/no/such.so"]).expect_code(1).expect_err("cannot read /no/such.so");
}
