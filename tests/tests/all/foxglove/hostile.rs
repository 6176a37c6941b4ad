//! What strangers send, and how much, harms neither the robot nor other clients.

use std::io::Write as _;
use std::net::TcpStream;

use genom_tests::Daemon;
use serde_json::json;

use super::raw::Raw;
use super::visitor::{CALL, Client, demo};

/// A client as honest as any is served, and so is the control plane.
#[track_caller]
fn all_is_well(daemon: &Daemon, address: &str) {
    let mut client = Client::new(daemon, address);
    client.of_name("subscribe", "/demo/position");
    let answer = client.ask("call", &[json!("/demo/goto"), json!({"goal": 0.05})]);
    assert!(answer["result"]["activity"].is_u64(), "{answer}");
    client.ask("sample", &[json!("/demo/position"), json!({"position": 0.05})]);
    assert_eq!(client.ask("errors", &[]), json!([]));
    daemon.ctl(&["start", "--wait", "demo", "goto", "goal=0"]).expect_code(0);
}

#[test]
fn nonsense_is_answered_and_much_of_it_ends_the_connection() {
    let (daemon, address) = demo(CALL, &[]);
    let deep = "[".repeat(100_000);
    let many =
        json!({"op": "subscribe", "subscriptions": vec![json!({"id": 1, "channelId": 900}); 9000]});
    for text in [
        "",
        "{",
        "null",
        "{\"op\":\"drive\"}",
        "{\"op\":\"subscribe\"}",
        "{\"op\":\"subscribe\",\"subscriptions\":[{\"id\":-1,\"channelId\":1e99}]}",
        "{\"op\":\"advertise\",\"channels\":[{\"id\":1,\"topic\":\"\\u0000\",\"encoding\":\"json\",\"schemaName\":\"\"}]}",
        "{\"op\":\"setParameters\",\"parameters\":[{\"name\":\"/demo/set_speed/velocity\"}]}",
        "{\"op\":\"fetchAsset\",\"uri\":\"file:///etc/passwd\",\"requestId\":1}",
        "{\"op\":\"playbackControlRequest\"}",
        &deep,
        &many.to_string(),
    ] {
        let (mut raw, _) = Raw::greet(&address, "/", &[]);
        raw.frame(1, text.len() as u64, text.as_bytes()).unwrap();
        // It is told what is wrong, and served on.
        raw.frame(1, 1, b"{").unwrap();
        let told = raw.hears("\"level\":2", 2);
        assert!(!told.contains("root:"), "{told}");
    }
    for bytes in [
        &[][..],
        &[0],
        &[1],
        &[1, 0, 0],
        &[2, 1, 0, 0, 0],
        &[3; 40],
        &[255; 4096],
        &[2, 1, 0, 0, 0, 1, 0, 0, 0, 255, 255, 255, 255, b'j'],
    ] {
        let (mut raw, _) = Raw::greet(&address, "/", &[]);
        raw.frame(2, bytes.len() as u64, bytes).unwrap();
        raw.frame(8, 0, &[]).unwrap();
        raw.closed();
    }
    let (mut raw, _) = Raw::greet(&address, "/", &[]);
    for _ in 0..100 {
        if raw.frame(1, 1, b"{").is_err() {
            break;
        }
    }
    let sent = String::from_utf8_lossy(&raw.closed()).into_owned();
    assert!(sent.contains("too many messages that are none of the protocol"), "{sent}");
    all_is_well(&daemon, &address);
}

#[test]
fn frames_that_break_the_rules_or_are_huge_end_the_connection_only() {
    let (daemon, address) = demo(CALL, &[]);
    // Lengths that are only said: nothing is reserved for them.
    for length in [2 << 20, 1 << 40, u64::MAX] {
        let (mut raw, _) = Raw::greet(&address, "/", &[]);
        raw.frame(2, length, &[1; 1000]).unwrap();
        raw.closed();
    }
    // One that is sent: it may be refused while it is.
    let (mut raw, _) = Raw::greet(&address, "/", &[]);
    let _ = raw.frame(2, 8 << 20, &vec![1; 8 << 20]);
    raw.closed();
    for bytes in [
        &[0x81, 0x01, b'x'][..],               // not masked
        &[0xF1, 0x80, 0, 0, 0, 0],             // reserved bits
        &[0x83, 0x80, 0, 0, 0, 0],             // reserved kind
        &[0x80, 0x80, 0, 0, 0, 0],             // a continuation of nothing
        &[0x89, 0xFE, 1, 0, 0, 0, 0, 0],       // a long ping
        &[0x81, 0x82, 0, 0, 0, 0, 0xC3, 0x28], // no UTF-8
    ] {
        let (mut raw, _) = Raw::greet(&address, "/", &[]);
        raw.0.write_all(bytes).unwrap();
        let _ = raw.frame(8, 0, &[]);
        raw.closed();
    }
    // Pieces of a message without end.
    let (mut raw, _) = Raw::greet(&address, "/", &[]);
    let piece = [&[0x02, 0xFE, 0x7F, 0xFF, 0, 0, 0, 0][..], &[1; 0x7FFF]].concat();
    let next = [&[0x00][..], &piece[1..]].concat();
    let mut sent = raw.0.write_all(&piece);
    for _ in 0..1000 {
        if sent.is_err() {
            break;
        }
        sent = raw.0.write_all(&next);
    }
    assert!(sent.is_err(), "32 MB in one message were taken");
    all_is_well(&daemon, &address);
}

#[test]
fn a_thousand_connections_keep_nobody_out() {
    let (daemon, address) = demo(CALL, &[]);
    let connect = |_| TcpStream::connect(&address);
    // Some say nothing, some half of a request, some ask for more clients than there may be.
    let silent: Vec<_> = (0..400).map(connect).collect();
    let mut half: Vec<_> = (0..400).map(connect).collect();
    for stream in half.iter_mut().flatten() {
        let _ = stream.write_all(b"GET / HTTP/1.1\r\nHost: 127.0.0.1\r\nUpgr");
    }
    let mut refused = 0;
    let mut seated = Vec::new();
    for _ in 0..200 {
        let (raw, reply) = Raw::greet(&address, "/", &[]);
        refused += usize::from(reply.starts_with("HTTP/1.1 503 "));
        if reply.starts_with("HTTP/1.1 101 ") {
            seated.push(raw);
        }
    }
    assert_eq!((seated.len(), refused), (8, 192));
    daemon.ctl(&["start", "--wait", "demo", "goto", "goal=0.1"]).expect_code(0);
    drop(seated);
    genom_tests::until("there is room", || {
        Raw::greet(&address, "/", &[]).1.starts_with("HTTP/1.1 101 ")
    });
    all_is_well(&daemon, &address);
    drop((silent, half));
}

#[test]
fn a_client_that_never_reads_costs_no_more_than_its_backlog_and_others_nothing() {
    let (daemon, address) = demo(&format!("{CALL}\nbacklog = 65536"), &[]);
    let (mut stalled, reply) = Raw::greet(&address, "/", &[]);
    assert!(reply.starts_with("HTTP/1.1 101 "));
    let mut client = Client::new(&daemon, &address);
    client.of_name("subscribe", "/demo/position");
    // It asks for more and more announcements, and takes none.
    let message = json!({"op": "getParameters", "parameterNames": [], "id": "x".repeat(1000)});
    let message = message.to_string();
    let subscribe = json!({"op": "subscribe", "subscriptions": [{"id": 1, "channelId": 1}]});
    let subscribe = subscribe.to_string();
    stalled.frame(1, subscribe.len() as u64, subscribe.as_bytes()).unwrap();
    stalled.0.set_write_timeout(Some(std::time::Duration::from_secs(30))).unwrap();
    let mut sent = 0;
    while stalled.frame(1, message.len() as u64, message.as_bytes()).is_ok() {
        sent += 1;
        if sent % 100 == 0 {
            // Others are served meanwhile.
            let answer = client.ask("call", &[json!("/demo/get_speed"), json!({})]);
            assert_eq!(answer["result"]["velocity"], 0.5);
        }
        assert!(sent < 100_000, "it may send without end");
    }
    daemon.ctl(&["start", "--wait", "demo", "goto", "goal=0.2"]).expect_code(0);
    client.ask("sample", &[json!("/demo/position"), json!({"position": 0.2})]);
    drop(stalled);
    all_is_well(&daemon, &address);
}
