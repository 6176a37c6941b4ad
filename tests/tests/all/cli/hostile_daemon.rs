//! Any program may answer on a socket: genomctl shows its replies safely, and does not connect
//! where others could put a socket.

use std::io::{BufRead as _, BufReader, Read as _, Write as _};
use std::os::unix::fs::PermissionsExt as _;
use std::os::unix::net::{UnixListener, UnixStream};
use std::path::Path;
use std::process::Command;

use genom_tests::{Finished, Running, program};
use serde_json::{Value, json};

/// Clears the screen, sets the title, reverses the direction of text, contains invisible
/// characters, and begins a line of its own.
const EVIL: &str = "e\u{1b}[2J\u{1b}]0;owned\u{7}v\u{9b}31mi\u{202e}l\u{200b}\r\u{7f}\nerror: x";

/// A reply with everything that genomctl may read; every text contains `EVIL`.
fn reply(path: &str) -> Value {
    let service = json!({
        "name": EVIL, "kind": EVIL, "doc": EVIL, "task": EVIL, "throws": [EVIL],
        "interrupts": [EVIL], "parameters": [{
            "name": EVIL, "direction": "in", "type": EVIL, "doc": EVIL, "default": EVIL
        }]
    });
    let port = json!({
        "name": EVIL, "component": EVIL, "direction": "out", "multiple": false, "type": EVIL,
        "doc": EVIL, "value": {EVIL: EVIL}, "connected": EVIL, "backend": EVIL
    });
    match path.split('?').next().unwrap() {
        "/components" => json!({"components": [{
            "name": EVIL, "component": EVIL, "state": EVIL, "backend": EVIL, "library": EVIL,
            "port_backends": {EVIL: EVIL}, "activities": 1
        }]}),
        "/components/demo" => json!({
            "name": EVIL, "component": EVIL, "version": EVIL, "doc": EVIL, "backend": EVIL,
            "library": EVIL, "services": [service], "ports": [port], "events": [EVIL],
            "tasks": [{"name": EVIL, "period": 1.0}]
        }),
        "/logs" => json!({"logs": [
            {"id": 1, "time": 0.5, "level": EVIL, "component": EVIL, "message": EVIL}
        ]}),
        "/daemons" => json!({"own": EVIL, "daemons": [{"name": EVIL, "backend": EVIL}]}),
        "/components/demo/services/get" => json!({"result": {EVIL: EVIL}}),
        _ => json!({"error": {"code": "x", "message": EVIL, "where": EVIL, "help": EVIL}}),
    }
}

fn answer(stream: UnixStream) -> std::io::Result<()> {
    let mut reader = BufReader::new(stream.try_clone()?);
    let mut first = String::new();
    reader.read_line(&mut first)?;
    let (mut line, mut length) = (String::new(), 0);
    while reader.read_line(&mut line)? > 2 {
        let lower = line.to_lowercase();
        if let Some(value) = lower.strip_prefix("content-length:") {
            length = value.trim().parse().unwrap_or(0);
        }
        line.clear();
    }
    reader.take(length).read_to_end(&mut Vec::new())?;
    let path = first.split(' ').nth(1).unwrap_or_default();
    let mut stream = stream;
    if path.contains("/stream") || path.starts_with("/events") {
        let data = json!({"event": EVIL, EVIL: EVIL}).to_string();
        let kind = if path.starts_with("/events") { "change" } else { "value" };
        write!(stream, "HTTP/1.1 200 OK\r\nContent-Type: text/event-stream\r\n\r\n")?;
        return write!(stream, "event: {kind}\nid: 1\ndata: {data}\n\n");
    }
    let body = reply(path);
    let status = if body.get("error").is_some() { "409 Conflict" } else { "200 OK" };
    let body = body.to_string();
    write!(stream, "HTTP/1.1 {status}\r\nContent-Length: {}\r\n\r\n{body}", body.len())
}

/// Listens on a socket, and answers as a program that is not genomd.
fn listen(socket: &Path) {
    let listener = UnixListener::bind(socket).unwrap();
    std::thread::spawn(move || {
        for stream in listener.incoming().flatten() {
            // A client that disconnects early is no error of the test.
            let _ = answer(stream);
        }
    });
}

fn ctl(socket: &Path, arguments: &[&str]) -> Finished {
    let mut command = Command::new(program("genomctl"));
    command.env_clear().arg("--socket").arg(socket).args(arguments);
    Running::start(&mut command).finish()
}

fn obeyed(c: char) -> bool {
    c != '\n' && c.is_control() || matches!(c, '\u{200b}'..='\u{200f}' | '\u{202a}'..='\u{202e}')
}

#[test]
fn a_terminal_is_told_nothing_by_names_docs_values_and_messages() {
    let scratch = tempfile::tempdir().unwrap();
    let socket = scratch.path().join("evil.sock");
    listen(&socket);
    let verbs: [&[&str]; 10] = [
        &["list"],
        &["info", "demo"],
        &["logs"],
        &["daemons"],
        &["call", "demo", "get"],
        &["echo", "demo/position", "-n", "1"],
        &["events", "-n", "1"],
        &["abort", "demo", "goto"],
        &["connect", "a/b", "c/d"],
        &["why", "demo/position"],
    ];
    for verb in verbs {
        let shown = ctl(&socket, verb);
        let text = format!("{}{}", shown.out, shown.err);
        assert!(!text.contains(obeyed), "{verb:?}: {text:?}");
        assert!(text.contains("u{9b}31m") || text.contains("u009b31m"), "{verb:?}: {text:?}");
        // With --json the value is unchanged and just as harmless.
        let told = ctl(&socket, &[&["--json"], verb].concat());
        let text = if told.code == Some(0) { &told.out } else { &told.err };
        assert!(!text.contains(obeyed), "{verb:?}: {text:?}");
        for line in text.lines() {
            serde_json::from_str::<Value>(line).expect("JSON");
        }
    }
    let listed: Value = serde_json::from_str(&ctl(&socket, &["--json", "list"]).out).unwrap();
    assert_eq!(listed, reply("/components"));
    // A row remains one line.
    assert_eq!(ctl(&socket, &["list"]).out.lines().count(), 2);
}

#[test]
fn a_socket_that_others_may_have_put_there_is_not_asked() {
    let scratch = tempfile::tempdir().unwrap();
    let directory = scratch.path().join("open");
    std::fs::create_dir(&directory).unwrap();
    let socket = directory.join("genomd.sock");
    listen(&socket);
    let mode = |mode| {
        std::fs::set_permissions(&directory, std::fs::Permissions::from_mode(mode)).unwrap();
    };
    ctl(&socket, &["list"]).expect_code(0);
    mode(0o777);
    let refused = ctl(&socket, &["list"]);
    refused.expect_code(2).expect_out("").expect_err("others may put files into its directory");
    refused.expect_err("--socket");
    // As in /tmp: others may add files but not replace existing ones.
    mode(0o1777);
    ctl(&socket, &["list"]).expect_code(0);
}
