//! Libraries that are no middlewares, or wrong ones, are refused with what is wrong.

#![allow(clippy::expect_used, reason = "test code")]

mod built;

use std::path::Path;
use std::sync::Arc;

use built::{library, table};
use genom_middleware::{Address, Middleware, OpenError, Policy, PortSpec};
use genom_plugin_host::{Library, LibraryError};
use genom_types::{DataType, Kind, Record, TypeTable};

fn refused(path: &Path) -> LibraryError {
    Library::open(path).map(Library::name).expect_err("a library that is wrong")
}

fn double() -> DataType {
    let mut types = TypeTable::default();
    let double = types.add(Kind::Double);
    DataType::new(&Arc::new(types), double).expect("a type")
}

fn open(path: &Path) -> Arc<dyn Middleware> {
    let library = Library::open(path).expect("a middleware");
    library.middleware("{}").expect("it opens")
}

#[test]
fn a_file_that_is_missing_or_no_library_is_refused() {
    let missing = refused(Path::new("/no/such/libgenomd_x.so"));
    assert!(missing.to_string().starts_with("cannot read /no/such/libgenomd_x.so: No such file"));
    let place = tempfile::tempdir().expect("a directory");
    let text = place.path().join("libgenomd_text.so");
    std::fs::write(&text, "no library").expect("a file");
    assert!(matches!(refused(&text), LibraryError::Linker { .. }));
}

#[test]
fn a_library_of_another_kind_is_no_middleware() {
    let other = library("other", "int component(void) { return 1; }");
    let told = refused(&other.path).to_string();
    assert!(told.ends_with("which genom3/middleware.h declares"), "{told}");
}

#[test]
fn another_major_version_is_refused_with_both_versions() {
    let next = table("next", "", ".major = 2, .minor = 5");
    let told = refused(&next.path).to_string();
    assert!(told.contains("version 2.5") && told.contains("this genomd has 1.2"), "{told}");
}

#[test]
fn a_newer_minor_version_is_taken() {
    let newer = table("newer", "", ".minor = 9, .size = sizeof(genom_mw_plugin) + 800");
    // What it has more is not read.
    assert_eq!(open(&newer.path).name(), "newer");
}

#[test]
fn a_table_that_is_too_short_is_refused() {
    for size in [0, 8, 64] {
        let short = table("short", "", &format!(".size = {size}"));
        assert!(
            matches!(refused(&short.path), LibraryError::Short { size: told, .. } if told == size)
        );
    }
}

#[test]
fn a_function_that_is_missing_is_named() {
    let lacks = |name: &str, members: &str| {
        let lacks = table(name, "", members);
        refused(&lacks.path).to_string()
    };
    let told = lacks("mute", ".publish = NULL");
    assert!(told.ends_with("has no `publish`, which every middleware has"), "{told}");
    let told = lacks("deaf", ".capabilities = GENOM_MW_SERVICES");
    assert!(told.ends_with("has no `serve`, which GENOM_MW_SERVICES needs"), "{told}");
    let told = lacks("blind", ".capabilities = GENOM_MW_DISCOVERY");
    assert!(told.ends_with("has no `discover`, which GENOM_MW_DISCOVERY needs"), "{told}");
}

#[test]
fn a_name_that_is_none_is_refused() {
    for name in ["", "Name", "a b", "../x", "1st"] {
        let wrong = table("wrong", "", &format!(".name = GENOM_MW_STR(\"{name}\")"));
        assert!(
            matches!(refused(&wrong.path), LibraryError::Name { name: told, .. } if told == name)
        );
    }
}

#[test]
fn a_middleware_that_does_not_open_says_why() {
    let before = r#"static genom_mw_code no(const genom_mw_host *h, genom_mw_str o,
      genom_mw_backend **b, genom_mw_error *e) { (void)h; (void)b;
      e->len = o.len < e->room ? o.len : e->room; memcpy(e->text, o.ptr, e->len);
      return GENOM_MW_FAILED; }"#;
    let closed = table("closed", before, ".open = no");
    let library = Library::open(&closed.path).expect("a table");
    let told = library.middleware("{\"key\":1}").map(|_| ()).expect_err("it does not open");
    assert_eq!(told.to_string(), "{\"key\":1}", "the options are what it got");
}

#[test]
fn what_is_missing_is_no_capability() {
    let plain = table("plain", "", ".capabilities = 0");
    let open = open(&plain.path);
    let has = open.capabilities();
    assert!(!has.services && !has.variable_size && !has.cross_process && !has.cross_host);
    assert!(open.services().is_none() && open.discovery().is_none());
    assert!(open.discover().is_err());
    assert_eq!(open.spelled(&Address::new("a", "b")), "a/b");
    assert!(open.masquerade("::demo::pose", "any").is_ok());
}

#[test]
fn what_a_plugin_does_not_explain_is_told_as_its_code() {
    let before = r"static genom_mw_code no(genom_mw_backend *b, const genom_mw_port *p, void *to,
      genom_mw_subscription **m, genom_mw_error *e)
      { (void)b; (void)p; (void)m; (void)e; host->release(to); return 99; }";
    let silent = table("silent", before, ".subscription = no");
    let (at, ty) = (Address::new("demo", "position"), double());
    let open = open(&silent.path);
    let told = open.subscription(&PortSpec::new(&at, &ty), Policy::Latest).map(|_| ());
    let why = "the plugin gave no reason (code 99)".to_owned();
    let backend = "silent".to_owned();
    assert_eq!(told, Err(OpenError::Failed { backend, address: at, why }));
}

#[test]
fn samples_that_a_plugin_refuses_are_counted() {
    let before = r"static genom_mw_code no(genom_mw_publisher *p, genom_mw_bytes s)
      { (void)p; (void)s; return GENOM_MW_FAILED; }
      static uint64_t lost(genom_mw_publisher *p) { (void)p; return 100; }";
    let full = table("full", before, ".publish = no, .lost_by_publisher = lost");
    let (at, ty) = (Address::new("demo", "position"), double());
    let open = open(&full.path);
    let mut writer = open.publisher(&PortSpec::new(&at, &ty)).expect("a publisher");
    assert_eq!(writer.dropped(), 100);
    writer.publish(&Record::new(&ty)).expect("it is queued");
    genom_conformance::eventually("the sample is counted", || writer.dropped() == 101);
}
