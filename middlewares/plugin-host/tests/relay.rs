//! Requests between daemons through a library in C: the properties of the conformance suite hold,
//! and what a library does wrong is refused, limited or left out (`genom3/middleware.h`, version
//! 1.2).

#![allow(clippy::expect_used, clippy::panic, reason = "test code")]

mod built;

use std::path::Path;
use std::sync::{Arc, Mutex};
use std::time::Duration;

use built::{Built, table};
use genom_conformance::{PROPERTIES, eventually};
use genom_middleware::{AnnounceError, AskError, Middleware, Relay};
use genom_plugin_host::{Library, LibraryError};

const RELAYS: &str = include_str!("built/relays.c");

const PATIENCE: Duration = Duration::from_secs(60);

fn open(path: &Path) -> Arc<dyn Middleware> {
    let library = Library::open(path).expect("a middleware");
    library.middleware("{}").expect("it opens")
}

fn relay(of: &Arc<dyn Middleware>) -> &dyn Relay {
    of.relay().expect("requests between daemons")
}

/// The library that relays, with some of its functions replaced.
fn relaying(name: &str, before: &str, members: &str) -> Built {
    table(name, &format!("{RELAYS}\n{before}"), &format!("RELAYS, {members}"))
}

#[test]
fn a_library_in_c_has_the_properties_of_those_that_relay() {
    let names = [
        "a_daemon_is_asked_by_its_name_and_replies_with_its_identity",
        "a_daemon_that_is_not_there_is_unknown",
        "a_daemon_that_does_not_reply_tells_so",
        "requests_to_daemons_overlap_and_are_answered_apart",
        "a_second_daemon_of_a_name_is_refused",
    ];
    let built = relaying("relays", "", "");
    for name in names {
        let property = PROPERTIES.iter().find(|one| one.name == name).expect("a property");
        let path = built.path.clone();
        genom_conformance::run(name, Arc::new(move || open(&path)), property.holds);
    }
}

#[test]
fn a_function_that_is_missing_for_requests_between_daemons_is_named() {
    let built = relaying("mute", "", ".reply_relayed = NULL");
    match Library::open(&built.path).map(Library::name) {
        Err(LibraryError::Lacks { function, why, .. }) => {
            assert_eq!((function, why), ("reply_relayed", "GENOM_MW_RELAY needs"));
        }
        other => panic!("{other:?}"),
    }
    // What it can do may be told when it is open, and there it is not believed.
    let claims = "static uint64_t claims(genom_mw_backend *b) { (void)b; return GENOM_MW_RELAY; }";
    let members = ".capabilities = 0, .capabilities_of = claims, .ask = NULL";
    assert!(open(&relaying("claims", claims, members).path).relay().is_none());
    let nothing = open(&table("nothing", "", ".capabilities = GENOM_MW_REPORTS").path);
    assert!(nothing.relay().is_none() && !nothing.takes_reports());
}

/// Functions that end the test's process, behind the end of the table.
const BEHIND: &str = r"
static genom_mw_code behind(genom_mw_backend *b, void *l, genom_mw_error *e)
  { (void)b; (void)l; (void)e; abort(); }
static void times(genom_mw_backend *b) { (void)b; abort(); }
static void logs(genom_mw_backend *b, const genom_mw_entry *e) { (void)b; (void)e; abort(); }
";

#[test]
fn a_library_of_version_1_1_works_whatever_its_flags_and_what_is_behind_its_table_is_not_called() {
    let members = ".minor = 1, .size = offsetof(genom_mw_plugin, announce), .daemons = behind, \
                   .simulated_time = times, .log = logs, \
                   .capabilities = GENOM_MW_RELAY | GENOM_MW_REPORTS";
    let middleware = open(&relaying("before", BEHIND, members).path);
    assert!(middleware.relay().is_none() && !middleware.takes_reports());
    middleware.simulated_time();
    assert_eq!(middleware.trouble(), []);
}

/// Lists what it should not.
const LISTS: &str = r#"
static char large[64 << 20];
static void *kept;
static genom_mw_code lists(genom_mw_backend *b, genom_mw_str n, genom_mw_bytes r, uint64_t p,
  void *list, genom_mw_error *e)
{
  (void)b, (void)n, (void)r, (void)p, (void)e;
  genom_mw_bytes ok = { "ok", 2 }, none = { NULL, 70 }, far = { large, sizeof large + 1 };
  kept = list;
  host->replied(list, (genom_mw_str){ "\xff\xfe", 2 }, ok);
  host->replied(list, (genom_mw_str){ NULL, 5 }, none);
  host->replied(list, (genom_mw_str){ "far", 3 }, far);
  host->replied(list, (genom_mw_str){ large, 2000 }, ok);
  host->replied(NULL, (genom_mw_str){ "nowhere", 7 }, ok);
  for (int i = 0; i < 1000; i++) host->replied(list, (genom_mw_str){ "many", 4 }, ok);
  return GENOM_MW_OK;
}
static genom_mw_code silent(genom_mw_backend *b, genom_mw_str n, genom_mw_str a, genom_mw_bytes r,
  uint64_t p, void *list, genom_mw_error *e)
{
  (void)b, (void)n, (void)a, (void)r, (void)p, (void)e;
  /* To the list of another call, which is over. */
  host->replied(kept, (genom_mw_str){ "late", 4 }, (genom_mw_bytes){ "ok", 2 });
  host->text(kept, (genom_mw_str){ "late", 4 }, (genom_mw_str){ "ok", 2 });
  host->replied((void *)host, (genom_mw_str){ "host", 4 }, (genom_mw_bytes){ "ok", 2 });
  /* And of another kind. */
  host->text(list, (genom_mw_str){ "text", 4 }, (genom_mw_str){ "ok", 2 });
  return GENOM_MW_OK;
}
static genom_mw_code names(genom_mw_backend *b, void *list, genom_mw_error *e)
{
  (void)b, (void)e;
  host->text(list, (genom_mw_str){ "rob\xc3", 4 }, (genom_mw_str){ NULL, 9 });
  host->text(list, (genom_mw_str){ large, 2000 }, (genom_mw_str){ NULL, 0 });
  for (int i = 0; i < 200000; i++) host->text(list, str("r"), str(""));
  return GENOM_MW_OK;
}
static void nobody(genom_mw_backend *b, void *list) { (void)b; (void)list; }
"#;

#[test]
fn what_a_library_lists_wrongly_is_left_out() {
    let members = ".ask_all = lists, .ask = silent, .daemons = names, .own = nobody";
    let middleware = open(&relaying("lists", LISTS, members).path);
    let relay = relay(&middleware);
    let replies = relay.ask_all("robot", b"ping", PATIENCE).expect("replies");
    let begins: Vec<_> = replies.iter().take(3).map(|(at, reply)| (&**at, &**reply)).collect();
    assert_eq!(begins, [("\u{fffd}\u{fffd}", &b"ok"[..]), ("", b""), ("many", b"ok")]);
    assert_eq!(replies.len(), 15, "16 were taken, of which one has an endless identity");
    let told = relay.ask("robot", "end", b"ping", PATIENCE).expect_err("no reply").to_string();
    assert_eq!(told, "daemon robot on lists does not answer: there is no reply");
    let names = relay.daemons().expect("names");
    assert_eq!((names.len(), names[0].as_str()), (99_999, "rob\u{fffd}"));
    assert_eq!(relay.own(), "");
    let large = vec![0; (64 << 20) + 1];
    let told = relay.ask_all("robot", &large, PATIENCE).expect_err("too large").to_string();
    assert!(told.contains("the request has 67108865 bytes"), "{told}");
}

/// Each of these is called by a question for the daemons.
const PASSES: &str = r#"
static void *kept;
static unsigned closed, replied;
genom_mw_code keeps(genom_mw_backend *b, genom_mw_str n, void *to, genom_mw_announced **a,
  genom_mw_error *e) { (void)b; (void)n; (void)e; kept = to, *a = NULL; return GENOM_MW_OK; }
genom_mw_code fails(genom_mw_backend *b, genom_mw_str n, void *to, genom_mw_announced **a,
  genom_mw_error *e) { (void)b; (void)n; (void)a; (void)e; kept = to; return -7; }
static void nothing(genom_mw_announced *a) { (void)a; }
static void counts_reply(genom_mw_relayed *r, genom_mw_bytes b) { (void)r; (void)b; replied++; }
static void counts_close(genom_mw_relayed *r) { (void)r; closed++; }
static genom_mw_code passes(genom_mw_backend *b, void *list, genom_mw_error *e)
{
  static char large[(64 << 20) + 1];
  (void)b, (void)list, (void)e;
  host->relayed(NULL, NULL, (genom_mw_bytes){ "nobody", 6 });
  host->relayed(kept, NULL, (genom_mw_bytes){ large, sizeof large });
  for (int i = 0; i < 1025; i++) host->relayed(kept, NULL, (genom_mw_bytes){ NULL, 9 });
  return GENOM_MW_OK;
}
static void counts(genom_mw_backend *b, void *list)
{
  (void)b;
  host->refusal(list, str("closed"), closed, str(""));
  host->refusal(list, str("replied"), replied, str(""));
}
"#;

const PASSING: &str = ".close_announced = nothing, .reply_relayed = counts_reply, \
                       .close_relayed = counts_close, .daemons = passes, .refused = counts";

fn counted(on: &Arc<dyn Middleware>) -> (u64, u64) {
    let counts = on.refused();
    (counts[0].count, counts[1].count)
}

#[test]
fn requests_that_are_too_many_or_too_large_or_come_too_late_are_closed_without_a_reply() {
    let members = format!(".announce = keeps, {PASSING}");
    let middleware = open(&relaying("passes", PASSES, &members).path);
    let relay = relay(&middleware);
    let answers = Arc::new(Mutex::new(Vec::new()));
    let to = Arc::clone(&answers);
    let announced = relay.announce(
        "robot",
        Box::new(move |request, answer| {
            assert_eq!(request, b"", "no bytes are read where there are none");
            to.lock().expect("no panic").push(answer);
        }),
    );
    let announced = announced.expect("it is announced");
    let _ = relay.daemons();
    let mut waiting = std::mem::take(&mut *answers.lock().expect("no panic"));
    assert_eq!((waiting.len(), counted(&middleware)), (1024, (2, 0)));
    // Each ends with its reply, or without one.
    waiting.pop().expect("a request")(b"pong".to_vec());
    assert_eq!(counted(&middleware), (3, 1));
    drop(waiting);
    assert_eq!(counted(&middleware), (1026, 1));
    drop(announced);
    let _ = relay.daemons();
    assert_eq!(answers.lock().expect("no panic").len(), 0, "it was withdrawn");
    assert_eq!(counted(&middleware), (2 * 1026, 1));
}

#[test]
fn requests_to_a_daemon_that_could_not_be_announced_are_closed() {
    let members = format!(".announce = fails, {PASSING}");
    let middleware = open(&relaying("fails", PASSES, &members).path);
    let refused = relay(&middleware).announce("robot", Box::new(|_, _| panic!("a request")));
    let why = "the plugin gave no reason (code -7)".to_owned();
    let (name, backend) = ("robot".to_owned(), "fails".to_owned());
    assert_eq!(refused.map(|_| ()).err(), Some(AnnounceError::Failed { name, backend, why }));
    let _ = relay(&middleware).daemons();
    assert_eq!(counted(&middleware), (1026, 0));
}

#[test]
fn a_panic_of_who_is_asked_stays_in_the_host_and_closes_the_request() {
    let built = relaying("panics", "", "");
    let (one, other) = (open(&built.path), open(&built.path));
    let announced = relay(&one).announce("robot", Box::new(|_, _| panic!("no reply from here")));
    let announced = announced.expect("it is announced");
    let own = relay(&one).own();
    let told = relay(&other).ask("robot", &own, b"ping", PATIENCE).expect_err("no reply");
    assert!(matches!(&told, AskError::Silent { why, .. } if why == "it went away"), "{told}");
    drop(announced);
    eventually("it is withdrawn", || relay(&other).daemons() == Ok(Vec::new()));
}
