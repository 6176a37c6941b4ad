//! Programs on zenoh that pretend to be a daemon, eavesdrop, or replay: what they learn and what
//! they can cause.

use std::sync::{Arc, Mutex};

use genom_proof::message::{FromDaemon, ToDaemon, decode, encode};
use genom_proof::{Bytes, Handshake, NONCE, Token};
use genom_tests::fleet::{at_the_robot, fleet};
use genom_tests::{Daemon, Home, Memory, path, until};
use zenoh::Wait as _;
use zenoh::query::Query;

/// Computes an impostor's reply from a message and the zenoh id of its own session.
type Answer = dyn Fn(&[u8], &str) -> Option<Vec<u8>> + Send + Sync;

/// A program on zenoh that receives what is sent to the robot.
struct Impostor {
    session: zenoh::Session,
    heard: Heard,
}

/// Received messages with their keys.
type Heard = Arc<Mutex<Vec<(String, Vec<u8>)>>>;

impl Impostor {
    /// Declares the robot's keys, and makes itself visible as the robot does.
    fn new(memory: &Memory, answer: Box<Answer>) -> Self {
        let sockets = std::fs::read_dir(memory.root().join("zenoh")).unwrap();
        let sockets = sockets.map(|entry| entry.unwrap().path());
        let sockets = sockets.filter(|path| path.extension().is_some_and(|end| end == "sock"));
        let endpoints: Vec<_> =
            sockets.map(|path| format!("\"unixsock-stream/{}\"", path.display())).collect();
        let mut config = zenoh::Config::default();
        for (key, value) in [
            ("mode", "\"peer\""),
            ("listen/endpoints", "[]"),
            ("connect/endpoints", &format!("[{}]", endpoints.join(","))),
            ("scouting/multicast/enabled", "false"),
            ("scouting/gossip/enabled", "false"),
        ] {
            config.insert_json5(key, value).unwrap();
        }
        let session = zenoh::open(config).wait().unwrap();
        let heard = Arc::<Mutex<Vec<(String, Vec<u8>)>>>::default();
        let (own, kept) = (session.zid().to_string(), Arc::clone(&heard));
        let take = move |query: Query| {
            let message =
                query.payload().map(|all| all.to_bytes().into_owned()).unwrap_or_default();
            if let Some(answer) = answer(&message, &own) {
                query.reply(query.key_expr().clone(), answer).wait().unwrap();
            }
            kept.lock().unwrap().push((query.key_expr().to_string(), message));
        };
        // One or more chunks, so that it also receives requests to the robot's own session.
        session
            .declare_queryable("@genom/rpc/robot/**")
            .callback(take)
            .background()
            .wait()
            .unwrap();
        let shown = format!("@genom/daemon/{}/robot", session.zid());
        let shown = session.liveliness().declare_token(shown).wait().unwrap();
        // Keeps it until the session ends.
        std::mem::forget(shown);
        Self { session, heard }
    }

    /// One that only listens.
    fn silent(memory: &Memory) -> Self {
        Self::new(memory, Box::new(|_, _| None))
    }

    fn id(&self) -> String {
        self.session.zid().to_string()
    }

    /// Everything that was sent to it.
    fn heard(&self) -> Vec<(String, Vec<u8>)> {
        self.heard.lock().unwrap().clone()
    }

    /// Sends a message itself and returns the reply.
    fn send(&self, key: &str, message: &[u8]) -> String {
        let replies = self.session.get(key).payload(message).wait().unwrap();
        let replies = replies.into_iter().filter_map(|reply| {
            Some(reply.result().ok()?.payload().try_to_string().ok()?.into_owned())
        });
        replies.collect()
    }
}

/// Answers a hello as a daemon that has this token.
fn with_token(text: &str) -> Box<Answer> {
    let token = Token::new(text);
    Box::new(move |message, at| {
        let (ToDaemon::Hello(hello), _) = decode::<ToDaemon>(message).ok()? else { return None };
        let cookie = [7; NONCE];
        let nonce = &hello.nonce.0;
        let keys = token.keys(&Handshake { daemon: "robot", at, nonce, cookie: &cookie });
        let at = at.to_owned();
        let hello = FromDaemon::Hello { at, cookie: Bytes(cookie), proof: keys.proof() };
        Some(encode(&hello, &[]))
    })
}

fn text_of_token(robot: &Daemon, name: &str) -> String {
    let text = std::fs::read_to_string(robot.home().path().join(name)).unwrap();
    text.split("token = \"").nth(1).unwrap().split('"').next().unwrap().to_owned()
}

/// Checks that nothing that was sent contains the token or a recognisable part of it.
#[track_caller]
fn hears_no_token(impostor: &Impostor, token: &str) {
    let heard = impostor.heard();
    assert!(!heard.is_empty(), "it heard nothing at all");
    for (key, message) in heard {
        let text = String::from_utf8_lossy(&message).to_lowercase();
        assert!(!text.contains("authorization") && !text.contains("bearer"), "{key}: {text}");
        for part in token.as_bytes().chunks(16) {
            assert!(!text.contains(std::str::from_utf8(part).unwrap()), "{key}: {text}");
        }
    }
}

const CALL: [&str; 4] = ["call", "demo", "set_speed", "velocity=0.25"];

#[test]
fn an_impostor_beside_the_daemon_is_named_and_gets_neither_token_nor_request() {
    let (robot, desk) = fleet();
    let token = text_of_token(&robot, "driver");
    at_the_robot(&robot, &desk, "driver", &CALL).expect_code(0);
    let guessed = "guessed-guessed-guessed-guessed-guessed";
    let nonsense: Box<Answer> = Box::new(|_, _| Some(b"{\"status\":200}\n{}".to_vec()));
    // The last one has the right token; two daemons of one name are an error even then.
    for (answer, what) in [
        (nonsense, "sends what is no answer of a genomd"),
        (with_token(guessed), "does not prove that it holds your token"),
        (with_token(&token), "holds your token"),
    ] {
        let impostor = Impostor::new(robot.home().memory(), answer);
        until("it is in the way", || {
            at_the_robot(&robot, &desk, "driver", &["list"]).code != Some(0)
        });
        let before = impostor.heard().len();
        let refused = at_the_robot(&robot, &desk, "driver", &CALL);
        refused.expect_code(1).expect_out("").expect_err("2 answer to the name `robot`");
        refused.expect_err(&format!("{}, which {what}", impostor.id()));
        refused.expect_err("nothing was asked of them").expect_err("--daemon NAME");
        assert_eq!(impostor.heard().len(), before + 1, "a hello, and nothing after it");
        hears_no_token(&impostor, &token);
        impostor.session.close().wait().unwrap();
        until("it is gone", || at_the_robot(&robot, &desk, "driver", &["list"]).code == Some(0));
    }
}

#[test]
fn an_impostor_before_or_instead_of_the_daemon_gets_nothing() {
    let memory = Arc::new(Memory::new());
    let desk = Home::with(&memory).start(&["--backend", "zenoh", "--daemon", "desk"]);
    let impostor = Impostor::new(&memory, with_token("guessed-guessed-guessed-guessed"));
    let made = desk.ctl(&["token", "driver", "--into", path(&desk.home().path().join("driver"))]);
    made.expect_code(0);
    let token = text_of_token(&desk, "driver");
    let asked = || at_the_robot(&desk, &desk, "driver", &CALL);
    let said = format!("what answers to the name `robot` ({})", impostor.id());
    asked().expect_code(1).expect_err(&said).expect_err("does not prove that it holds");
    // The daemon starts second, notices that its name is taken, and reports it.
    let home = Home::with(&memory);
    let robot = home.start(&["--backend", "zenoh", "--daemon", "robot"]);
    asked().expect_code(1).expect_err(&impostor.id());
    hears_no_token(&impostor, &token);
    assert!(impostor.heard().iter().all(|(key, _)| key == "@genom/rpc/robot"), "hellos alone");
    drop(robot);
}

#[test]
fn what_was_overheard_can_be_neither_sent_again_nor_changed() {
    let (robot, desk) = fleet();
    let ear = Impostor::silent(robot.home().memory());
    at_the_robot(&robot, &desk, "driver", &CALL).expect_code(0);
    until("it heard the question", || ear.heard().len() == 2);
    hears_no_token(&ear, &text_of_token(&robot, "driver"));
    let heard = ear.heard();
    let (key, question) = &heard[1];
    assert!(String::from_utf8_lossy(question).contains("0.25"), "what is asked is no secret");
    robot.ctl(&["call", "demo", "set_speed", "velocity=0.75"]).expect_code(0);
    assert!(ear.send(key, question).contains("this request came before"));
    let changed = String::from_utf8(question.clone()).unwrap().replace("0.25", "0.35");
    assert!(ear.send(key, changed.as_bytes()).contains("changed on its way"));
    let other = changed.replacen("\"number\":1", "\"number\":2", 1);
    assert!(ear.send(key, other.as_bytes()).contains("changed on its way"));
    // Replaying the hello has no effect, nor does a request in the old format.
    let (hello_key, hello) = &heard[0];
    for _ in 0..100 {
        assert!(ear.send(hello_key, hello).contains("proof"));
    }
    let old = r#"{"request":{"method":"POST","path":"/shutdown","authorization":"Bearer x"}}"#;
    assert!(ear.send(hello_key, old.as_bytes()).contains("asks for a proof"));
    robot.ctl(&["call", "demo", "get_speed"]).expect_out("velocity = 0.75\n");
    let (stopped, _) = robot.stop("TERM");
    stopped.expect_err("refused a request that came over zenoh: this request came before");
    assert!(stopped.err.matches("refused a request").count() <= 4, "{}", stopped.err);
}

#[test]
fn an_answer_that_somebody_made_up_is_told_as_such() {
    let (robot, desk) = fleet();
    // It lets the daemon answer the hello, and answers the request itself, before or after the
    // daemon.
    let forger = Impostor::new(
        robot.home().memory(),
        Box::new(|message, _| {
            let sealed = matches!(decode::<ToDaemon>(message), Ok((ToDaemon::Sealed(_), _)));
            sealed.then(|| encode(&FromDaemon::Sealed { mac: Bytes([0; 32]) }, b"{\"status\":200}"))
        }),
    );
    until("it was believed or found out", || {
        let asked = at_the_robot(&robot, &desk, "driver", &["call", "demo", "get_speed"]);
        match asked.code {
            Some(0) => assert_eq!(asked.out, "velocity = 0.5\n"),
            _ => {
                asked.expect_err("somebody changed the answer of daemon `robot`");
            }
        }
        !forger.heard().is_empty()
    });
}

#[test]
fn a_daemon_that_does_not_know_the_token_is_not_asked() {
    let (robot, desk) = fleet();
    let other = robot.home().path().join("other");
    desk.ctl(&["token", "other", "--rights", "admin", "--into", path(&other)]).expect_code(0);
    let refused = at_the_robot(&robot, &desk, "other", &["list"]);
    refused.expect_code(1).expect_err("does not know your token").expect_err("token file");
    let (stopped, _) = robot.stop("TERM");
    stopped.expect_err("WARN").expect_err("zenoh: this token is not known here");
}

#[test]
fn a_client_of_old_is_refused_and_nothing_is_done_here_instead() {
    let (_robot, desk) = fleet();
    let mut stream = genom_tests::connect(&desk.home().socket());
    use std::io::{Read as _, Write as _};
    write!(
        stream,
        "POST /shutdown HTTP/1.1\r\nHost: x\r\nGenomd-Daemon: robot\r\n\
         Authorization: Bearer x\r\nConnection: close\r\nContent-Length: 0\r\n\r\n"
    )
    .unwrap();
    let mut reply = String::new();
    stream.read_to_string(&mut reply).unwrap();
    assert!(reply.starts_with("HTTP/1.1 400") && reply.contains("old_client"), "{reply}");
    desk.ctl(&["list"]).expect_code(0);
}
