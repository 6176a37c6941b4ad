//! The SDK's example, with every kind of item that codels in Rust can use, and its description.

#![allow(clippy::expect_used)] // helpers are no test functions

use std::path::PathBuf;
use std::process::Command;
use std::sync::{Arc, OnceLock};

use genom_host::{Component, Library};
use genom_runtime::plan::Plan;

const GALLERY: &str = include_str!("../../../plugin-api/rust/examples/gallery/gallery.gen");

/// The library, built once.
fn gallery() -> PathBuf {
    static BUILT: OnceLock<PathBuf> = OnceLock::new();
    let build = || {
        let mut cargo = Command::new(env!("CARGO"));
        cargo.args(["build", "--quiet", "--offline", "--message-format", "json"]);
        cargo.args(["--package", "genom", "--example", "gallery"]);
        cargo.current_dir(concat!(env!("CARGO_MANIFEST_DIR"), "/../.."));
        let output = cargo.output().expect("cargo runs");
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        let messages = String::from_utf8(output.stdout).expect("text");
        let library = messages.lines().rev().find_map(|line| {
            let message: serde_json::Value = serde_json::from_str(line).ok()?;
            let mut files =
                message["filenames"].as_array()?.iter().filter_map(|file| file.as_str());
            files.find(|file| file.ends_with(".so")).map(PathBuf::from)
        });
        library.expect("cargo names the library it built")
    };
    BUILT.get_or_init(build).clone()
}

/// The host's error for the library with this description; "" when it loads.
fn said(text: &str) -> String {
    let analysis = genom_description::read_text("gallery.gen", text, &Default::default());
    assert!(!analysis.has_errors(), "{:?}", analysis.diagnostics);
    let plan = Plan::new(&Arc::new(analysis.specification), 0).expect("a plan");
    let library = Library::open(&gallery()).expect("a library");
    let loaded = Component::load(library, &plan, &|_| "gallery.gen".to_owned());
    loaded.map_or_else(|error| error.to_string(), |_| String::new())
}

/// Expects that the description with `from` replaced by `to` is refused with `why` in the message.
#[track_caller]
fn refused(from: &str, to: &str, why: &str) {
    assert!(GALLERY.contains(from), "the gallery has {from:?}");
    let said = said(&GALLERY.replacen(from, to, 1));
    assert!(said.contains(why), "{said:?} does not say {why:?}");
}

#[test]
fn one_of_each_agrees_with_its_description() {
    assert_eq!(said(GALLERY), "");
}

#[test]
fn a_remote_whose_parameters_differ_is_refused() {
    refused("in double range, in string", "in float range, in string", "float is wanted");
    refused("in point from", "inout point from", "parameter `from`");
    refused("in double range, in string name,", "in string name,", "3 parameters are wanted");
}

#[test]
fn types_that_differ_anywhere_below_are_refused() {
    refused("string<16> tag", "string<20> tag", "tag");
    refused("sequence<long, 8> recent", "sequence<long> recent", "recent");
    refused("double x, y;", "double x; float y;", "::planner::point::y");
    refused("RED, GREEN", "RED, BLUE", "BLUE");
    refused("short grid[2][3]", "short grid[3][2]", "grid");
    refused("native engine;", "native motor; typedef motor engine;", "::gallery::motor");
    refused("port multiple in sample inputs", "port in sample inputs", "`InPort` is wanted");
    refused("string<64> why", "string<32> why", "why");
}
