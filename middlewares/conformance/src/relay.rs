//! Requests between daemons. A backend without them has nothing to show here.

use std::sync::mpsc::{Sender, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use genom_middleware::{AnnounceError, AskError, Middleware, Relay};

use crate::harness::{World, eventually};

/// How long who asks is patient: longer than anything takes here.
const PATIENCE: Duration = Duration::from_secs(60);

/// Sends a reply.
type Answer = Box<dyn FnOnce(Vec<u8>) + Send>;

fn relay(of: &Arc<dyn Middleware>) -> &dyn Relay {
    of.relay().expect("requests between daemons")
}

fn shows(on: &Arc<dyn Middleware>, name: &str) -> bool {
    relay(on).daemons().expect("a list").iter().any(|one| one == name)
}

/// Announces a daemon, and waits until all these show it.
fn announced(
    on: &Arc<dyn Middleware>,
    name: &str,
    to: &[&Arc<dyn Middleware>],
    requests: impl Fn(Vec<u8>, Answer) + Send + Sync + 'static,
) -> Box<dyn Send + Sync> {
    let announced = relay(on).announce(name, Box::new(requests)).expect("it is announced");
    for one in to {
        eventually("the daemon shows", || shows(one, name));
    }
    announced
}

fn backwards(mut bytes: Vec<u8>) -> Vec<u8> {
    bytes.reverse();
    bytes
}

/// Its replies come with the identity of the end that it is at, under which it is asked alone.
pub fn a_daemon_is_asked_by_its_name_and_replies_with_its_identity(world: &dyn World) {
    let (a, b) = (world.join(), world.join());
    if a.relay().is_none() {
        return;
    }
    let held = Arc::new(());
    let within = Arc::clone(&held);
    let robot = announced(&a, "robot", &[&a, &b], move |request, answer| {
        let _ = &within;
        answer(backwards(request));
    });
    let own = relay(&a).own();
    assert!(!own.is_empty(), "an identity");
    // Any bytes, none, and many.
    for request in [b"ping".to_vec(), Vec::new(), vec![0, 0xff, 0], vec![7; 1 << 20]] {
        let wanted = backwards(request.clone());
        let replies = relay(&b).ask_all("robot", &request, PATIENCE).expect("replies");
        assert_eq!(replies, [(own.clone(), wanted.clone())]);
        assert_eq!(relay(&b).ask("robot", &own, &request, PATIENCE), Ok(wanted));
    }
    drop(robot);
    eventually("the daemon is withdrawn", || !shows(&a, "robot") && !shows(&b, "robot"));
    eventually("what its requests hold is dropped", || Arc::strong_count(&held) == 1);
}

/// Who asks for a daemon that is not there is told so.
pub fn a_daemon_that_is_not_there_is_unknown(world: &dyn World) {
    let (a, b) = (world.join(), world.join());
    if a.relay().is_none() {
        return;
    }
    let _robot = announced(&a, "robot", &[&b], |request, answer| answer(request));
    let told = relay(&b).ask_all("robto", b"ping", PATIENCE);
    let (name, backend) = ("robto".to_owned(), b.name().to_owned());
    assert_eq!(told, Err(AskError::Unknown { name, backend }));
}

/// A daemon that drops a request without a reply tells who asked, before its patience ends.
pub fn a_daemon_that_does_not_reply_tells_so(world: &dyn World) {
    let (a, b) = (world.join(), world.join());
    if a.relay().is_none() {
        return;
    }
    let _robot = announced(&a, "robot", &[&b], |_, answer| drop(answer));
    let (begun, own) = (Instant::now(), relay(&a).own());
    let alone = relay(&b).ask("robot", &own, b"ping", PATIENCE).expect_err("a reply");
    assert!(matches!(&alone, AskError::Silent { name, .. } if name == "robot"), "{alone}");
    match relay(&b).ask_all("robot", b"ping", PATIENCE) {
        Ok(replies) => assert_eq!(replies, []),
        Err(error) => assert!(matches!(error, AskError::Silent { .. }), "{error}"),
    }
    assert!(begun.elapsed() < PATIENCE, "it was told when patience ended");
}

/// A reply may come later, from another thread, and after replies to later requests; patience that
/// ends before is told.
pub fn requests_to_daemons_overlap_and_are_answered_apart(world: &dyn World) {
    let (a, b) = (world.join(), world.join());
    if a.relay().is_none() {
        return;
    }
    let (sender, came) = channel::<(Vec<u8>, Answer)>();
    let sender: Mutex<Sender<_>> = Mutex::new(sender);
    let _robot = announced(&a, "robot", &[&b], move |request, answer| {
        let sender = sender.lock().unwrap_or_else(PoisonError::into_inner);
        let _ = sender.send((request, answer));
    });
    let own = relay(&a).own();
    std::thread::scope(|scope| {
        let ask = |request: &'static [u8]| {
            let (b, own) = (&b, &own);
            scope.spawn(move || relay(b).ask("robot", own, request, PATIENCE))
        };
        let first = ask(b"first");
        let (request, answer_first) = came.recv_timeout(PATIENCE).expect("a request");
        assert_eq!(request, b"first");
        let second = ask(b"second");
        let (request, answer_second) = came.recv_timeout(PATIENCE).expect("a request");
        assert_eq!(request, b"second");
        let brief = Duration::from_millis(50);
        let late = relay(&b).ask("robot", &own, b"third", brief).expect_err("a reply");
        assert!(matches!(late, AskError::Silent { .. }), "{late}");
        answer_second(b"2".to_vec());
        assert_eq!(second.join().expect("no panic"), Ok(b"2".to_vec()));
        answer_first(b"1".to_vec());
        assert_eq!(first.join().expect("no panic"), Ok(b"1".to_vec()));
        // Nobody waits for this one any more.
        let (_, answer_third) = came.recv_timeout(PATIENCE).expect("a request");
        answer_third(b"3".to_vec());
    });
}

/// A name is that of one daemon, until it is withdrawn.
pub fn a_second_daemon_of_a_name_is_refused(world: &dyn World) {
    let (a, b) = (world.join(), world.join());
    // Participants that share an end are one daemon to others.
    if a.relay().is_none() || relay(&a).own() == relay(&b).own() {
        return;
    }
    let first = announced(&a, "robot", &[&b], |request, answer| answer(request));
    let again = || relay(&b).announce("robot", Box::new(|_, _| ()));
    let (name, backend) = ("robot".to_owned(), b.name().to_owned());
    assert_eq!(again().map(|_| ()).err(), Some(AnnounceError::Taken { name, backend }));
    drop(first);
    eventually("the name is free again", || again().is_ok());
}
