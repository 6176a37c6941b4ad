//! The programs that the book shows beside genomd, which know only a middleware: they do with a
//! running demo what the chapter says, and print what it shows.

use std::fs;
use std::path::Path;
use std::process::Command;

use genom_components::debian::CycloneDds;
use genom_components::{python, ros2};
use genom_tests::{Daemon, Memory, Running, path, repository};

use super::console::Step;
use super::source;

fn example(name: &str) -> std::path::PathBuf {
    repository().join("docs/book/examples").join(name)
}

/// What a chapter shows of a program: the block that begins with its command.
#[track_caller]
fn shown(chapter: &str, command: &str) -> Step {
    let page = fs::read_to_string(source().join(format!("{chapter}.md"))).unwrap();
    let begin = format!("\n```text\n$ {command}");
    let (_, block) = page.split_once(&begin).unwrap_or_else(|| panic!("{chapter}: no {begin}"));
    let (block, _) = block.split_once("\n```").unwrap();
    let shown = block.lines().skip(1).map(str::to_owned).collect();
    Step { command: command.to_owned(), shown }
}

/// The program ends, and prints what the chapter shows; the lines of `before` were read already.
#[track_caller]
fn as_shown(chapter: &str, command: &str, before: &[String], running: Running) {
    let finished = running.finish();
    finished.expect_code(0);
    let mut came = before.to_vec();
    came.extend(finished.out.lines().map(str::to_owned));
    let shown = shown(chapter, command);
    assert!(shown.allows(&came), "{chapter} shows of `{command}`:\n{:#?}\n{came:#?}", shown.shown);
}

fn environment(packages: &[&str]) -> Command {
    Command::new(python::environment(packages).unwrap_or_else(|error| panic!("{error}")))
}

/// The address where a program meets the daemons of a test over zenoh.
#[track_caller]
fn endpoint(memory: &Memory) -> String {
    let sockets = fs::read_dir(memory.root().join("zenoh")).unwrap();
    let mut sockets = sockets.map(|entry| entry.unwrap().path());
    let socket = sockets.find(|path| path.extension().is_some_and(|end| end == "sock"));
    format!("unixsock-stream/{}", path(&socket.expect("a session listens")))
}

#[test]
fn a_program_of_zenoh_in_python_reads_the_demo_and_drives_it() {
    let daemon = Daemon::demo("zenoh");
    let run = |script: &str| {
        let mut command = environment(&["eclipse-zenoh==1.10.2"]);
        command.arg(example(script)).arg(endpoint(daemon.home().memory()));
        as_shown("zenoh", &format!("python3 {script}"), &[], Running::start(&mut command));
    };
    run("zenoh/drive.py");
    run("zenoh/refused.py");
}

#[test]
fn a_program_of_zenoh_in_rust_watches_the_demo() {
    let daemon = Daemon::demo("zenoh");
    let mut command = Command::new(env!("CARGO_BIN_EXE_book-zenoh"));
    let running = Running::start(command.arg(endpoint(daemon.home().memory())));
    // It has subscribed when it has asked for the last value.
    let at = running.line();
    daemon.ctl(&["call", "demo", "goto", "goal=0.25"]).expect_code(0);
    as_shown("zenoh", "watch ", &[at], running);
}

/// A program of iceoryx2 that has begun to watch sees the demo arrive.
#[track_caller]
fn watches(mut command: Command, shown: &str) {
    let daemon = Daemon::demo("shm");
    let memory = daemon.home().memory();
    let running = Running::start(command.arg(memory.prefix()).arg(memory.root()));
    let watching = running.line();
    daemon.ctl(&["call", "demo", "goto", "goal=0.25"]).expect_code(0);
    as_shown("iceoryx2", shown, &[watching], running);
}

#[test]
fn a_program_of_iceoryx2_in_python_watches_the_demo() {
    let mut command = environment(&["iceoryx2==0.10.0"]);
    command.arg(example("iceoryx2/watch.py"));
    watches(command, "python3 iceoryx2/watch.py");
}

#[test]
fn a_program_of_iceoryx2_in_rust_watches_the_demo() {
    watches(Command::new(env!("CARGO_BIN_EXE_book-iceoryx2")), "watch ");
}

#[test]
fn a_node_of_ros_in_python_drives_the_demo() {
    let daemon = Daemon::demo("ros2");
    let memory = daemon.home().memory();
    let types = ros2::types(&repository().join("tests/fixtures/ros2/demo")).unwrap();
    let script: &Path = &example("ros2/drive.py");
    let mut command = ros2::script(script, memory.domain(), Some(&types)).unwrap();
    // Names of the page, in the namespace of this test.
    let namespace = format!("__ns:=/{}", memory.prefix().trim_end_matches('_'));
    command.args(["--ros-args", "-r", &namespace]);
    as_shown("ros2", "python3 ros2/drive.py", &[], Running::start(&mut command));
}

#[test]
fn a_program_in_cpp_with_nothing_but_dds_watches_the_demo() {
    let daemon = Daemon::demo("ros2");
    let memory = daemon.home().memory();
    let scratch = tempfile::tempdir().unwrap();
    let peer = CycloneDds::get().unwrap_or_else(|error| panic!("{error}"));
    let (source, types) = (example("ros2/dds/watch.cc"), example("ros2/dds/state.idl"));
    let program = peer.program(&source, &types, scratch.path()).unwrap();
    let mut command = Command::new(program);
    // The topic of the page, in the namespace of this test.
    command.arg(format!("rt/{}/demo/position", memory.prefix().trim_end_matches('_')));
    command.arg(memory.domain().to_string());
    command.env("LD_LIBRARY_PATH", peer.libraries());
    command.env("CYCLONEDDS_URI", format!("file://{}", path(&example("ros2/dds/loopback.xml"))));
    let running = Running::start(&mut command);
    let watching = running.line();
    daemon.ctl(&["call", "demo", "goto", "goal=0.25"]).expect_code(0);
    as_shown("ros2", "watch ", &[watching], running);
}

#[test]
fn every_example_is_used() {
    let mut unused = Vec::new();
    let mut shown = String::new();
    for chapter in super::chapters() {
        shown.push_str(&fs::read_to_string(chapter).unwrap());
    }
    for extension in ["py", "rs", "gen", "idl", "c", "cc", "toml", "xml"] {
        for file in genom_tests::files(extension) {
            let Ok(within) = file.strip_prefix(repository().join("docs/book/examples")) else {
                continue;
            };
            if !shown.contains(&format!("examples/{}", within.display())) {
                unused.push(within.display().to_string());
            }
        }
    }
    assert!(unused.is_empty(), "no chapter shows {unused:?}");
}
