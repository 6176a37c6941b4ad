//! Recordings: written by genomctl, read with the public MCAP packages, replayed.

use std::path::{Path, PathBuf};
use std::process::Command;

use genom_components::python;
use genom_tests::{Daemon, Finished, Home, Running, component, path, program, repository, until};
use serde_json::{Value, json};

/// A daemon whose clock stands still until it is stepped.
fn stepped() -> Daemon {
    Daemon::start(&["--clock", "virtual", path(&component("demo").library)])
}

/// A recording in progress.
pub(crate) struct Recorder {
    running: Running,
    file: PathBuf,
}

impl Recorder {
    /// Starts one; everything from now on is recorded.
    pub(crate) fn start(daemon: &Daemon, name: &str, more: &[&str]) -> Self {
        let file = daemon.home().path().join(name);
        let running = daemon.spawn(&[&["--json", "record", "-o", path(&file)], more].concat());
        let begun = running.error_line_where(|line| line.contains("recording to"));
        assert!(begun.is_some(), "{}", running.finish().err);
        Self { running, file }
    }

    /// Ends it as Ctrl-C does; returns its summary and its file.
    pub(crate) fn end(self) -> (Value, PathBuf) {
        self.running.signal("INT");
        let finished = self.running.finish();
        finished.expect_code(0);
        (serde_json::from_str(&finished.out).expect("JSON"), self.file)
    }
}

/// Recorded and lost messages of a topic according to `genomctl record`.
fn counted(summary: &Value, topic: &str) -> (u64, u64) {
    let channels = summary["channels"].as_array().expect("channels");
    let channel = channels.iter().find(|channel| channel["topic"] == topic).expect(topic);
    (channel["messages"].as_u64().unwrap(), channel["lost"].as_u64().unwrap_or_default())
}

/// The file as the Python packages `mcap` and `mcap-ros2-support` read it: for each topic, a list
/// of `[date, number, message]`.
pub(crate) fn read(file: &Path) -> Value {
    const SCRIPT: &str = r#"
import json, sys
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory

class Json:
    def decoder_for(self, encoding, schema):
        return json.loads if encoding == "json" and schema.encoding == "jsonschema" else None

def plain(value):
    if hasattr(value, "__slots__"):
        return {name: plain(getattr(value, name)) for name in value.__slots__}
    if isinstance(value, bytes):
        return value.hex()
    return [plain(one) for one in value] if isinstance(value, (list, tuple)) else value

topics = {}
with open(sys.argv[1], "rb") as stream:
    reader = make_reader(stream, decoder_factories=[DecoderFactory(), Json()], validate_crcs=True)
    for schema, channel, message, value in reader.iter_decoded_messages():
        topics.setdefault(channel.topic, []).append([message.log_time, message.sequence, plain(value)])
    topics["attachments"] = [one.name for one in reader.iter_attachments()]
    topics["metadata"] = {one.name: one.metadata for one in reader.iter_metadata()}
print(json.dumps(topics))
"#;
    by_others(SCRIPT, file)
}

/// What is in the file to the byte: for each topic, its schema and a list of
/// `[date, date of publication, number, bytes of the message]`.
pub(crate) fn raw(file: &Path) -> Value {
    const SCRIPT: &str = r#"
import json, sys
from mcap.reader import make_reader

topics = {}
with open(sys.argv[1], "rb") as stream:
    for schema, channel, message in make_reader(stream, validate_crcs=True).iter_messages():
        head = [channel.message_encoding, schema.name, schema.encoding, schema.data.hex()]
        topic = topics.setdefault(channel.topic, {"head": head, "messages": []})
        assert topic["head"] == head, channel.topic
        topic["messages"].append(
            [message.log_time, message.publish_time, message.sequence, message.data.hex()]
        )
print(json.dumps(topics))
"#;
    by_others(SCRIPT, file)
}

/// What a script says of a file, which uses the Python packages for MCAP.
fn by_others(script: &str, file: &Path) -> Value {
    let packages = ["mcap==1.3.1", "mcap-ros2-support==0.5.7"];
    let python = python::environment(&packages).unwrap_or_else(|error| panic!("{error}"));
    let mut command = Command::new(python);
    command.args(["-c", script]).arg(file);
    let finished = Running::start(&mut command).finish();
    finished.expect_code(0);
    serde_json::from_str(&finished.out).expect("JSON")
}

fn list<'a>(topics: &'a Value, topic: &str) -> &'a Vec<Value> {
    topics[topic].as_array().unwrap_or_else(|| panic!("{topic} is not in {topics}"))
}

#[test]
fn a_recording_is_read_back_by_others_with_calls_activities_and_exceptions() {
    let daemon = stepped();
    let recorder = Recorder::start(&daemon, "run.mcap", &[]);
    daemon.ctl(&["call", "demo", "set_speed", "velocity=0.75"]).expect_code(0);
    daemon.ctl(&["call", "demo", "goto", "goal=99"]).expect_code(1);
    daemon.ctl(&["start", "demo", "goto", "goal=0.5"]).expect_code(0);
    daemon.ctl(&["pub", "demo/parameter", "0.5"]).expect_code(0);
    daemon.ctl(&["step", "10s"]).expect_code(0);
    let written = daemon.port("demo", "position")["traffic"]["samples"].as_u64().unwrap();
    let (summary, file) = recorder.end();
    assert_eq!(summary["complete"], true);

    let topics = read(&file);
    // The start codel wrote one sample before.
    let positions = list(&topics, "/demo/position");
    assert_eq!(positions.len() as u64, written - 1);
    assert_eq!(counted(&summary, "/demo/position"), (written - 1, 0));
    for (number, sample) in positions.iter().enumerate() {
        assert_eq!(sample[1], number as u64);
        // One tick per 5 ms of the stepped clock.
        assert_eq!(sample[0].as_u64().unwrap() % 5_000_000, 0);
    }
    let last = positions.last().unwrap();
    assert_eq!(last[2], json!({"position": 0.5, "velocity": 0.0}));
    // What the in port read, once.
    let read: Vec<&Value> = list(&topics, "/demo/parameter").iter().map(|one| &one[2]).collect();
    assert_eq!(read, [&json!({"data": 0.5})]);

    let calls: Vec<Value> =
        list(&topics, "/genom/calls").iter().map(|one| one[2].clone()).collect();
    let of = |service: &str, phase: &str| {
        let found = calls.iter().find(|one| one["service"] == service && one["phase"] == phase);
        found.unwrap_or_else(|| panic!("no {phase} of {service} in {calls:?}")).clone()
    };
    assert_eq!(of("set_speed", "request")["inputs"], json!({"velocity": 0.75}));
    assert_eq!(of("set_speed", "reply")["result"], json!({}));
    let exceptions = list(&topics, "/genom/exceptions");
    assert_eq!(exceptions[0][2]["exception"], "::demo::OUT_OF_RANGE");
    assert_eq!(exceptions[0][2]["detail"]["value"], 99.0);
    let states: Vec<&str> = list(&topics, "/genom/activities")
        .iter()
        .filter(|one| one[2]["service"] == "goto")
        .map(|one| one[2]["state"].as_str().unwrap_or(one[2]["event"].as_str().unwrap()))
        .collect();
    assert_eq!(states.first(), Some(&"activity_started"));
    assert!(states.contains(&"main"), "{states:?}");
    assert_eq!(states.last(), Some(&"activity_ended"));
    assert_eq!(topics["attachments"], json!(["deployment.toml"]));
    assert_eq!(topics["metadata"]["genom"]["clock"], "virtual");
    assert_eq!(topics["metadata"]["genom.lost"]["complete"], "true");
}

#[test]
fn lost_samples_are_counted_and_leave_gaps() {
    let daemon = stepped();
    let recorder = Recorder::start(&daemon, "run.mcap", &["demo/position"]);
    daemon.ctl(&["call", "demo", "set_speed", "velocity=0.001"]).expect_code(0);
    daemon.ctl(&["start", "demo", "goto", "goal=1"]).expect_code(0);
    // The reader is stopped while twice as much is written as the buffers hold, but not so long
    // that the daemon gives it up (10 s), even on a busy machine.
    recorder.running.signal("STOP");
    daemon.ctl(&["step", "200s"]).expect_code(0);
    recorder.running.signal("CONT");
    let written = daemon.port("demo", "position")["traffic"]["samples"].as_u64().unwrap();
    let (summary, file) = recorder.end();
    let (messages, lost) = counted(&summary, "/demo/position");
    assert!(lost > 0 && messages > 0, "{summary}");
    // Each sample is in the file or counted as lost; the first was written before.
    assert_eq!(messages + lost, written - 1);
    let topics = read(&file);
    assert_eq!(list(&topics, "/demo/position").len() as u64, messages);
    assert_eq!(topics["metadata"]["genom.lost"]["/demo/position"], lost.to_string());
}

/// Positions with their dates, of a daemon that moves while `feed` sets its gain.
pub(crate) fn motion(feed: impl FnOnce(&Daemon)) -> (Value, PathBuf, Daemon) {
    let daemon = stepped();
    let recorder = Recorder::start(&daemon, "run.mcap", &["demo"]);
    daemon.ctl(&["start", "demo", "goto", "goal=0.5"]).expect_code(0);
    feed(&daemon);
    daemon.ctl(&["step", "10s"]).expect_code(0);
    let (_, file) = recorder.end();
    (read(&file)["/demo/position"].clone(), file, daemon)
}

/// The same while the gain is set three times.
pub(crate) fn fed() -> (Value, PathBuf, Daemon) {
    motion(|daemon| {
        for (gain, time) in [("0.5", "100ms"), ("0.125", "35ms"), ("1", "200ms")] {
            daemon.ctl(&["pub", "demo/parameter", gain]).expect_code(0);
            daemon.ctl(&["step", time]).expect_code(0);
        }
    })
}

#[test]
fn a_replay_on_the_stepped_clock_gives_the_same_motion() {
    let (first, file, _daemon) = fed();
    let (again, _, _daemon) = motion(|daemon| {
        let replayed = daemon.json(&["replay", "--step", path(&file)]);
        assert_eq!(replayed["ports"], json!([{"port": "demo/parameter", "published": 3}]));
    });
    assert_eq!(first, again);
    // The gains do make a difference.
    let (other, _, _daemon) = motion(|_| {});
    assert_ne!(first, other);
}

#[test]
fn a_replay_keeps_its_timing_and_feeds_what_it_is_told_to() {
    let (_, file, daemon) = motion(|daemon| {
        daemon.ctl(&["pub", "demo/parameter", "0.5"]).expect_code(0);
        daemon.ctl(&["step", "300ms"]).expect_code(0);
        daemon.ctl(&["pub", "demo/parameter", "0.25"]).expect_code(0);
    });
    let other = Daemon::demo("local");
    let begin = std::time::Instant::now();
    let replayed = other.json(&["replay", path(&file)]);
    assert!(begin.elapsed().as_millis() >= 300, "{:?}", begin.elapsed());
    assert_eq!(replayed["ports"], json!([{"port": "demo/parameter", "published": 2}]));
    other.ctl(&["call", "demo", "goto", "goal=0.01"]).expect_code(0);
    assert_eq!(other.port("demo", "parameter")["value"], 0.25);

    let refuse = |arguments: &[&str]| -> Finished {
        other.ctl(&[&["replay", path(&file)], arguments].concat())
    };
    refuse(&["--to", "/demo/position=demo/parameter"])
        .expect_code(1)
        .expect_err("/demo/position was recorded with another type than demo/parameter has now");
    refuse(&["--to", "/gps/pose=demo/parameter"])
        .expect_code(2)
        .expect_err("no samples of /gps/pose");
    refuse(&["--to", "demo/parameter=demo/position"]).expect_code(1);
    refuse(&["--step"]).expect_code(1).expect_err("genomd --clock virtual");
    drop(daemon);
}

#[test]
fn mistakes_leave_files_alone() {
    let daemon = Daemon::demo("local");
    let file = daemon.home().path().join("run.mcap");
    let record = |arguments: &[&str]| {
        daemon.ctl(&[&["record", "-o", path(&file), "--duration", "0.01"], arguments].concat())
    };
    record(&["demo/positio"]).expect_code(1).expect_err("did you mean `position`?");
    record(&["dmo"]).expect_code(1).expect_err("did you mean `demo`?");
    assert!(!file.exists());
    record(&[]).expect_code(0);
    let before = std::fs::read(&file).unwrap();
    record(&[]).expect_code(2).expect_err("--force");
    assert_eq!(std::fs::read(&file).unwrap(), before);
    record(&["--force"]).expect_code(0);
    let nothing = daemon.home().path().join("genomd.toml");
    daemon.ctl(&["replay", path(&nothing)]).expect_code(1).expect_err("no MCAP file");
}

#[test]
fn a_daemon_that_stops_ends_the_file() {
    let daemon = stepped();
    let recorder = Recorder::start(&daemon, "run.mcap", &[]);
    daemon.ctl(&["start", "demo", "goto", "goal=0.5"]).expect_code(0);
    daemon.ctl(&["step", "10s"]).expect_code(0);
    let (stopped, home) = daemon.stop("TERM");
    stopped.expect_code(0);
    let finished = recorder.running.finish();
    finished.expect_code(0);
    let last = read(&recorder.file)["/demo/position"].as_array().unwrap().last().unwrap().clone();
    assert_eq!(last[2]["position"], 0.5);
    drop(home);
}

/// A daemon whose wall clock is ahead by as many seconds as the file has bytes.
fn settable() -> (Daemon, std::fs::File) {
    let home = Home::new();
    let (wall, library) = (home.path().join("wall"), home.path().join("wall.so"));
    let file = std::fs::File::create(&wall).unwrap();
    let mut compiler = Command::new("cc");
    compiler.args(["-std=gnu11", "-Wall", "-Wextra", "-Werror", "-fPIC", "-shared"]);
    compiler.arg(repository().join("tests/fixtures/wall/wall.c"));
    compiler.arg("-o").arg(&library).arg("-ldl");
    Running::start(&mut compiler).finish().expect_code(0);
    let preload = format!("LD_PRELOAD={}", path(&library));
    let wall = format!("WALL={}", path(&wall));
    let demo = component("demo");
    (home.start_by(&["env", &preload, &wall], &[path(&demo.library)]), file)
}

#[test]
fn samples_keep_their_distance_when_the_machines_clock_is_set() {
    /// Seconds by which the clock is set forward and back.
    const BY: u64 = 100_000;
    let (daemon, clock) = settable();
    daemon.ctl(&["call", "demo", "set_speed", "velocity=0.001"]).expect_code(0);
    daemon.ctl(&["start", "demo", "goto", "goal=1"]).expect_code(0);
    let written = || daemon.port("demo", "position")["traffic"]["samples"].as_u64().unwrap();
    for ahead in [BY, 0] {
        let name = format!("{ahead}.mcap");
        let recorder = Recorder::start(&daemon, &name, &[]);
        let go_on = || {
            let before = written();
            until("samples are written", || written() > before + 5);
        };
        go_on();
        clock.set_len(ahead).unwrap();
        go_on();
        let topics = read(&recorder.end().1);
        let dates: Vec<u64> = list(&topics, "/demo/position")
            .iter()
            .map(|sample| sample[0].as_u64().unwrap())
            .collect();
        let gap = |pair: &[u64]| pair[1].abs_diff(pair[0]);
        assert!(dates.is_sorted(), "{dates:?}");
        assert!(dates.windows(2).map(gap).all(|gap| gap < BY / 2 * 1_000_000_000), "{dates:?}");
        // The recording shows it, for whoever compares it with other logs.
        let changes = list(&topics, "/genom/changes");
        let set = changes.iter().find(|change| change[2]["event"] == "clock_set");
        let by = set.expect("it is noted")[2]["ahead_ns"].as_i64().unwrap() / 1_000_000_000;
        let wanted = if ahead == 0 { -BY.cast_signed() } else { BY.cast_signed() };
        assert!((by - wanted).abs() < BY.cast_signed() / 2, "{by} s");
    }
}

#[test]
fn of_a_recorder_that_was_killed_all_that_is_whole_is_replayed_and_recovered() {
    let daemon = stepped();
    let recorder = Recorder::start(&daemon, "run.mcap", &[]);
    daemon.ctl(&["call", "demo", "set_speed", "velocity=0.001"]).expect_code(0);
    daemon.ctl(&["start", "demo", "goto", "goal=1"]).expect_code(0);
    for gain in ["0.5", "0.25", "1"] {
        daemon.ctl(&["pub", "demo/parameter", gain]).expect_code(0);
        daemon.ctl(&["step", "20ms"]).expect_code(0);
    }
    daemon.ctl(&["step", "50s"]).expect_code(0);
    let size = || std::fs::metadata(&recorder.file).unwrap().len();
    until("the recorder writes", || size() > 100_000);
    recorder.running.signal("KILL");
    let file = recorder.file;
    assert_eq!(recorder.running.finish().code, None);
    // The file ends in the middle of a sample: one byte before the end of the last complete one.
    let cut = std::fs::File::options().write(true).open(&file).unwrap();
    cut.set_len(100_000).unwrap();
    let whole = daemon.home().path().join("whole.mcap");
    let recover = ["recover", path(&file), "-o", path(&whole)];
    let rest = daemon.json(&recover)["bytes_given_up"].as_u64().unwrap();
    cut.set_len(99_999 - rest).unwrap();
    std::fs::remove_file(&whole).unwrap();

    let other = stepped();
    let replayed = other.ctl(&["--json", "replay", "--step", path(&file)]);
    replayed.expect_code(0).expect_err("run.mcap was not ended: ").expect_err("genomctl recover");
    let reply: Value = serde_json::from_str(&replayed.out).unwrap();
    assert_eq!(reply["ports"], json!([{"port": "demo/parameter", "published": 3}]));

    let recovered = daemon.json(&recover);
    assert!(recovered["bytes_given_up"].as_u64().unwrap() > 0, "{recovered}");
    let topics = read(&whole);
    assert_eq!(list(&topics, "/demo/parameter").len(), 3);
    let positions = list(&topics, "/demo/position");
    assert!(positions.len() > 100);
    for (number, sample) in positions.iter().enumerate() {
        assert_eq!(sample[1], number as u64);
    }
    assert_eq!(counted(&recovered, "/demo/position"), (positions.len() as u64, 0));
    assert_eq!(topics["attachments"], json!(["deployment.toml"]));
    assert_eq!(topics["metadata"]["genom"]["clock"], "virtual");

    daemon.ctl(&recover).expect_code(2).expect_err("--force");
    daemon.ctl(&["recover", path(&file), "-o", path(&file)]).expect_code(2);
    let nothing = daemon.home().path().join("genomd.toml");
    let refused = daemon.ctl(&["recover", path(&nothing), "--force", "-o", path(&whole)]);
    refused.expect_code(1).expect_err("genomd.toml: it is no MCAP file");
    assert_eq!(list(&read(&whole), "/demo/parameter").len(), 3);
}

#[test]
fn a_recording_that_finds_no_room_ends_in_order_and_says_so() {
    const MOST: u64 = 200_000;
    let daemon = stepped();
    let file = daemon.home().path().join("run.mcap");
    let mut command = Command::new("prlimit");
    command.arg(format!("--fsize={MOST}")).arg(program("genomctl"));
    command.arg("--socket").arg(daemon.home().socket());
    command.args(["--json", "record", "demo", "-o"]).arg(&file);
    let recorder = Running::start(&mut command);
    assert!(recorder.error_line_where(|line| line.contains("recording to")).is_some());
    daemon.ctl(&["call", "demo", "set_speed", "velocity=0.001"]).expect_code(0);
    daemon.ctl(&["start", "demo", "goto", "goal=1"]).expect_code(0);
    // It ends on its own.
    for _ in 0..5 {
        daemon.ctl(&["step", "10s"]).expect_code(0);
    }
    let full = recorder.finish();
    full.expect_code(1).expect_err("run.mcap: File too large").expect_err(" bytes: it ends there");
    assert!(std::fs::metadata(&file).unwrap().len() <= MOST);
    let summary: Value = serde_json::from_str(&full.out).unwrap();
    let topics = read(&file);
    let messages = list(&topics, "/demo/position").len() as u64;
    assert!(messages > 1000, "{messages}");
    assert_eq!(counted(&summary, "/demo/position").0, messages);
    assert_eq!(topics["metadata"]["genom.lost"]["complete"], "false");

    // A full disk that is noticed only when writing.
    let full = daemon.ctl(&["record", "-o", "/dev/full", "--force", "--duration", "0.01"]);
    full.expect_code(1).expect_err("/dev/full: No space left on device");
}
