//! Libraries in C, compiled by the test.

#![allow(clippy::unwrap_used, dead_code, reason = "test code; not all tests use all")]

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::LazyLock;

use tempfile::TempDir;

/// A directory with a library, `libgenomd_NAME.so`.
pub(crate) struct Built {
    pub(crate) path: PathBuf,
    _place: TempDir,
}

fn api() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../plugin-api")
}

/// Compiles a text in C.
pub(crate) fn library(name: &str, text: &str) -> Built {
    let place = tempfile::tempdir().unwrap();
    let source = place.path().join("source.c");
    fs::write(&source, text).unwrap();
    compiled(name, &source, place)
}

/// The board of `docs/plugins.md`.
pub(crate) static BOARD: LazyLock<Built> = LazyLock::new(|| {
    compiled("board", &api().join("examples/board.c"), tempfile::tempdir().unwrap())
});

/// The board, with more of what a middleware can do.
pub(crate) fn board_that(can: &str) -> Built {
    let text = fs::read_to_string(api().join("examples/board.c")).unwrap();
    let more = text.replace("= GENOM_MW_VARIABLE,", &format!("= GENOM_MW_VARIABLE | {can},"));
    assert_ne!(text, more, "the example names its capabilities otherwise");
    library("board", &more)
}

fn compiled(name: &str, source: &Path, place: TempDir) -> Built {
    let path = place.path().join(format!("libgenomd_{name}.so"));
    let told = Command::new("cc")
        .args(["-Wall", "-Wextra", "-Werror", "-shared", "-fPIC", "-I"])
        .arg(api().join("include"))
        .arg("-o")
        .arg(&path)
        .arg(source)
        .output()
        .unwrap();
    assert!(told.status.success(), "{}", String::from_utf8_lossy(&told.stderr));
    Built { path, _place: place }
}

/// What all parts of a table in C have in common: functions that do nothing, and `.name`.
pub(crate) const NOTHING: &str = r#"
#include <string.h>
#include "genom3/middleware.h"
static const genom_mw_host *host;
static genom_mw_code mw_open(const genom_mw_host *h, genom_mw_str o, genom_mw_backend **b,
  genom_mw_error *e) { (void)o; (void)e; host = h; *b = 0; return GENOM_MW_OK; }
static void mw_close(genom_mw_backend *b) { (void)b; }
static genom_mw_code mw_publisher(genom_mw_backend *b, const genom_mw_port *p,
  genom_mw_publisher **m, genom_mw_error *e) { (void)b; (void)p; (void)m; (void)e; return 0; }
static genom_mw_code mw_publish(genom_mw_publisher *p, genom_mw_bytes s)
  { (void)p; (void)s; return GENOM_MW_OK; }
static void mw_close_publisher(genom_mw_publisher *p) { (void)p; }
static genom_mw_code mw_subscription(genom_mw_backend *b, const genom_mw_port *p, void *to,
  genom_mw_subscription **m, genom_mw_error *e)
  { (void)b; (void)p; (void)m; (void)e; host->release(to); return 0; }
static void mw_close_subscription(genom_mw_subscription *s) { (void)s; }
#define NOTHING .size = sizeof(genom_mw_plugin), .major = GENOM_MW_MAJOR, \
  .minor = GENOM_MW_MINOR, .version = GENOM_MW_STR("1"), .open = mw_open, .close = mw_close, \
  .publisher = mw_publisher, .publish = mw_publish, .close_publisher = mw_close_publisher, \
  .subscription = mw_subscription, .close_subscription = mw_close_subscription
"#;

/// A table of which the rest is given, after functions that do nothing.
pub(crate) fn table(name: &str, before: &str, members: &str) -> Built {
    let text = format!(
        "{NOTHING}\n{before}\n#pragma GCC diagnostic ignored \"-Woverride-init\"\n\
         const genom_mw_plugin genom_middleware_plugin = {{ NOTHING, \
         .name = GENOM_MW_STR(\"{name}\"), {members} }};\n"
    );
    library(name, &text)
}
