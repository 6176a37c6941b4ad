//! Runs `examples/two_routes.rs`: a router without checks of its own, behind a door.

#![allow(clippy::unwrap_used, reason = "helpers fail tests")]

use std::net::SocketAddr;
use std::os::unix::fs::PermissionsExt as _;
use std::path::Path;
use std::time::Duration;

use genom_doors::{Most, serve};
use tokio::io::{AsyncReadExt as _, AsyncWriteExt as _};
use tokio::net::TcpStream;
use tokio_util::sync::CancellationToken;

#[path = "../examples/two_routes.rs"]
#[allow(dead_code, unreachable_pub, reason = "a program, whose parts are tried here")]
mod two_routes;

const WATCHDOG: Duration = Duration::from_secs(60);

/// A file with one token for each of these rights, named after it.
fn tokens(at: &Path, rights: &[&str]) {
    let entry = |right: &&str| {
        format!("[[token]]\nname = \"{right}\"\ntoken = \"{right:-<32}\"\nrights = [\"{right}\"]\n")
    };
    std::fs::write(at, rights.iter().map(entry).collect::<String>()).unwrap();
    std::fs::set_permissions(at, std::fs::Permissions::from_mode(0o600)).unwrap();
}

/// The complete reply to a request with the token for this right.
async fn asked(address: SocketAddr, line: &str, right: Option<&str>) -> String {
    let mut stream = TcpStream::connect(address).await.unwrap();
    let token = right.map(|right| format!("Authorization: Bearer {right:-<32}\r\n"));
    let head = format!(
        "{line} HTTP/1.1\r\nHost: {address}\r\n{}Connection: close\r\nContent-Length: 0\r\n\r\n",
        token.unwrap_or_default()
    );
    stream.write_all(head.as_bytes()).await.unwrap();
    let mut reply = String::new();
    stream.read_to_string(&mut reply).await.unwrap();
    reply
}

#[tokio::test]
async fn a_router_behind_a_door_hears_only_those_who_have_the_right() {
    let scratch = tempfile::tempdir().unwrap();
    let file = scratch.path().join("tokens.toml");
    tokens(&file, &["read", "call", "wire", "admin"]);
    let (entrance, address) = two_routes::behind_a_token(&file).await.unwrap();
    let closed = CancellationToken::new();
    let serving = tokio::spawn(serve(vec![entrance], Most::default(), closed.clone()));
    let all = async {
        for (line, good, body) in
            [("GET /speed", "read", "\r\n\r\n1.5"), ("POST /stop", "call", "\r\n\r\nstopped")]
        {
            for right in ["read", "call", "wire", "admin"] {
                let reply = asked(address, line, Some(right)).await;
                let through = right == good || right == "admin";
                assert_eq!(reply.ends_with(body), through, "{line} {right}: {reply}");
                assert!(through || reply.starts_with("HTTP/1.1 403"), "{line} {right}: {reply}");
            }
            for unknown in [None, Some("nobody")] {
                let reply = asked(address, line, unknown).await;
                assert!(reply.starts_with("HTTP/1.1 401"), "{line} {unknown:?}: {reply}");
            }
        }
        let reply = asked(address, "PUT /stop", Some("read")).await;
        assert!(reply.starts_with("HTTP/1.1 405"), "{reply}");
        assert!(reply.contains("allow: POST\r\n") && reply.contains("no_such_method"), "{reply}");
    };
    tokio::time::timeout(WATCHDOG, all).await.unwrap();
    closed.cancel();
    serving.await.unwrap();
}
