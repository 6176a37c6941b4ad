//! What a table says of itself decides in which form samples cross, which thread publishes, and
//! which names of types are known (`genom3/middleware.h`).

#![allow(clippy::expect_used, reason = "test code")]

mod built;

use std::path::Path;
use std::sync::Arc;

use built::table;
use genom_conformance::eventually;
use genom_middleware::{Address, Middleware, Policy, PortSpec, PublishError, ReadError, Reading};
use genom_plugin_host::Library;
use genom_types::{DataType, Kind, Member, Record, ScopedName, TypeTable};
use serde_json::json;

fn open(path: &Path) -> Arc<dyn Middleware> {
    let library = Library::open(path).expect("a middleware");
    library.middleware("{}").expect("it opens")
}

fn at() -> Address {
    Address::new("demo", "position")
}

/// An octet and a double: 16 bytes in C, in CDR 4 of encapsulation and 16, and another place of
/// the octet.
fn mixed() -> Record {
    let mut types = TypeTable::default();
    let members = [("mode", Kind::Octet), ("at", Kind::Double)];
    let members = members.map(|(name, kind)| Member { name: name.to_owned(), ty: types.add(kind) });
    let name = ScopedName::new(["demo", "mixed"]);
    let id = types.add(Kind::Struct { name, members: members.to_vec() });
    let mut record = Record::new(&DataType::new(&Arc::new(types), id).expect("a type"));
    record.merge_json(&json!({"mode": 7, "at": 1.5})).expect("a value");
    record
}

fn text() -> Record {
    let mut types = TypeTable::default();
    let id = types.add(Kind::String { bound: None });
    let mut record = Record::new(&DataType::new(&Arc::new(types), id).expect("a type"));
    record.merge_json(&json!("hello")).expect("a value");
    record
}

/// Refuses samples that are not 16 bytes with a 7 first and 1.5 at byte 8 or, with the encapsulation
/// of CDR, a string of 5 characters and its end.
const LOOKS: &str = r#"
struct genom_mw_publisher { int any; };
static genom_mw_publisher only;
static genom_mw_code looks_publisher(genom_mw_backend *b, const genom_mw_port *p,
  genom_mw_publisher **m, genom_mw_error *e) { (void)b; (void)p; (void)e; *m = &only; return GENOM_MW_OK; }
static genom_mw_code looks_publish(genom_mw_publisher *p, genom_mw_bytes s)
{
  static const unsigned char text[] = { 0, 1, 0, 0, 6, 0, 0, 0, 'h', 'e', 'l', 'l', 'o', 0 };
  struct { unsigned char mode; double at; } mixed;
  (void)p;
  if (s.len >= sizeof text && !memcmp(s.ptr, text, sizeof text)) return GENOM_MW_OK;
  if (s.len != sizeof mixed) return GENOM_MW_FAILED;
  memcpy(&mixed, s.ptr, sizeof mixed);
  return mixed.mode == 7 && mixed.at == 1.5 ? GENOM_MW_OK : GENOM_MW_FAILED;
}
"#;

#[test]
fn with_layout_samples_of_fixed_size_cross_as_in_c_and_others_in_cdr() {
    let members = ".publisher = looks_publisher, .publish = looks_publish, .capabilities = \
                   GENOM_MW_VARIABLE | GENOM_MW_RT_PUBLISH";
    let plain = open(&table("plain", LOOKS, members).path);
    let layout = open(&table("layout", LOOKS, &format!("{members} | GENOM_MW_LAYOUT")).path);
    let publish = |to: &Arc<dyn Middleware>, value: &Record| {
        let mut writer = to.publisher(&PortSpec::new(&at(), value.ty())).expect("an out port");
        writer.publish(value)
    };
    assert_eq!(publish(&layout, &mixed()), Ok(()));
    assert_eq!(publish(&layout, &text()), Ok(()));
    assert_eq!(publish(&plain, &text()), Ok(()));
    assert_eq!(publish(&plain, &mixed()), Err(PublishError::Refused), "it is in CDR");
}

/// Gives each reader a sample that is too short, then one with a 7 and 1.5.
const GIVES: &str = r#"
struct genom_mw_subscription { void *to; };
static genom_mw_subscription only;
static genom_mw_code gives(genom_mw_backend *b, const genom_mw_port *p, void *to,
  genom_mw_subscription **m, genom_mw_error *e)
{
  struct { unsigned char mode; double at; } mixed = { 7, 1.5 };
  (void)b, (void)p, (void)e;
  host->sample(to, (genom_mw_bytes){ (void *)&mixed, sizeof mixed - 1 });
  host->sample(to, (genom_mw_bytes){ (void *)&mixed, sizeof mixed });
  only.to = to, *m = &only;
  return GENOM_MW_OK;
}
static void gave(genom_mw_subscription *s) { host->release(s->to); }
"#;

#[test]
fn a_layout_of_another_size_is_refused_and_counted_and_the_next_one_read() {
    let members = ".subscription = gives, .close_subscription = gave, .capabilities = \
                   GENOM_MW_LAYOUT";
    let built = table("gives", GIVES, members);
    let middleware = open(&built.path);
    let sent = mixed();
    let mut got = Record::new(sent.ty());
    let reader = middleware.subscription(&PortSpec::new(&at(), sent.ty()), Policy::Queue(4));
    let mut reader = reader.expect("an in port");
    assert_eq!(reader.read(&mut got), Err(ReadError::Serialization));
    assert_eq!(got.to_json(), json!({"mode": 0, "at": 0.0}), "it is as it was");
    assert_eq!(reader.read(&mut got), Ok(Reading::New));
    assert_eq!(got.to_json(), sent.to_json());
    assert_eq!((reader.read(&mut got), reader.dropped()), (Ok(Reading::Same), 1));
}

/// Refuses samples from another thread than the one that opened the port.
const OWN_THREAD: &str = r#"
#include <pthread.h>
struct genom_mw_publisher { pthread_t opened; };
static genom_mw_publisher only;
static genom_mw_code own_publisher(genom_mw_backend *b, const genom_mw_port *p,
  genom_mw_publisher **m, genom_mw_error *e)
{
  (void)b, (void)p, (void)e;
  only.opened = pthread_self(), *m = &only;
  return GENOM_MW_OK;
}
static genom_mw_code own_publish(genom_mw_publisher *p, genom_mw_bytes s)
{
  (void)s;
  return pthread_equal(p->opened, pthread_self()) ? GENOM_MW_OK : GENOM_MW_FAILED;
}
"#;

#[test]
fn with_rt_publish_the_thread_that_writes_calls_the_library_and_otherwise_another_does() {
    let members = ".publisher = own_publisher, .publish = own_publish, .capabilities = \
                   GENOM_MW_VARIABLE";
    let value = mixed();
    let direct = table("direct", OWN_THREAD, &format!("{members} | GENOM_MW_RT_PUBLISH"));
    let direct = open(&direct.path);
    let mut writer = direct.publisher(&PortSpec::new(&at(), value.ty())).expect("an out port");
    assert_eq!((writer.publish(&value), writer.dropped()), (Ok(()), 0));
    let queued = table("queued", OWN_THREAD, members);
    let queued = open(&queued.path);
    let mut writer = queued.publisher(&PortSpec::new(&at(), value.ty())).expect("an out port");
    assert_eq!(writer.publish(&value), Ok(()), "it is queued");
    eventually("another thread calls, and is refused", || writer.dropped() == 1);
}

/// Knows no names but `board/NAME`, one at a time.
const NAMES: &str = r#"
static int shown;
static genom_mw_code names(genom_mw_backend *b, genom_mw_str ours, genom_mw_str foreign,
  genom_mw_error *e)
{
  static const char why[] = "board/NAME";
  (void)b;
  if (ours.len == 12 && !memcmp(ours.ptr, "::demo::pose", 12) && !shown && foreign.len > 6
      && !memcmp(foreign.ptr, "board/", 6)) { shown = 1; return GENOM_MW_OK; }
  if (e && e->room >= sizeof why) memcpy(e->text, why, e->len = sizeof why - 1);
  return GENOM_MW_UNSUPPORTED;
}
static void no_name(genom_mw_backend *b, genom_mw_str ours) { (void)b; shown = ours.len != 12; }
"#;

#[test]
fn a_library_is_told_of_masquerades_and_says_how_its_names_look() {
    let built = table("names", NAMES, ".masquerade = names, .unmask = no_name");
    let middleware = open(&built.path);
    middleware.masquerade("::demo::pose", "board/pose").expect("a name of the board");
    let again = middleware.masquerade("::demo::pose", "board/pose").expect_err("it is shown");
    assert_eq!((again.ours.as_str(), &*again.form), ("::demo::pose", "board/NAME"));
    middleware.unmask("::demo::pose");
    middleware.masquerade("::demo::pose", "board/pose").expect("it was not shown any more");
    middleware.unmask("::demo::pose");
    let told = middleware.masquerade("::demo::pose", "geometry_msgs/msg/Pose");
    let told = told.expect_err("no name of the board");
    assert_eq!((told.foreign.as_str(), &*told.form), ("geometry_msgs/msg/Pose", "board/NAME"));
    // A middleware without types of its own has nothing to show, and does not mind.
    let none = table("none", "", "");
    open(&none.path).masquerade("::demo::pose", "any").expect("nothing to do");
}
