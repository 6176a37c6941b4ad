//! Ends of 1, 50 and 500 components through one library: all of them work, and closing them leaves
//! no descriptor, thread or memory behind.

#![allow(clippy::expect_used, clippy::print_stdout, reason = "test code, which prints its times")]

mod built;

use std::fs;
use std::path::Path;
use std::sync::Arc;
use std::time::Instant;

use built::library;
use genom_conformance::eventually;
use genom_conformance::process::{resident, used};
use genom_conformance::samples::{number, numbered, state};
use genom_example::Example;
use genom_middleware::{Address, Middleware, Policy, PortSpec, Reading};
use genom_plugin::abi::Plugin;
use genom_plugin_host::Library;
use genom_types::Record;

static TABLE: Plugin = genom_plugin::table::<Example>("example");

/// Opens an out port and an in port for each component, and has a sample pass through each pair.
/// Returns what the process had of the system meanwhile, and how long it took.
fn round(middleware: Arc<dyn Middleware>, components: u64) -> ((usize, usize), String) {
    let (started, memory, ty) = (Instant::now(), resident(), state());
    // Dropped when the host has dropped an in port, which it does when the library has released it.
    let held = Arc::new(());
    let mut ends: Vec<_> = (0..components)
        .map(|n| {
            let at = Address::new(format!("component{n}"), "position");
            let writer = middleware.publisher(&PortSpec::new(&at, &ty)).expect("an out port");
            let reader = middleware.subscription(&PortSpec::new(&at, &ty), Policy::Latest);
            let (mut reader, held) = (reader.expect("an in port"), Arc::clone(&held));
            assert!(reader.on_arrival(Box::new(move || drop(Arc::clone(&held)))));
            (n, writer, reader)
        })
        .collect();
    let opened = started.elapsed();
    let mut got = Record::new(&ty);
    for (n, writer, _) in &mut ends {
        writer.publish(&numbered(*n)).expect("it is queued");
    }
    for (n, _, reader) in &mut ends {
        eventually("its sample arrives", || reader.read(&mut got) == Ok(Reading::New));
        assert_eq!(number(&got), *n);
    }
    let (passed, meanwhile, with) = (started.elapsed(), used(), resident());
    assert_eq!(Arc::strong_count(&held) as u64, 1 + components);
    drop(ends);
    eventually("all in ports are released", || Arc::strong_count(&held) == 1);
    let (closed, more) = (started.elapsed(), with.saturating_sub(memory));
    let told = format!(
        "opened in {opened:?}, a sample each after {passed:?}, closed after {closed:?}; {more} kB \
         more meanwhile"
    );
    (meanwhile, told)
}

/// The board, which tells as refusals how many pieces of memory it has.
fn counting_board() -> built::Built {
    const COUNTS: &str = r#"
#include <stdlib.h>
#include <string.h>
static long pieces;
static void *one_more(void *p) { __atomic_add_fetch(&pieces, 1, __ATOMIC_SEQ_CST); return p; }
static void *grown(void *p, size_t size) { return p ? realloc(p, size) : one_more(malloc(size)); }
static void one_less(void *p)
{ if (p) __atomic_sub_fetch(&pieces, 1, __ATOMIC_SEQ_CST); free(p); }
#define malloc(size) one_more(malloc(size))
#define calloc(n, size) one_more(calloc(n, size))
#define realloc(p, size) grown(p, size)
#define strdup(s) one_more(strdup(s))
#define strndup(s, n) one_more(strndup(s, n))
#define free(p) one_less(p)
"#;
    const TELLS: &str = r#"
static void board_refused(genom_mw_backend *backend, void *list)
{
  (void)backend;
  genom_mw_str why = GENOM_MW_STR("pieces of memory"), nobody = GENOM_MW_STR("");
  host->refusal(list, why, (uint64_t)__atomic_load_n(&pieces, __ATOMIC_SEQ_CST), nobody);
}
"#;
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../plugin-api/examples/board.c");
    let text = fs::read_to_string(source).expect("the example");
    let (before, table) = text.split_once("const genom_mw_plugin").expect("its table");
    let table = table.replacen(".open =", ".refused = board_refused, .open =", 1);
    library("board", &format!("{COUNTS}{before}{TELLS}const genom_mw_plugin{table}"))
}

#[test]
fn ends_of_500_components_work_and_leave_nothing_behind_when_they_are_closed() {
    let board = counting_board();
    let in_c = Library::open(&board.path).expect("a middleware");
    let in_rust = Library::built_in(&TABLE).expect("a table");
    for (library, said) in [(in_c, "in C"), (in_rust, "in Rust")] {
        let open = |number: u64| {
            let options = format!("{{\"board\": \"many {number}\"}}");
            library.middleware(&options).expect("it opens")
        };
        // What is made once for the process is made here.
        let (with_one, _) = round(open(0), 1);
        let before = used();
        for components in [1, 50, 500] {
            let middleware = open(components);
            let pieces = || middleware.refused().first().map(|one| one.count);
            let empty = pieces();
            let (meanwhile, told) = round(Arc::clone(&middleware), components);
            println!("{said}, {components} components: {told}");
            assert_eq!(pieces(), empty, "memory of the library");
            // However many ports there are; a thread more helps where one is held up.
            let (descriptors, threads) = meanwhile;
            let enough = descriptors <= with_one.0 + 4 && threads <= with_one.1 + 4;
            assert!(enough, "{meanwhile:?} with {components}, {with_one:?} with one");
            drop(middleware);
            eventually("descriptors and threads are back", || used() == before);
        }
        // The middleware itself, 50 times at once.
        let started = Instant::now();
        let all: Vec<_> = (0..50).map(|number| open(1000 + number)).collect();
        for one in &all {
            round(Arc::clone(one), 1);
        }
        let meanwhile = used();
        drop(all);
        println!("{said}, 50 times: {:?}; meanwhile {meanwhile:?}", started.elapsed());
        eventually("descriptors and threads are back", || used() == before);
    }
}
