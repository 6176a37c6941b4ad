//! What components log, how they fare, and that their time is simulated, arrives in libraries in C
//! and in Rust; one that is slow holds nobody up (`genom3/middleware.h`, version 1.2).

#![allow(clippy::expect_used, reason = "test code")]

mod built;

use std::io;
use std::path::Path;
use std::sync::{Arc, Mutex};

use built::table;
use genom_conformance::eventually;
use genom_middleware::{
    Backend, Capabilities, Diagnosis, Health, LogEntry, LogLevel, Middleware, Part,
};
use genom_plugin::abi::Plugin;
use genom_plugin_host::Library;

fn open(path: &Path) -> Arc<dyn Middleware> {
    let library = Library::open(path).expect("a middleware");
    library.middleware("{}").expect("it opens")
}

fn entry(level: LogLevel, message: &str) -> LogEntry {
    let (file, place) = ("src/lib.rs".to_owned(), "genomd::run".to_owned());
    let (instance, message) = ("demo".to_owned(), message.to_owned());
    LogEntry { instance, time: -5, level, place, file, line: 7, message }
}

fn part(of: Part, health: Health, values: &[(&str, &str)]) -> Diagnosis {
    let values = values.iter().map(|(name, value)| ((*name).to_owned(), (*value).to_owned()));
    let (instance, message) = ("demo".to_owned(), "as it is".to_owned());
    Diagnosis { instance, of, health, message, values: values.collect() }
}

fn parts() -> Vec<Diagnosis> {
    vec![
        part(Part::Task("main".to_owned()), Health::Good, &[("cycles", "12"), ("us", "é")]),
        part(Part::Task("io".to_owned()), Health::Late, &[]),
        part(Part::Cell("arm".to_owned()), Health::Stuck, &[("pid", "")]),
        part(Part::Cell(String::new()), Health::Ended, &[]),
    ]
}

/// Tells in the list of `trouble` what it was told.
const TELLS: &str = r#"
#include <pthread.h>
#include <stdio.h>
static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER;
static char told[4096];
static size_t used;
#define S(s) (int)(s).len, (s).ptr
#define ADD(...) (used += (size_t)snprintf(told + used, sizeof told - used, __VA_ARGS__))
static void logs(genom_mw_backend *b, const genom_mw_entry *e)
{
  (void)b;
  pthread_mutex_lock(&lock);
  if (e->size == sizeof *e)
    ADD("%.*s %lld %u %u %.*s %.*s %.*s\n", S(e->instance), (long long)e->time, e->level, e->line,
        S(e->place), S(e->file), S(e->message));
  pthread_mutex_unlock(&lock);
}
static void fares(genom_mw_backend *b, const genom_mw_diagnosis *const *parts, size_t count)
{
  (void)b;
  pthread_mutex_lock(&lock);
  for (size_t i = 0; i < count; i++) {
    const genom_mw_diagnosis *p = parts[i];
    ADD("%.*s %u %u %.*s %.*s", S(p->instance), p->part, p->health, S(p->name), S(p->message));
    for (size_t k = 0; k < p->count; k++)
      ADD(" %.*s=%.*s", S(p->values[k].name), S(p->values[k].value));
    ADD("\n");
  }
  pthread_mutex_unlock(&lock);
}
static void simulated(genom_mw_backend *b) { (void)b; ADD("simulated\n"); }
static void tells(genom_mw_backend *b, void *list)
{
  (void)b;
  pthread_mutex_lock(&lock);
  host->text(list, (genom_mw_str){ told, used }, (genom_mw_str){ 0, 0 });
  pthread_mutex_unlock(&lock);
}
"#;

#[test]
fn a_library_in_c_is_told_what_components_log_and_how_they_fare() {
    let members = ".capabilities = GENOM_MW_REPORTS, .log = logs, .diagnose = fares, \
                   .simulated_time = simulated, .trouble = tells";
    let middleware = open(&table("tells", TELLS, members).path);
    middleware.simulated_time();
    assert!(middleware.takes_reports());
    middleware.log(&entry(LogLevel::Error, "hot"));
    middleware.log(&entry(LogLevel::Debug, ""));
    middleware.diagnose(&parts());
    let wanted = "simulated\n\
        demo -5 1 7 genomd::run src/lib.rs hot\n\
        demo -5 4 7 genomd::run src/lib.rs \n\
        demo 1 1 main as it is cycles=12 us=é\n\
        demo 1 2 io as it is\n\
        demo 2 3 arm as it is pid=\n\
        demo 2 4  as it is\n";
    eventually("all is told, in order", || middleware.trouble()[0].what == wanted);
}

#[test]
fn a_library_may_take_entries_only_or_diagnoses_only() {
    for (name, takes) in [("logs", ".log = logs"), ("fares", ".diagnose = fares")] {
        let members = format!(".capabilities = GENOM_MW_REPORTS, .trouble = tells, {takes}");
        let text = format!(
            "{TELLS}\nvoid *unused[] = {{ (void *)logs, (void *)fares, (void *)simulated }};"
        );
        let middleware = open(&table(name, &text, &members).path);
        assert!(middleware.takes_reports());
        middleware.log(&entry(LogLevel::Info, "warm"));
        middleware.diagnose(&parts());
        middleware.simulated_time();
        let wanted = if name == "logs" { "warm" } else { "main as it is" };
        eventually("it is told", || middleware.trouble()[0].what.contains(wanted));
    }
}

/// Is in `log` until somebody asks for what was refused, which are the entries so far.
const SLOW: &str = r#"
#include <pthread.h>
static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER;
static pthread_cond_t changed = PTHREAD_COND_INITIALIZER;
static unsigned begun, ended;
static int goes;
static void slow(genom_mw_backend *b, const genom_mw_entry *e)
{
  (void)b, (void)e;
  pthread_mutex_lock(&lock);
  begun++;
  while (!goes) pthread_cond_wait(&changed, &lock);
  ended++;
  pthread_mutex_unlock(&lock);
}
static void go(genom_mw_backend *b, genom_mw_str s)
{
  (void)b, (void)s;
  pthread_mutex_lock(&lock);
  goes = 1;
  pthread_cond_broadcast(&changed);
  pthread_mutex_unlock(&lock);
}
static void counts(genom_mw_backend *b, void *list)
{
  (void)b;
  pthread_mutex_lock(&lock);
  host->refusal(list, (genom_mw_str){ "begun", 5 }, begun, (genom_mw_str){ 0, 0 });
  host->refusal(list, (genom_mw_str){ "ended", 5 }, ended, (genom_mw_str){ 0, 0 });
  pthread_mutex_unlock(&lock);
}
"#;

#[test]
fn reports_to_a_library_that_is_slow_hold_nobody_up_and_are_limited() {
    let members = ".capabilities = GENOM_MW_REPORTS, .log = slow, .refused = counts, .unmask = go";
    let middleware = open(&table("slow", SLOW, members).path);
    let counted = || {
        let counts = middleware.refused();
        (counts[0].count, counts[1].count)
    };
    middleware.log(&entry(LogLevel::Info, "first"));
    eventually("it is in the first", || counted() == (1, 0));
    // None of these waits.
    (0..1000).for_each(|_| middleware.log(&entry(LogLevel::Info, "more")));
    assert_eq!(counted(), (1, 0));
    middleware.unmask("");
    eventually("those that there was room for are told", || counted() == (257, 257));
    middleware.log(&entry(LogLevel::Info, "and those after them"));
    eventually("it is told", || counted() == (258, 258));
    // One that has too many bytes alone is left out; what waits is told before it closes.
    middleware.log(&entry(LogLevel::Info, &"x".repeat(2 << 20)));
    middleware.log(&entry(LogLevel::Info, "last"));
    eventually("it is told", || counted() == (259, 259));
}

static TABLE: Plugin = genom_plugin::table::<Recorder>("recorder");

static TOLD: Mutex<Told> = Mutex::new(Told { log: Vec::new(), parts: Vec::new(), simulated: 0 });

struct Told {
    log: Vec<LogEntry>,
    parts: Vec<Diagnosis>,
    simulated: u32,
}

/// A backend that keeps what it is told.
struct Recorder;

impl Backend for Recorder {
    const NAME: &'static str = "recorder";
    const VERSION: &'static str = "recorder 1";
    type Options = serde_json::Value;
    type Error = io::Error;

    fn open(_: serde_json::Value) -> io::Result<Arc<dyn Middleware>> {
        Ok(Arc::new(Self))
    }
}

impl Middleware for Recorder {
    fn name(&self) -> &'static str {
        Self::NAME
    }

    fn capabilities(&self) -> Capabilities {
        Capabilities { services: false, native_services: false, ..Capabilities::NETWORK }
    }

    fn simulated_time(&self) {
        TOLD.lock().expect("no panic").simulated += 1;
    }

    fn takes_reports(&self) -> bool {
        true
    }

    #[allow(clippy::panic, reason = "what a panic there does is tested")]
    fn log(&self, entry: &LogEntry) {
        TOLD.lock().expect("no panic").log.push(entry.clone());
        if entry.message == "panic" {
            panic!("no paper");
        }
    }

    fn diagnose(&self, parts: &[Diagnosis]) {
        TOLD.lock().expect("no panic").parts.extend_from_slice(parts);
    }
}

genom_conformance::portless!(Recorder);

#[test]
fn a_backend_in_rust_is_told_the_same_and_a_panic_in_it_ends_nothing() {
    let library = Library::built_in(&TABLE).expect("a table");
    let middleware = library.middleware("{}").expect("it opens");
    middleware.simulated_time();
    assert!(middleware.takes_reports() && middleware.relay().is_none());
    let entries = [LogLevel::Error, LogLevel::Warn, LogLevel::Info, LogLevel::Debug]
        .map(|level| entry(level, if level == LogLevel::Warn { "panic" } else { "hot" }));
    entries.iter().for_each(|entry| middleware.log(entry));
    middleware.diagnose(&parts());
    // What waits is passed on before it closes.
    drop(middleware);
    let told = TOLD.lock().expect("no panic");
    assert_eq!((&told.log[..], &told.parts[..], told.simulated), (&entries[..], &parts()[..], 1));
}
