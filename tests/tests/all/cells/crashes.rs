//! What is left of a cell that crashed: a report that says what ran and where.

use std::os::unix::fs::PermissionsExt as _;
use std::path::{Path, PathBuf};

use genom_tests::{Daemon, Home, component, request, until};
use minidump::{
    Minidump, MinidumpException, MinidumpModuleList, MinidumpSystemInfo, MinidumpThreadList,
    Module as _,
};
use serde_json::{Value, json};

use super::{cell, load, signal};

/// Where a daemon of a test keeps its reports by default.
fn place(home: &Home) -> PathBuf {
    home.path().join("state/genomd/crashes")
}

/// The report of the crash of a component in a cell of its own, after calling this.
#[track_caller]
fn crash(call: &[&str]) -> Value {
    let daemon = Daemon::start(&[]);
    let mut events = daemon.events();
    load(&daemon, "crashes", &["--name", "broken", "--cell", "arm", "--restart", "never"]);
    daemon.ctl(&[&["call", "broken"], call].concat()).expect_code(1);
    let told = events.wait_for(|e| e["event"] == "cell_crashed");
    assert_eq!(told["cell"], "arm");
    let report = daemon.json(&["crashes", told["report"].as_str().unwrap()]);
    assert_eq!(report["end"], told["end"]);
    assert_eq!(report["codel"], told["codel"]);
    let library = component("crashes").library;
    let words = report["fault"]["words"].as_str().unwrap();
    assert!(words.contains(library.to_str().unwrap()), "{words}");
    assert_eq!(report["fault"]["component"], "broken");
    assert_eq!(report["fault"]["cut"], false, "{report}");
    assert_eq!(report["components"][0]["library"], library.to_str().unwrap());
    report
}

/// Whether a frame is in this function of the library of the component.
#[track_caller]
fn assert_frame(report: &Value, codel: &str) {
    let frames = report["fault"]["frames"].as_array().unwrap();
    let library = component("crashes").library;
    let is = |frame: &&Value| {
        let function = frame["function"].as_str().unwrap_or_default();
        function.starts_with(&format!("{codel}+0x")) && frame["file"] == library.to_str().unwrap()
    };
    assert!(frames.iter().any(|frame| is(&frame)), "{report:#}");
    assert_eq!(report["fault"]["guessed"], false, "{report:#}");
}

#[test]
fn a_report_names_signal_address_codel_activity_and_function() {
    let report = crash(&["segfault"]);
    assert_eq!(report["end"], "signal 11 (SIGSEGV)");
    assert_eq!(report["codel"], "crashes_segfault");
    let fault = &report["fault"];
    assert_eq!((&fault["what"], &fault["address"]), (&json!("SIGSEGV"), &json!("0x0")));
    assert_eq!(fault["owner"], "service segfault");
    assert!(fault["activity"].as_u64().is_some_and(|number| number > 0), "{fault}");
    assert_frame(&report, "crashes_segfault");
    // Where the signal hit comes first.
    let first = fault["frames"][0]["function"].as_str().unwrap();
    assert!(first.starts_with("crashes_segfault+"), "{fault:#}");
}

#[test]
fn a_signal_of_a_fault_that_somebody_sent_ends_the_process_by_this_signal() {
    let daemon = Daemon::start(&[]);
    let mut events = daemon.events();
    load(&daemon, "demo", &["--cell", "arm", "--restart", "never"]);
    signal(&daemon, "arm", "SEGV");
    let told = events.wait_for(|e| e["event"] == "cell_crashed");
    let report = daemon.json(&["crashes", told["report"].as_str().unwrap()]);
    assert_eq!(
        (&report["end"], &report["fault"]["what"]),
        (&json!("signal 11 (SIGSEGV)"), &json!("SIGSEGV"))
    );
}

#[test]
fn the_report_of_a_crash_takes_no_memory_of_the_daemon_for_symbols() {
    let often = "[cells]\nrestart_most = 1000\nrestart_delay = 0.0\nrestart_factor = 1.0\n";
    let daemon = Home::new().configured(often).start(&[]);
    let mut events = daemon.events();
    load(&daemon, "crashes", &["--isolated"]);
    let mut crash = || {
        until("it is back", || daemon.ctl(&["call", "crashes", "segfault"]).code == Some(1));
        let told = events.wait_for(|e| e["event"] == "cell_crashed");
        daemon.json(&["crashes", told["report"].as_str().unwrap()])
    };
    let most = |process: u32| {
        let status = std::fs::read_to_string(format!("/proc/{process}/status")).unwrap();
        let line = status.lines().find(|line| line.starts_with("VmHWM:")).unwrap();
        line.split_whitespace().nth(1).unwrap().parse::<u64>().unwrap()
    };
    let before = most(daemon.process().id());
    // The symbols of the daemon's own program, which called the codel, are read for each.
    let program = genom_tests::program("genomd");
    let report = crash();
    let frames = report["fault"]["frames"].as_array().unwrap();
    let named = |frame: &&Value| {
        frame["file"] == program.to_str().unwrap() && frame["function"].is_string()
    };
    assert!(frames.iter().any(|frame| named(&frame)), "{report:#}");
    for _ in 0..5 {
        crash();
    }
    let grown = most(daemon.process().id()) - before;
    let of_program = std::fs::metadata(&program).unwrap().len() / 1024;
    assert!(grown < of_program / 40, "{grown} KiB more, for a program of {of_program} KiB");
}

#[test]
fn a_report_of_abort_names_the_codel_that_called_it() {
    let report = crash(&["abort"]);
    assert_eq!(report["end"], "signal 6 (SIGABRT)");
    assert_frame(&report, "crashes_abort");
}

#[test]
fn a_report_of_a_function_has_its_inputs() {
    let report = crash(&["divide", "by=0"]);
    assert_eq!(report["end"], "signal 8 (SIGFPE)");
    assert_eq!(report["fault"]["inputs"], json!({"by": 0}));
    assert_eq!(report["fault"]["owner"], "service divide");
    assert_frame(&report, "crashes_divide");
}

#[test]
fn a_report_of_exit_names_the_codel_that_called_it() {
    let report = crash(&["leave"]);
    assert_eq!(report["end"], "exit status 1");
    assert_eq!(report["fault"]["what"], "exit");
    assert_frame(&report, "crashes_leave");
}

#[test]
fn a_killed_cell_is_reported_with_what_was_known_of_it() {
    let often = "[cells]\nrestart_most = 1000\nrestart_delay = 0.0\nrestart_factor = 1.0\n";
    let daemon = Home::new().configured(often).start(&[]);
    let mut events = daemon.events();
    load(&daemon, "demo", &["--isolated"]);
    let mut reported = || {
        let pid = cell(&daemon, "demo")["pid"].clone();
        signal(&daemon, "demo", "KILL");
        let told = events.wait_for(|e| e["event"] == "cell_crashed");
        let report = daemon.json(&["crashes", "1"]);
        assert_eq!((&report["name"], &report["pid"]), (&told["report"], &pid));
        assert_eq!(report["end"], "signal 9 (SIGKILL)");
        until("it is back", || daemon.ctl(&["call", "demo", "get_speed"]).code == Some(0));
        report
    };
    let known = |report: &Value| {
        let component = &report["components"][0];
        component["statistics"]["tasks"][0]["name"] == "main"
            && component["build_id"].is_string()
            && !report["log"].as_array().unwrap().is_empty()
    };
    // Its log is heard, and its tasks are asked, once it runs.
    until("a process lives long enough", || known(&reported()));
    // People get the same in words; a name that is none gets the ones that are.
    let told = |words: &[&str], wanted: &str| {
        let shown = daemon.ctl(words).expect_code(0).out.clone();
        assert!(shown.contains(wanted), "{shown}");
    };
    told(&["crashes", "1"], "cell demo, process ");
    told(&["crashes", "1"], "task main: ");
    told(&["crashes"], "signal 9 (SIGKILL)");
    daemon.ctl(&["crashes", "99"]).expect_code(1).expect_err("no report `99`");
}

#[test]
fn an_end_that_somebody_asked_for_leaves_no_report() {
    let daemon = Daemon::start(&[]);
    for name in ["a", "b"] {
        load(&daemon, "demo", &["--name", name, "--isolated"]);
    }
    daemon.ctl(&["cells", "--restart", "a"]).expect_code(0);
    daemon.ctl(&["cells", "--end", "b"]).expect_code(0);
    daemon.ctl(&["unload", "a"]).expect_code(0);
    assert_eq!(daemon.json(&["crashes"])["crashes"], json!([]));
    let (stopped, home) = daemon.stop("TERM");
    stopped.expect_code(0);
    assert!(!place(&home).exists());
}

#[test]
fn twenty_crashes_leave_no_more_reports_than_the_limit_and_nobody_else_can_read_them() {
    let few = "[cells]\nrestart_most = 100\nrestart_delay = 0.0\nrestart_factor = 1.0\n\
               [crashes]\nmost = 3\n";
    let daemon = Home::new().configured(few).start(&[]);
    load(&daemon, "demo", &["--isolated"]);
    let mut events = daemon.events();
    let mut last = Value::Null;
    for _ in 0..20 {
        signal(&daemon, "demo", "KILL");
        // The report is written while the cell comes back: either may be first.
        let (mut back, mut told) = (false, false);
        while !(back && told) {
            let event =
                events.wait_for(|e| e["event"] == "cell_runs" || e["event"] == "cell_crashed");
            back |= event["event"] == "cell_runs";
            if event["event"] == "cell_crashed" {
                told = true;
                last = event["report"].clone();
            }
        }
    }
    let reports = daemon.json(&["crashes"])["crashes"].as_array().unwrap().clone();
    assert_eq!(reports.len(), 3);
    assert_eq!(reports[0]["name"], last);
    let place = place(daemon.home());
    let mode = |path: &Path| std::fs::metadata(path).unwrap().permissions().mode() & 0o777;
    let mut found = 0;
    for entry in std::fs::read_dir(&place).unwrap() {
        let path = entry.unwrap().path();
        assert_eq!(mode(&path), 0o700, "{}", path.display());
        assert_eq!(mode(&path.join("report.json")), 0o600);
        found += 1;
    }
    assert_eq!((mode(&place), found), (0o700, 3));
}

#[test]
fn a_directory_that_cannot_be_written_is_told_and_nothing_else_is_disturbed() {
    let home = Home::new();
    let file = home.path().join("file");
    std::fs::write(&file, "").unwrap();
    let inside = format!("[crashes]\ndirectory = {:?}\n", file.join("crashes"));
    let daemon = home.configured(&inside).start(&[]);
    load(&daemon, "demo", &["--isolated"]);
    let mut events = daemon.events();
    signal(&daemon, "demo", "KILL");
    events.wait_for(|e| e["event"] == "cell_runs");
    daemon.ctl(&["call", "demo", "get_speed"]).expect_code(0);
    until("it is told", || daemon.ctl(&["logs"]).out.contains("cell demo: no report of its end"));
    assert_eq!(daemon.json(&["crashes"])["crashes"], json!([]));
}

#[test]
fn a_crash_while_no_daemon_is_there_is_reported_by_the_next() {
    let daemon = Home::new().start(&[]);
    load(&daemon, "crashes", &["--isolated"]);
    let pid = cell(&daemon, "crashes")["pid"].to_string();
    let socket = cell(&daemon, "crashes")["socket"].as_str().unwrap().to_owned();
    let home = daemon.abandon();
    let asked = std::thread::spawn(move || {
        let mut stream = std::os::unix::net::UnixStream::connect(socket).unwrap();
        let path = "/components/crashes/services/segfault";
        let head = format!("POST {path} HTTP/1.1\r\nHost: x\r\nContent-Length: 2\r\n\r\n{{}}");
        std::io::Write::write_all(&mut stream, head.as_bytes()).unwrap();
        // Until the process ends.
        let _ = std::io::Read::read_to_end(&mut stream, &mut Vec::new());
    });
    until("it is gone", || !Path::new(&format!("/proc/{pid}/exe")).exists());
    asked.join().unwrap();
    let daemon = home.start(&[]);
    until("it is reported", || daemon.json(&["crashes"])["crashes"] != json!([]));
    let report = daemon.json(&["crashes", "1"]);
    assert_eq!(report["codel"], "crashes_segfault");
    assert_eq!(report["fault"]["what"], "SIGSEGV");
}

#[test]
fn no_name_of_a_report_leads_out_of_their_directory() {
    let daemon = Home::new().start(&[]);
    let place = place(daemon.home());
    std::fs::create_dir_all(&place).unwrap();
    let secret = daemon.home().path().join("state/genomd/crash-secret");
    std::fs::create_dir(&secret).unwrap();
    let report = json!({
        "name": "secret", "time": 0, "cell": "secret", "end": "secret", "genomd": "0",
        "socket": "/", "components": [], "log": [],
    });
    std::fs::write(secret.join("report.json"), report.to_string()).unwrap();
    std::os::unix::fs::symlink(&secret, place.join("crash-link")).unwrap();
    let socket = daemon.home().socket();
    for name in [
        "..%2Fcrash-secret",
        "crash-x%2F..%2F..%2Fcrash-secret",
        "%2e%2e%2fcrash-secret",
        "crash-link",
        "crash-secret%00",
        "crash-%2e%2e",
        "..",
    ] {
        let reply = request(&socket, "GET", &format!("/crashes/{name}"), "");
        assert_eq!(reply.status, 404, "{name}: {:?}", reply.body);
    }
    assert_eq!(daemon.json(&["crashes"])["crashes"], json!([]));
}

#[test]
fn cells_leave_core_dumps_only_where_they_are_asked_for() {
    let limit = |daemon: &Daemon| {
        load(daemon, "demo", &["--isolated"]);
        let pid = cell(daemon, "demo")["pid"].to_string();
        let limits = std::fs::read_to_string(format!("/proc/{pid}/limits")).unwrap();
        let line = limits.lines().find(|line| line.starts_with("Max core file size")).unwrap();
        let mut words = line.split_whitespace().skip(4).map(str::to_owned);
        (words.next().unwrap(), words.next().unwrap())
    };
    // 0 would be for files only: a program that collects crashes would get the memory still.
    let (soft, hard) = limit(&Daemon::start(&[]));
    assert_eq!(soft, if hard == "0" { "0" } else { "1" });
    let (soft, hard) = limit(&Home::new().configured("[crashes]\ncore = true\n").start(&[]));
    assert_eq!(soft, hard);
}

#[test]
fn a_minidump_is_in_the_report_where_it_is_asked_for() {
    let daemon = Home::new().configured("[crashes]\nminidump = true\n").start(&[]);
    let mut events = daemon.events();
    load(&daemon, "crashes", &["--name", "broken", "--cell", "arm"]);
    daemon.ctl(&["call", "broken", "segfault"]).expect_code(1);
    let told = events.wait_for(|e| e["event"] == "cell_crashed");
    let report = daemon.json(&["crashes", told["report"].as_str().unwrap()]);
    assert_eq!(report["fault"]["cut"], false);
    let file = PathBuf::from(report["minidump"].as_str().unwrap());
    assert_eq!(file.parent(), Some(&*place(daemon.home()).join(told["report"].as_str().unwrap())));
    assert_eq!(std::fs::metadata(&file).unwrap().permissions().mode() & 0o777, 0o600);
    let bytes = std::fs::read(&file).unwrap_or_else(|error| panic!("{error}: {report:#}"));
    // The signature of the format, and the thread that crashed among the names of threads.
    assert_eq!(&bytes[..4], b"MDMP");
    let name = report["fault"]["thread"].as_str().unwrap().split_once(' ').unwrap().1;
    let wide: Vec<u8> = name.encode_utf16().flat_map(u16::to_le_bytes).collect();
    assert!(bytes.windows(wide.len()).any(|found| found == wide), "{name}");
    assert_readable(&bytes, &report);
    // It comes back all the same, and one that is killed leaves none.
    until("it is back", || daemon.ctl(&["info", "broken"]).code == Some(0));
    signal(&daemon, "arm", "KILL");
    let told = events.wait_for(|e| e["event"] == "cell_crashed");
    let report = daemon.json(&["crashes", told["report"].as_str().unwrap()]);
    assert_eq!(report["minidump"], Value::Null);
}

/// Reads a minidump as others do: the registers of the thread that crashed, the place of the crash on
/// its stack, and the library of the codel by its build id.
#[track_caller]
fn assert_readable(bytes: &[u8], report: &Value) {
    let dump = Minidump::read(bytes).unwrap();
    let exception = dump.get_stream::<MinidumpException<'_>>().unwrap();
    let thread = exception.get_crashing_thread_id();
    let told = report["fault"]["thread"].as_str().unwrap();
    assert!(told.starts_with(&format!("{thread} ")), "{thread} is not {told}");
    let threads = dump.get_stream::<MinidumpThreadList<'_>>().unwrap();
    assert!(threads.threads.len() > 1);
    let (crashed, system) = (threads.get_thread(thread), dump.get_stream::<MinidumpSystemInfo>());
    let crashed = crashed.unwrap();
    let registers = crashed.context(&system.unwrap(), None).unwrap();
    let memory = dump.get_memory().unwrap_or_default();
    let stack = crashed.stack_memory(&memory).unwrap();
    let (low, at) = (stack.base_address(), registers.get_stack_pointer());
    assert!((low..low + stack.bytes().len() as u64).contains(&at), "{at:#x}");
    let modules = dump.get_stream::<MinidumpModuleList>().unwrap();
    assert!(modules.module_at_address(registers.get_instruction_pointer()).is_some());
    // The kernel put it there when it called the handler of the signal.
    let pc = report["fault"]["frames"][0]["address"].as_str().unwrap();
    let pc = u64::from_str_radix(pc.strip_prefix("0x").unwrap(), 16).unwrap();
    let words = stack.bytes().chunks_exact(8);
    assert!(words.into_iter().any(|word| word == pc.to_le_bytes()), "{pc:#x}");
    let library = modules.module_at_address(pc).expect("the library of the codel");
    assert!(library.code_file().ends_with("crashes.so"), "{}", library.code_file());
    let id = library.code_identifier().map(|id| id.as_str().to_owned());
    assert_eq!(id.as_deref(), report["components"][0]["build_id"].as_str());
}
