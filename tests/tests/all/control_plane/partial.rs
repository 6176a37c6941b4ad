//! Omitted inputs: an attribute keeps its value, a function or activity takes its default, and an
//! input without either is refused by name; the same through every interface.

use genom_tests::{Daemon, component, fixture, path, request, until};
use serde_json::{Value, json};
use tempfile::TempDir;

struct Gains {
    daemon: Daemon,
    _scratch: TempDir,
}

impl Gains {
    fn new() -> Self {
        let scratch = TempDir::new().unwrap();
        let daemon = Daemon::start(&[&fixture("gains", "gains", scratch.path())]);
        Self { daemon, _scratch: scratch }
    }

    #[track_caller]
    fn call(&self, arguments: &[&str]) {
        self.daemon.ctl(&[&["call", "gains"], arguments].concat()).expect_code(0);
    }

    fn result(&self, arguments: &[&str]) -> Value {
        let reply = self.daemon.json(&[&["call", "gains"], arguments].concat());
        reply["result"].clone()
    }

    /// Checks the three gains.
    #[track_caller]
    fn are(&self, wanted: [f64; 3]) {
        let [a, b, c] = wanted;
        assert_eq!(self.result(&["get"])["all"], json!({"a": a, "b": b, "c": c}));
    }
}

#[test]
fn what_is_left_out_of_an_attribute_keeps_its_value() {
    let gains = Gains::new();
    gains.are([1.0, 2.0, 3.0]);
    gains.call(&["set", "all.b=5"]);
    gains.are([1.0, 5.0, 3.0]);
    // Nor is a whole input that is omitted set to its default.
    gains.call(&["two", "b=6"]);
    gains.are([1.0, 6.0, 3.0]);
    gains.call(&["set"]);
    gains.are([1.0, 6.0, 3.0]);
    // An element of a sequence.
    gains.call(&["set_list", r#"{"list": {"1": 8}}"#]);
    assert_eq!(gains.result(&["get"])["list"], json!([0.5, 8.0]));
    // The same over HTTP.
    let body = r#"{"all": {"c": 7}}"#;
    let socket = gains.daemon.home().socket();
    let reply = request(&socket, "POST", "/components/gains/services/set", body);
    assert_eq!(reply.status, 200, "{}", reply.body);
    gains.are([1.0, 6.0, 7.0]);
    // A dump contains the whole value, and restores it.
    let dump = gains.daemon.ctl(&["dump"]);
    for line in ["a = 1.0", "b = 6.0", "c = 7.0"] {
        assert!(dump.out.contains(line), "{}", dump.out);
    }
}

#[test]
fn zeros_are_taken_by_those_who_ask_for_them() {
    let gains = Gains::new();
    gains.call(&["--zero", "set", "all.b=5"]);
    gains.are([0.0, 5.0, 0.0]);
    gains.call(&["--zero", "two", "b=6"]);
    gains.are([10.0, 6.0, 0.0]);
    assert_eq!(gains.result(&["--zero", "sum", "of.a=4"])["result"], 8.0);
    gains.daemon.ctl(&["start", "--zero", "gains", "go"]).expect_code(0);
}

#[test]
fn what_has_neither_value_nor_default_is_refused_by_name() {
    let gains = Gains::new();
    assert_eq!(gains.result(&["sum", r#"{"of": {"a": 1, "b": 2, "c": 3}}"#])["result"], 12.0);
    assert_eq!(gains.result(&["half", "of.b=2"])["result"], 3.0);
    for (arguments, name) in [
        (&["call", "gains", "sum", "factor=1"][..], "`of.a`"),
        (&["call", "gains", "sum", "of.a=1", "of.b=1"], "`of.c`"),
        (&["call", "gains", "half"], "`of.b`"),
        (&["start", "gains", "go", "to.a=1"], "`to.b`"),
        (&["start", "gains", "go", "{}"], "`to.a`"),
        (&["call", "gains", "connect_port", "local=x"], "`remote`"),
    ] {
        let refused = gains.daemon.ctl(arguments);
        refused.expect_code(1).expect_err(&format!("wants input {name}, which has no default"));
        refused.expect_err("--zero");
    }
    // No codel ran.
    gains.are([1.0, 2.0, 3.0]);
    let described = gains.daemon.json(&["info", "gains", "sum"]);
    assert_eq!(described["input_schema"]["required"], json!(["of"]));
}

#[test]
fn what_an_attribute_keeps_is_shown() {
    let gains = Gains::new();
    gains
        .daemon
        .ctl(&["info", "gains", "two"])
        .expect_out("attribute two(in double a = ?, in double b = ?)\n    a ? 1.0\n    b ? 2.0\n");
    // Reading the value calls no codel, so it needs no permission to call.
    gains.daemon.ctl(&["info", "gains", "set_slowly"]).expect_code(0);
    assert_eq!(gains.result(&["waits"])["yes"], false);
}

#[test]
fn what_changes_while_the_rest_is_checked_stays_changed() {
    let gains = Gains::new();
    let slow = gains.daemon.spawn(&["call", "gains", "set_slowly", "all.a=5"]);
    until("the validation begins", || gains.result(&["waits"])["yes"] == true);
    gains.call(&["set_c", "c=9"]);
    gains.call(&["release"]);
    slow.finish().expect_code(0);
    gains.are([5.0, 2.0, 9.0]);
}

#[test]
fn codels_in_cpp_keep_their_values_too() {
    let demo = component("demo-cpp");
    let daemon = Daemon::start(&[path(&demo.library)]);
    let name = "a name that no small string of the C++ library holds";
    let given = json!({ "name": name }).to_string();
    daemon.ctl(&["call", "demo", "set_name", &given]).expect_code(0);
    daemon.ctl(&["call", "demo", "set_name", "{}"]).expect_code(0);
    assert_eq!(daemon.json(&["call", "demo", "get_name"])["result"], json!({ "name": name }));
    let shown = daemon.json(&["info", "demo", "set_name"]);
    assert_eq!(shown["parameters"][0]["current"], name);
}
