//! What a library tells of refused input and of trouble arrives as it was told; an older library,
//! whose table ends before, tells nothing (`genom3/middleware.h`, version 1.1).

#![allow(
    clippy::expect_used,
    unsafe_code,
    reason = "test code, which calls a table as a host does"
)]

mod built;

use std::io;
use std::mem::offset_of;
use std::path::Path;
use std::ptr;
use std::sync::Arc;

use built::table;
use genom_middleware::{Address, Backend, Capabilities, Middleware, Obstacle, PortSpec, Refused};
use genom_plugin::abi::table::Opaque;
use genom_plugin::abi::{Code, Host, MAJOR, Plugin, Str};
use genom_plugin_host::Library;
use genom_types::{DataType, Kind, Record, TypeTable};

fn open(path: &Path) -> Arc<dyn Middleware> {
    let library = Library::open(path).expect("a middleware");
    library.middleware("{}").expect("it opens")
}

fn refused(why: &str, count: u64, peer: Option<&str>) -> Refused {
    let peer = peer.map(|peer| peer.parse().expect("an address"));
    Refused { why: why.to_owned().into(), count, peer }
}

fn trouble() -> Vec<Obstacle> {
    let one = |what: &str, fix: &str| Obstacle { what: what.to_owned(), fix: fix.to_owned() };
    vec![one("the board is full", "take a larger one"), one("nobody listens", "")]
}

/// Two reasons at first; with each further question, one more of the second.
const TELLS: &str = r#"
#define TEXT(literal) ((genom_mw_str)GENOM_MW_STR(literal))
static uint64_t strangers = 1;
static void tells(genom_mw_backend *b, void *list)
{
  (void)b;
  host->refusal(list, TEXT("what is no board"), UINT64_MAX, TEXT("2001:db8::7"));
  host->refusal(list, TEXT("strangers"), ++strangers, TEXT(""));
  host->refusal(list, TEXT("far away"), 1, TEXT("somebody"));
}
static void complains(genom_mw_backend *b, void *list)
{
  (void)b;
  host->text(list, TEXT("the board is full"), TEXT("take a larger one"));
  host->text(list, TEXT("nobody listens"), TEXT(""));
}
"#;

#[test]
fn refusals_and_trouble_that_a_library_in_c_tells_arrive() {
    let built = table("tells", TELLS, ".refused = tells, .trouble = complains");
    let middleware = open(&built.path);
    for strangers in [2, 3] {
        let told = [
            refused("what is no board", u64::MAX, Some("2001:db8::7")),
            refused("strangers", strangers, None),
            refused("far away", 1, None),
        ];
        assert_eq!(middleware.refused(), told);
    }
    assert_eq!(middleware.trouble(), trouble());
}

/// Functions that end the test's process, behind the end of the table.
const BEHIND: &str = r"
#include <stdlib.h>
static void behind(genom_mw_backend *b, void *list) { (void)b; (void)list; abort(); }
";

#[test]
fn a_library_of_version_1_0_works_and_what_is_behind_its_table_is_not_called() {
    let members = ".minor = 0, .size = offsetof(genom_mw_plugin, refused), .refused = behind, \
                   .trouble = behind";
    let built = table("old", BEHIND, members);
    let middleware = open(&built.path);
    assert_eq!((middleware.refused(), middleware.trouble()), (Vec::new(), Vec::new()));
    let mut types = TypeTable::default();
    let double = types.add(Kind::Double);
    let ty = DataType::new(&Arc::new(types), double).expect("a type");
    let mut writer = middleware
        .publisher(&PortSpec::new(&Address::new("demo", "position"), &ty))
        .expect("an out port");
    assert_eq!(writer.publish(&Record::new(&ty)), Ok(()));
}

static TABLE: Plugin = genom_plugin::table::<Telling>("telling");

/// A backend that has trouble, and has refused something.
struct Telling;

impl Backend for Telling {
    const NAME: &'static str = "telling";
    const VERSION: &'static str = "telling 1";
    type Options = serde_json::Value;
    type Error = io::Error;

    fn open(_: serde_json::Value) -> io::Result<Arc<dyn Middleware>> {
        Ok(Arc::new(Self))
    }
}

impl Middleware for Telling {
    fn name(&self) -> &'static str {
        Self::NAME
    }

    fn capabilities(&self) -> Capabilities {
        Capabilities {
            variable_size: true,
            zero_copy: false,
            cross_process: false,
            cross_host: false,
            services: false,
            native_services: false,
        }
    }

    fn trouble(&self) -> Vec<Obstacle> {
        trouble()
    }

    fn refused(&self) -> Vec<Refused> {
        vec![refused("noise", 7, Some("192.0.2.7")), refused("more noise", 1, None)]
    }
}

genom_conformance::portless!(Telling);

#[test]
fn refusals_and_trouble_that_a_backend_in_rust_tells_arrive() {
    let library = Library::built_in(&TABLE).expect("a table");
    let middleware = library.middleware("{}").expect("it opens");
    let told = [refused("noise", 7, Some("192.0.2.7")), refused("more noise", 1, None)];
    assert_eq!(middleware.refused(), told);
    assert_eq!(middleware.trouble(), trouble());
}

/// What is where a host of version 1.0 has nothing.
unsafe extern "C" fn behind(_: Opaque, _: Str, _: u64, _: Str) {
    std::process::abort();
}

#[test]
fn in_a_host_of_version_1_0_a_backend_opens_and_what_is_behind_its_table_is_not_called() {
    let host = Host {
        size: offset_of!(Host, refusal),
        major: MAJOR,
        minor: 0,
        flags: 0,
        host: ptr::null_mut(),
        log: None,
        release: None,
        sample: None,
        request: None,
        cancel: None,
        answer: None,
        endpoint: None,
        text: None,
        refusal: Some(behind),
        relayed: None,
        replied: None,
    };
    let (mut backend, none) = (ptr::null_mut(), ptr::null_mut());
    let (open, close) = (TABLE.open.expect("it"), TABLE.close.expect("it"));
    // SAFETY: a table as a host has it, options, and room for a handle.
    let code = unsafe { open(&raw const host, Str::of("{}"), &raw mut backend, ptr::null_mut()) };
    assert_eq!(code, Code::OK);
    // SAFETY: an open backend; the host has no function that would use the list.
    unsafe { TABLE.refused.expect("it")(backend, none) };
    // SAFETY: as above.
    unsafe { TABLE.trouble.expect("it")(backend, none) };
    // SAFETY: an open backend, which is closed once.
    unsafe { close(backend) };
}
