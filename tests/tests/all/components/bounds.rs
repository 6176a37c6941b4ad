//! Descriptions made to use up memory: a program that may use 300 MB either reads them or refuses
//! them with a precise message.

use std::fs;
use std::path::Path;
use std::process::Command;

use genom_tests::{Daemon, Finished, Footprint, Running, component, path, program};

/// Limit in KiB for the program's data (`ulimit -d`); allocations beyond it fail, and the program
/// ends.
const ROOM: &str = "300000";

fn genomctl(verb: &str, text: &str) -> Finished {
    within(ROOM, verb, text)
}

fn within(room: &str, verb: &str, text: &str) -> Finished {
    let scratch = tempfile::tempdir().unwrap();
    let file = scratch.path().join("x.gen");
    fs::write(&file, text).unwrap();
    let script = r#"ulimit -d "$0" && exec "$@""#;
    let mut command = Command::new("sh");
    command.args(["-c", script, room]).arg(program("genomctl")).args([
        verb,
        "--short",
        path(&file),
    ]);
    Running::start(&mut command).finish()
}

#[track_caller]
fn refused(text: &str, message: &str) {
    let checked = genomctl("check", text);
    checked.expect_code(1).expect_err(message).expect_err("error: 1 error in the description");
}

#[track_caller]
fn accepted(text: &str) {
    genomctl("check", text).expect_code(0);
}

fn repeat(count: usize, line: impl Fn(usize) -> String) -> String {
    (0..count).map(line).collect()
}

/// A macro applied to itself: `q(q(q(...)))`.
fn nested(name: &str, levels: usize, inside: &str) -> String {
    format!("{}{inside}{}", format!("{name}(").repeat(levels), ")".repeat(levels))
}

#[test]
fn the_limit_of_these_tests_is_one() {
    let text = format!("const string a = \"{}\";\n", "y".repeat(1 << 23));
    accepted(&text);
    assert_ne!(within("10000", "check", &text).code, Some(0), "8 MB do not fit into 10 twice");
}

#[test]
fn strings_of_strings_end_before_they_have_doubled_too_often() {
    let head = "#define s(x) #x\n#define q(x) s(x)\nconst string a = ";
    for levels in [20, 60] {
        let text = format!("{head}{};\n", nested("q", levels, r#""\\""#));
        assert!(text.len() < 260, "{}", text.len());
        refused(&text, "macros expand to more than 16 MiB of text [E0127]");
    }
}

#[test]
fn names_glued_to_themselves_end() {
    let twice = |n: usize| format!("#define x{} d(x{n}, x{n})\n", n + 1);
    let head = "#define c(a, b) a##b\n#define d(a, b) c(a, b)\n#define x0 abcdefgh\n";
    refused(&format!("{head}{}const long x40 = 1;\n", repeat(40, twice)), "[E0127]");
}

#[test]
fn a_long_text_is_not_copied_without_end() {
    let long = "y".repeat(1 << 20);
    let uses = |value: &'static str| repeat(20_000, |n| format!("const string c{n} = {value};\n"));
    let text = format!("#define LONG \"{long}\"\n{}", uses("LONG"));
    refused(&text, "macros expand to more than 16 MiB of text [E0127]");
    let text = format!("const string LONG = \"{long}\";\n{}", uses("LONG"));
    refused(&text, "here the description takes more than 128 MiB [E0408]");
    refused(&format!("const long {long} = 1;\n"), "a name of 1048576 characters [E0117]");
}

#[test]
fn arguments_in_arguments_are_not_held_at_each_level_without_end() {
    let text = format!("#define f(x) x\n{}", nested("f", 99, &"1 ".repeat(400_000)));
    refused(&text, "macros expand to more than 1048576 tokens [E0127]");
    let text = format!("#define f(x) {} x\n{}", "1 ".repeat(100_000), nested("f", 99, "1"));
    refused(&text, "macros expand to more than 1048576 tokens [E0127]");
}

#[test]
fn what_interfaces_hand_on_ends() {
    let chain = |n: usize| {
        format!(
            "interface i{} {{ extends i{n}; function f{n}(); ids {{ long m{n}; }}; }};\n",
            n + 1
        )
    };
    let text = format!("interface i0;\n{}", repeat(2000, chain));
    refused(&text, "here the description takes more than 128 MiB [E0408]");
    let functions = repeat(1000, |n| format!("function f{n}();\n"));
    for takes in ["extends", "provides", "uses"] {
        let one = |n: usize| match takes {
            "extends" => format!("interface i{n} {{ extends all_of_it; }};\n"),
            takes => format!("component c{n} {{ {takes} all_of_it; }};\n"),
        };
        let text = format!("interface all_of_it {{ {functions} }};\n{}", repeat(2000, one));
        refused(&text, "here the description takes more than 128 MiB [E0408]");
    }
}

#[test]
fn lists_of_exceptions_are_united_in_linear_time() {
    let exceptions = repeat(1000, |n| format!("exception e{n};\n"));
    let list = repeat(1000, |n| format!("e{n}{}", if n == 999 { "" } else { ", " }));
    let functions = repeat(1000, |n| format!("function f{n}();\n"));
    accepted(&format!("component c {{ {exceptions} throws {list}; {functions} }};\n"));
    let throwing = repeat(100, |n| format!("function f{n}() {{ throws {list}; }};\n"));
    accepted(&format!("component c {{ {exceptions} throws {list}; {throwing} }};\n"));
    let providing = repeat(5000, |n| format!("component c{n} {{ provides i; }};\n"));
    let text = format!("interface i {{ {exceptions} throws {list}; }};\n{providing}");
    refused(&text, "here the description takes more than 128 MiB [E0408]");
}

#[test]
fn relations_of_all_with_all_end() {
    let functions = repeat(4500, |n| format!("function f{n}() {{ interrupts all; }};\n"));
    refused(&format!("component c {{ {functions} }};\n"), "[E0408]");
    let whole =
        |n: usize| format!("task t{n} {{ codel<start> s{n}(inout ::ids) yield ether; }};\n");
    let text = format!("component c {{ ids {{ long x; }}; {} }};\n", repeat(2100, whole));
    refused(&text, "codels of `c` share more data than can be told apart [E0725]");
}

#[test]
fn long_texts_end() {
    let many = "description has more than 1048576 words and signs [E0133]";
    refused(&"component ".repeat((1 << 20) + 10), many);
    refused(&format!("#if {}\n#endif\n", "1 ".repeat(1 << 19)), "holds more than 262144 tokens");
    let macros = repeat(200_000, |n| format!("#define m{n}\n"));
    refused(&macros, "macros hold more than 1048576 tokens in all [E0133]");
    refused(&" ".repeat(17 << 20), "it is larger than 16 MiB [E0133]");
    let exceptions = repeat(300_000, |n| format!("e{n}, "));
    refused(&format!("exception {exceptions} last;\n"), "[E0408]");
    let deep = |n: usize| format!("module {}{n} {{\n", "m".repeat(1000));
    let types = repeat(20_000, |n| format!("typedef long t{n};\n"));
    refused(&format!("{}{types}{}", repeat(90, deep), "};\n".repeat(90)), "[E0408]");
}

#[test]
fn a_daemon_that_is_to_load_them_stays_within_as_much_and_goes_on() {
    let daemon = Daemon::demo("local");
    let held = || Footprint::of(daemon.process().id());
    // Most of it is the program's file.
    let before = held().resident;
    let scratch = tempfile::tempdir().unwrap();
    let file = scratch.path().join("x.gen");
    // Any library will do, because the description is read first.
    fs::write(scratch.path().join("x.so"), fs::read(component("demo").library).unwrap()).unwrap();
    let head = "#define s(x) #x\n#define q(x) s(x)\nconst string a = ";
    let doubled = format!("{head}{};\n", nested("q", 60, r#""\\""#));
    let long = "y".repeat(1 << 20);
    let used = repeat(20_000, |n| format!("const string c{n} = LONG;\n"));
    let chain = |n: usize| format!("interface i{} {{ extends i{n}; function f{n}(); }};\n", n + 1);
    for (text, code) in [
        (doubled, "E0127"),
        (format!("const string LONG = \"{long}\";\n{used}"), "E0408"),
        (format!("interface i0;\n{}", repeat(4000, chain)), "E0408"),
        (" ".repeat(17 << 20), "E0133"),
    ] {
        fs::write(&file, text).unwrap();
        daemon.ctl(&["load", path(&file)]).expect_code(1).expect_err(code);
    }
    let more = held().peak - before;
    assert!(more < 300_000, "{more} KiB");
    daemon.ctl(&["call", "demo", "get_speed"]).expect_code(0);
}

#[test]
fn mistakes_without_number_are_counted_and_the_first_are_told() {
    let checked = genomctl("check", &repeat(50_000, |n| format!("typedef nope{n} x{n};\n")));
    checked.expect_code(1).expect_err("... and 49900 errors more");
    checked.expect_err("error: 50000 errors in the description");
    assert!(checked.err.len() < 10_000, "{} bytes", checked.err.len());
}

#[test]
fn what_is_no_file_is_called_what_it_is() {
    let scratch = tempfile::tempdir().unwrap();
    let fifo = scratch.path().join("fifo");
    let made = Command::new("mkfifo").arg(&fifo).status().unwrap();
    assert!(made.success());
    let check = |verb: &str, path: &Path| {
        let mut command = Command::new(program("genomctl"));
        Running::start(command.arg(verb).arg(path)).finish()
    };
    for (path, what) in [
        (fifo.as_path(), "it is a FIFO, not a file"),
        (scratch.path(), "it is a directory, not a file"),
        (Path::new("/dev/zero"), "it is a device, not a file"),
    ] {
        for verb in ["check", "fmt", "describe"] {
            check(verb, path).expect_code(2).expect_err(what);
        }
    }
}
