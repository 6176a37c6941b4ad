//! Bad input: the message names what is wrong, and nothing changes.

use std::io::{Read as _, Write as _};

use genom_tests::{Daemon, Home, component, connect, path, request};
use serde_json::json;

#[test]
fn a_syntax_error_is_drawn_with_what_was_expected() {
    let home = Home::new();
    let text = "component demo {\n  task main { period 5 ms };\n};\n";
    std::fs::write(home.path().join("demo.gen"), text).unwrap();
    let demo = component("demo");
    let refused = home.refused(&["--gen", "demo.gen", path(&demo.library)]);
    refused.expect_code(1);
    for wanted in ["error[E0", "demo.gen:2:27", "task main { period 5 ms };", "^", "`;`"] {
        refused.expect_err(wanted);
    }
}

#[test]
fn an_unknown_backend_lists_the_known_ones() {
    let home = Home::new();
    let demo = component("demo");
    let refused = home.refused(&["--backend", "smh", path(&demo.library)]);
    refused.expect_code(2).expect_err("unknown backend `smh` (did you mean `shm`?)");
    refused.expect_err("This daemon knows: local, shm, zenoh, ros2");
    assert!(!home.socket().exists());
}

#[test]
fn two_components_of_one_name_are_refused() {
    let home = Home::new();
    let demo = component("demo");
    let refused = home.refused(&["--backend", "shm", path(&demo.library), path(&demo.library)]);
    refused.expect_code(1).expect_err("a component named demo runs already");
    refused.expect_err("--name");
    // The first component was running; it was stopped, and nothing remains.
    assert!(!home.socket().exists());
    assert_eq!(home.memory().files(), Vec::<std::path::PathBuf>::new());

    let daemon = Daemon::demo("local");
    let library = path(&demo.library);
    daemon.ctl(&["load", library]).expect_code(1).expect_err("a component named demo runs");
    daemon.ctl(&["load", library, "--name", "other"]).expect_code(0);
    daemon.ctl(&["load", library, "--name", "o/her"]).expect_code(1).expect_err("cannot name");
    assert_eq!(daemon.json(&["list"])["components"].as_array().unwrap().len(), 2);
}

#[test]
fn a_component_without_its_other_half_is_refused() {
    let home = Home::new();
    home.refused(&["nothing.gen"]).expect_code(1).expect_err("nothing.gen: no such description");
    home.refused(&["nothing.so"]).expect_code(1).expect_err("no library for nothing.so");
    std::fs::write(home.path().join("text.so"), "no library").unwrap();
    home.refused(&["text.so"]).expect_code(1).expect_err("no library: it looks like text");
    std::fs::write(home.path().join("alone.gen"), "component alone {};\n").unwrap();
    home.refused(&["alone.gen"]).expect_code(1).expect_err("libalone_codels.so");
}

#[test]
fn a_library_without_a_codel_names_it_and_the_line() {
    let home = Home::new();
    let demo = component("demo");
    let text = std::fs::read_to_string(&demo.description).unwrap();
    let text = text.replace("demo_brake(", "demo_halt_now(");
    std::fs::write(home.path().join("demo.gen"), text).unwrap();
    let refused = home.refused(&["--gen", "demo.gen", path(&demo.library)]);
    refused.expect_code(1).expect_err("demo_halt_now").expect_err("demo.gen:");
}

#[test]
fn wrong_usage_has_its_own_status() {
    let home = Home::new();
    home.refused(&["--nonsense"]).expect_code(2);
    home.refused(&["--name", "x"]).expect_code(2).expect_err("--name goes with exactly one");
    let tokens = ["--token-file", "tokens.toml", "--listen"];
    let refused = home.refused(&[&tokens[..], &["0.0.0.0:0"]].concat());
    refused.expect_code(2).expect_err("can be reached from outside: it needs TLS");
    home.refused(&["--listen", "127.0.0.1:0"]).expect_code(2).expect_err("--token-file FILE");
    let refused = home.refused(&[&tokens[..], &["127.0.0.1:0"]].concat());
    refused.expect_code(2).expect_err("genomctl token NAME --into");
    std::fs::write(home.path().join("tokens.toml"), "").unwrap();
    let refused = home.refused(&[&tokens[..], &["127.0.0.1:0"]].concat());
    refused.expect_code(2).expect_err("others may read").expect_err("chmod 600");
    home.refused(&["--log", "=/="]).expect_code(2).expect_err("--log");
    std::fs::write(home.path().join("genomd.toml"), "backedn = \"shm\"\n").unwrap();
    let refused = home.refused(&[]);
    refused.expect_code(2).expect_err("genomd.toml:1: unknown field `backedn`");
    refused.expect_err("did you mean `backend`?");
}

#[test]
fn wrong_inputs_are_named_and_change_nothing() {
    let daemon = Daemon::demo("local");
    let call = |inputs| daemon.ctl(&["call", "demo", "set_speed", inputs]);
    let refused = call(r#"{"velocty":1.0}"#);
    refused
        .expect_code(1)
        .expect_err("service set_speed has no input `velocty`; did you mean `velocity`?");
    let refused = call(r#"{"velocity":"fast"}"#);
    refused.expect_code(1).expect_err("velocity: expected").expect_err("the string \"fast\"");
    let socket = daemon.home().socket();
    let post = |body| request(&socket, "POST", "/components/demo/services/set_speed", body);
    let reply = post(r#"{"velocity":[]}"#);
    assert_eq!((reply.status, reply.code()), (422, "bad_input"), "{reply:?}");
    assert_eq!(reply.body["error"]["where"], "/velocity");
    assert_eq!(post("{").status, 400);
    assert_eq!(post("[1]").status, 422);
    let reply =
        request(&socket, "POST", "/components/demo/services/abort_activity", r#"{"activity":-1}"#);
    assert_eq!(reply.status, 422);
    assert!(reply.body["error"]["message"].as_str().unwrap().contains("out of range"));
    daemon.ctl(&["call", "demo", "get_speed"]).expect_out("velocity = 0.5\n");
}

#[test]
fn a_wrong_name_suggests_the_nearest() {
    let daemon = Daemon::demo("local");
    for (arguments, message, help) in [
        (&["info", "dmo"][..], "no component `dmo`", "did you mean `demo`?"),
        (&["call", "demo", "gto"], "demo has no service `gto`", "did you mean `goto`?"),
        (&["echo", "demo/positon"], "demo has no port `positon`", "did you mean `position`?"),
        (&["fire", "demo", "emergancy"], "demo has no event `emergancy`", "`emergency`?"),
        (&["wait", "demo", "99"], "demo has no activity `99`", "ended long ago"),
        (&["connect", "demo/parametr", "x/y"], "demo has no port `parametr`", "`parameter`?"),
        (&["connect", "demo/position", "x/y"], "demo/position is an out port", "parameter"),
        (&["load", "nothing"], "no library for nothing", ""),
    ] {
        let refused = daemon.ctl(arguments);
        refused.expect_code(1).expect_out("").expect_err(message).expect_err(help);
    }
    daemon.ctl(&["lst"]).expect_code(2).expect_err("list");
    daemon.ctl(&["call", "demo", "goto", "goal"]).expect_code(2).expect_err("key=value");
}

#[test]
fn every_refusal_of_the_control_plane_has_one_shape() {
    let daemon = Daemon::demo("local");
    let socket = daemon.home().socket();
    for (method, path, body, status, code) in [
        ("GET", "/nothing", "", 404, "no_such_path"),
        ("GET", "/components/x", "", 404, "no_such_component"),
        ("PUT", "/components", "", 405, "no_such_method"),
        ("POST", "/components/demo/services/goto?wiat=true", "{}", 400, "bad_query"),
        ("GET", "/components/demo/activities/1?wait=-3", "", 404, "no_such_activity"),
        ("GET", "/components/demo/ports/position/stream?rate=0", "", 422, "bad_input"),
        ("GET", "/components/demo/ports/position?element=a", "", 422, "bad_input"),
        ("POST", "/connections", r#"{"in":"demo/parameter"}"#, 422, "bad_input"),
        ("DELETE", "/connections/demo/parameter", "", 409, "not_connected"),
        ("POST", "/components", r#"{"libary":"x"}"#, 422, "bad_input"),
    ] {
        let reply = request(&socket, method, path, body);
        assert_eq!((reply.status, reply.code()), (status, code), "{method} {path}: {reply:?}");
        assert!(reply.body["error"]["message"].is_string(), "{reply:?}");
    }
    // A body that is too large is refused before it is sent; without a declared length it is cut
    // off.
    let lengths = ["Content-Length: 2000000", "Transfer-Encoding: chunked"];
    for (length, sent) in lengths.into_iter().zip([0, 2_000_000]) {
        let mut stream = connect(&socket);
        let head = format!("POST /components HTTP/1.1\r\nHost: x\r\n{length}\r\n\r\n");
        stream.write_all(head.as_bytes()).unwrap();
        let chunk = format!("{sent:x}\r\n{}", " ".repeat(sent));
        // The daemon hangs up before it has read everything.
        let _ = stream.write_all(if sent > 0 { chunk.as_bytes() } else { b"" });
        let mut status = [0; 12];
        stream.read_exact(&mut status).unwrap();
        assert_eq!(&status, b"HTTP/1.1 413", "{length}");
    }
    let reply = request(&socket, "POST", "/components", r#"{"libary":"x"}"#);
    assert_eq!(reply.body["error"]["help"], "did you mean `library`?");
}

#[test]
fn random_bytes_on_the_socket_do_not_disturb() {
    let daemon = Daemon::demo("local");
    let waiting = daemon.spawn(&["start", "--wait", "demo", "goto", "goal=0.2"]);
    // A fixed seed, so that failures can be reproduced.
    let mut state = 0x9e37_79b9_7f4a_7c15_u64;
    let mut half_open = Vec::new();
    for round in 0..200_usize {
        let bytes: Vec<u8> = (0..round * 7 % 900)
            .map(|_| {
                state ^= state << 13;
                state ^= state >> 7;
                state ^= state << 17;
                state.to_le_bytes()[0]
            })
            .collect();
        let mut stream = connect(&daemon.home().socket());
        // The daemon may hang up in the middle.
        let _ = stream.write_all(if round % 3 == 0 { b"POST / HTTP/1.1\r\n" } else { &bytes });
        if round % 5 == 0 {
            half_open.push(stream);
        }
    }
    waiting.finish().expect_code(0);
    let listed = daemon.json(&["list"]);
    assert_eq!(listed["components"][0]["state"], "running");
    let stats = daemon.json(&["stats", "demo"]);
    assert!(stats["tasks"][0]["cycles"]["count"].as_u64().unwrap() > 0);
    drop(half_open);
}

#[test]
fn pages_of_the_web_are_not_served() {
    let home = Home::new();
    let daemon = home.start(&[]);
    let mut stream = connect(&daemon.home().socket());
    write!(
        stream,
        "POST /shutdown HTTP/1.1\r\nHost: x\r\nOrigin: http://evil.example\r\n\
        Connection: close\r\nContent-Length: 0\r\n\r\n"
    )
    .unwrap();
    let mut reply = String::new();
    stream.read_to_string(&mut reply).unwrap();
    assert!(reply.starts_with("HTTP/1.1 403"), "{reply}");
    daemon.ctl(&["list"]).expect_code(0);
}

#[test]
fn a_client_without_a_daemon_says_how_to_start_one() {
    let home = Home::new();
    let daemon = home.start(&[]);
    let (stopped, home) = daemon.stop("TERM");
    stopped.expect_code(0);
    let mut command = std::process::Command::new(genom_tests::program("genomctl"));
    command.arg("--socket").arg(home.socket()).args(["--json", "list"]);
    let finished = genom_tests::Running::start(&mut command).finish();
    finished.expect_code(3).expect_out("").expect_err("genomd LIBRARY");
    let error: serde_json::Value = serde_json::from_str(&finished.err).unwrap();
    assert_eq!(error["error"]["code"], json!("unreachable"));
}
