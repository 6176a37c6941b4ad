//! `genomctl bench`: one deployment on several middlewares.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use genom_tests::{Running, component, path, program, repository, until};
use serde_json::Value;
use tempfile::TempDir;

/// A place for the mission's deployment and for what is made of it.
struct Place(TempDir);

impl Place {
    fn new() -> Self {
        let place = Self(TempDir::new().unwrap());
        let mission = fs::read_to_string(repository().join("configs/mission.toml")).unwrap();
        let folder = |name: &str| component(name).library.parent().unwrap().to_owned();
        let paths = format!("path = [{:?}, {:?}]", folder("demo"), folder("mission"));
        let text: Vec<&str> = mission
            .lines()
            .map(|line| if line.starts_with("path = ") { paths.as_str() } else { line })
            .collect();
        // The axis tells where it is while it moves, and it moves slowly.
        let moves = r#"
            [[call]]
            component = "demo"
            service = "set_speed"
            inputs = { velocity = 0.001 }

            [[activity]]
            component = "demo"
            service = "goto"
            inputs = { goal = 1.0 }
        "#;
        fs::write(place.path("mission.toml"), text.join("\n") + moves).unwrap();
        fs::create_dir(place.path("tmp")).unwrap();
        place
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    /// Compares in this directory; nothing of the user's is used.
    fn bench(&self, arguments: &[&str]) -> Running {
        let mut command = Command::new(program("genomctl"));
        command.env_clear().env("PATH", std::env::var_os("PATH").unwrap_or_default());
        command.env("TMPDIR", self.path("tmp")).env("XDG_STATE_HOME", self.path("state"));
        command.env("XDG_CONFIG_HOME", self.path("config")).current_dir(self.0.path());
        command.args(["--json", "bench", "mission.toml", "--genomd"]).arg(program("genomd"));
        Running::start(command.args(["--warm-up", "0.5"]).args(arguments))
    }

    /// What of a comparison is left: its files, its shared memory, its processes.
    fn left(&self, process: u32) -> Vec<String> {
        let names = |directory: &Path| -> Vec<String> {
            let all = fs::read_dir(directory).into_iter().flatten().flatten();
            all.map(|entry| entry.file_name().to_string_lossy().into_owned()).collect()
        };
        let mut left = names(&self.path("tmp"));
        let mine = format!("gbench{process}n");
        left.extend(names(Path::new("/dev/shm")).into_iter().filter(|name| name.contains(&mine)));
        let tmp = path(&self.path("tmp")).to_owned();
        left.extend(names(Path::new("/proc")).into_iter().filter(|name| {
            let words = fs::read(format!("/proc/{name}/cmdline")).unwrap_or_default();
            String::from_utf8_lossy(&words).contains(&tmp)
        }));
        left
    }
}

fn json(text: &str) -> Value {
    serde_json::from_str(text).unwrap_or_else(|error| panic!("{error}: {text}"))
}

/// The connection into a port, in a way.
fn into<'a>(way: &'a Value, inport: &str) -> &'a Value {
    let all = way["connections"].as_array().unwrap();
    all.iter().find(|one| one["in"] == inport).unwrap_or_else(|| panic!("no {inport}: {way}"))
}

fn number(of: &Value, key: &str) -> u64 {
    of[key].as_u64().unwrap_or_else(|| panic!("no {key}: {of}"))
}

/// What holds of every connection whatever the machine does meanwhile.
fn consistent(one: &Value) {
    let recorded = &one["recorded"];
    let [sent, received, skipped, alike] =
        ["sent", "received", "skipped", "alike"].map(|key| number(recorded, key));
    assert_eq!(sent, received + skipped, "{one}");
    assert!(alike <= received, "{one}");
    assert_eq!(one["latency_us"].is_null(), received == 0, "{one}");
    if received > 0 {
        for key in ["p50", "p99"] {
            let of = |what: &str| one[what][key].as_f64().unwrap();
            assert!(0.0 <= of("hop_us") && of("hop_us") <= of("latency_us"), "{one}");
        }
    }
}

#[test]
fn a_deployment_is_compared_on_all_middlewares_and_a_mix() {
    let place = Place::new();
    let bench = place.bench(&[
        "--backends",
        "local,shm,zenoh,ros2",
        "--mix",
        "shm: demo/position=zenoh",
        "--seconds",
        "1",
        "--no-floor",
        "--save",
        "run.json",
        "--svg",
        "run.svg",
    ]);
    let process = bench.id();
    let finished = bench.finish();
    finished.expect_code(0);
    let report = json(&finished.out);
    let ways = report["ways"].as_array().unwrap();
    let names: Vec<&str> = ways.iter().map(|way| way["way"].as_str().unwrap()).collect();
    assert_eq!(names, ["local", "shm", "zenoh", "ros2", "shm: demo/position=zenoh"]);
    for way in ways {
        assert!(way["error"].is_null(), "{way}");
        assert!(number(way, "memory_bytes") > 0 && way["cpu_percent"].as_f64().is_some(), "{way}");
        let backend = |inport: &str| into(way, inport)["backend"].as_str().unwrap();
        let expected = match way["way"].as_str().unwrap() {
            "shm: demo/position=zenoh" => ("zenoh", "shm"),
            one => (one, one),
        };
        assert_eq!((backend("mission/position"), backend("demo/parameter")), expected);
        way["connections"].as_array().unwrap().iter().for_each(consistent);
        // Both tasks run 200 times a second; without a network nothing else has to come about.
        if ["local", "shm"].contains(&way["way"].as_str().unwrap()) {
            let position = into(way, "mission/position");
            assert!(number(position, "written") > 0 && number(position, "read") > 0, "{way}");
            assert!(number(&position["recorded"], "received") > 0, "{way}");
            assert_eq!(position["sample_bytes"], 16.0);
        }
        let gateway = expected.0 != "local" && expected.0 != "shm";
        assert!(number(way, "processes") >= if gateway { 2 } else { 1 }, "{way}");
    }
    assert_eq!(json(&fs::read_to_string(place.path("run.json")).unwrap()), report);
    let mut read = Command::new("python3");
    read.args(["-c", "import sys, xml.dom.minidom as x; x.parse(sys.argv[1])"]);
    Running::start(read.arg(place.path("run.svg"))).finish().expect_code(0);
    let drawn = fs::read_to_string(place.path("run.svg")).unwrap();
    assert!(names.iter().all(|name| drawn.contains(&format!(">{name}<"))), "{drawn}");
    assert_eq!(place.left(process), [""; 0]);
}

#[test]
fn bare_middlewares_are_measured_beside_components_in_processes_of_their_own() {
    let place = Place::new();
    let bench = place.bench(&["--isolated", "--backends", "shm", "--seconds", "0.5"]);
    let process = bench.id();
    let finished = bench.finish();
    finished.expect_code(0);
    let way = &json(&finished.out)["ways"][0];
    assert!(number(way, "processes") >= 3, "the daemon and a cell for each component: {way}");
    for inport in ["mission/position", "demo/parameter"] {
        let one = into(way, inport);
        consistent(one);
        assert!(one["floor_error"].is_null(), "{one}");
        let floor = &one["floor_us"];
        assert!(number(floor, "values") > 0 && floor["p50"].as_f64() > Some(0.0), "{one}");
    }
    assert_eq!(place.left(process), [""; 0]);
}

#[test]
fn a_way_that_cannot_run_is_listed_with_its_reason_and_the_others_run() {
    let place = Place::new();
    let mixes = ["nothing", "local: demo/nowhere=shm", "shm: screen/image=zenoh"];
    let mixes = mixes.iter().flat_map(|mix| ["--mix", mix]);
    let common = ["--backends", "local", "--seconds", "0.2", "--no-floor"];
    let finished = place.bench(&common.into_iter().chain(mixes).collect::<Vec<_>>()).finish();
    finished.expect_code(1);
    assert!(finished.err.contains("3 of 4 ways did not run"), "{}", finished.err);
    let report = json(&finished.out);
    let error = |rank: usize| report["ways"][rank]["error"].as_str().unwrap_or_default().to_owned();
    assert_eq!(error(0), "");
    assert!(number(into(&report["ways"][0], "mission/position"), "written") > 0, "{report}");
    assert!(error(1).contains("unknown backend `nothing`"), "{report}");
    assert!(error(2).contains("nowhere"), "{report}");
    assert_eq!(error(3), "the deployment has no component `screen`; it has demo, mission");

    fs::write(place.path("mission.toml"), "backnd = 1").unwrap();
    let finished = place.bench(&[]).finish();
    finished.expect_code(2);
    assert!(finished.err.contains("did you mean `backend`?"), "{}", finished.err);
}

#[test]
fn an_interrupted_comparison_leaves_nothing_behind() {
    let place = Place::new();
    let bench = place.bench(&["--backends", "shm", "--isolated", "--seconds", "600"]);
    let process = bench.id();
    until("its daemon runs", || {
        let all = fs::read_dir(place.path("tmp")).unwrap().flatten();
        all.map(|entry| entry.path().join("genomd.sock")).any(|socket| socket.exists())
    });
    bench.signal("INT");
    let finished = bench.finish();
    finished.expect_code(1);
    assert!(finished.err.contains("interrupted"), "{}", finished.err);
    assert_eq!(place.left(process), [""; 0]);
}

#[test]
fn the_measurement_of_a_bare_middleware_ends_with_its_input() {
    let made = TempDir::new().unwrap();
    let place = made.path().join(format!("input{}", std::process::id()));
    fs::create_dir(&place).unwrap();
    for name in ["local", "shm"] {
        // Three weeks, if its input did not end at once.
        let mut command = Command::new(program("genomd"));
        command.args(["--floor", name, path(&place), "64", "1000000", "2000000000"]);
        let finished = Running::start(&mut command).finish();
        finished.expect_code(1);
        assert_eq!((finished.err.trim(), finished.out.as_str()), ("interrupted", ""));
    }
    let mine = format!("bareinput{}_", std::process::id());
    let left = fs::read_dir("/dev/shm").unwrap().flatten().map(|entry| entry.path());
    let left: Vec<PathBuf> = left.filter(|path| path.to_string_lossy().contains(&mine)).collect();
    // iceoryx2 leaves the segment in which it counts nodes: `genomctl bench` removes it.
    left.iter().for_each(|path| fs::remove_file(path).unwrap());
    let counts = |path: &PathBuf| path.to_string_lossy().ends_with(".global_mgmt");
    assert!(left.iter().all(counts), "{left:?}");
}
