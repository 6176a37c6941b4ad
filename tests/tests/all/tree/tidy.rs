//! Rules for the whole repository: dependencies between crates, size and shape of files, words that
//! may not be used in some crates, valid configurations.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;

use genom_tests::{files, repository};

use super::arrows::{ARROWS, TOP};

/// Modules of crates, each above all that it knows. A crate's first names may be those of crates
/// below it.
const FLOORS: &[(&str, &str)] = &[
    ("registry", "known plugins backends masquerade lib"),
    (
        "configuration",
        "error limits runners cells states crashes reload gateways pattern blackbox recordings levels place terms offers rpc web foxglove lifecycle container spot overrides plugins file lib",
    ),
    ("ports", "dates gauge held key needs tape fan feeds tap lib"),
    (
        "supervisor",
        "outcome limits settings waiting reactor spans recording ties components connections \
         vigil supervisor loading deploy reloading lib",
    ),
    (
        "doors",
        "error within names slots seldom private holder tokens tls listen stall rights input guests streams \
         access guard serve relay lib",
    ),
    (
        "web",
        "secret visitor shelf links sessions site blocks inside console assets gate sign_in link live \
         entrance lib",
    ),
    (
        "cells",
        "end done stat dying policy shelf theirs place snapshots journal client crashes follow remains blackbox kept process bell program setup wants cell round \
         asking cells gateway unmatched own react merge record unload over ends diagnosed wire deploy thaw lib",
    ),
    ("genomd", "refusal cli announcements settings daemon ros rpc signals life run check lib main"),
];

fn relative(path: &Path) -> String {
    path.strip_prefix(repository()).unwrap_or(path).display().to_string()
}

#[test]
fn crates_know_only_those_below() {
    let metadata = cargo_metadata::MetadataCommand::new()
        .manifest_path(repository().join("Cargo.toml"))
        .no_deps()
        .exec()
        .unwrap();
    let allowed: BTreeMap<&str, &[&str]> = ARROWS.iter().copied().collect();
    let ours: BTreeSet<&str> = metadata.packages.iter().map(|p| p.name.as_str()).collect();
    let mut wrong = Vec::new();
    for package in &metadata.packages {
        let name = package.name.as_str();
        if TOP.contains(&name) {
            continue;
        }
        // Other components use the SDK and nothing else.
        let component = relative(package.manifest_path.as_std_path()).starts_with("components/");
        let known = allowed.get(name).copied().or(component.then_some(&["genom"][..]));
        let Some(known) = known else {
            wrong.push(format!("{name} has no line in ARROWS"));
            continue;
        };
        for dependency in &package.dependencies {
            let below = dependency.name.as_str();
            // Tests of a crate may use other crates; the crate itself may not.
            let product = dependency.kind != cargo_metadata::DependencyKind::Development;
            if product && ours.contains(below) && !known.contains(&below) {
                wrong.push(format!("{name} -> {below}"));
            }
        }
    }
    assert!(wrong.is_empty(), "arrows that point elsewhere: {wrong:#?}");
}

#[test]
fn modules_of_the_daemon_know_only_those_below() {
    let mut wrong = Vec::new();
    FLOORS.iter().for_each(|(of, floors)| check_floors(of, floors, &mut wrong));
    assert!(wrong.is_empty(), "arrows that point up: {wrong:#?}");
}

fn check_floors(of: &str, floors: &str, wrong: &mut Vec<String>) {
    let floor = |module: &str| floors.split_whitespace().position(|known| known == module);
    let root = repository().join("daemon").join(of).join("src");
    for path in files("rs").into_iter().filter(|path| path.starts_with(&root)) {
        let within = path.strip_prefix(&root).unwrap().with_extension("");
        let module = within.iter().next().unwrap().to_str().unwrap();
        let Some(own) = floor(module) else {
            wrong.push(format!("{module} of {of} has no place in FLOORS"));
            continue;
        };
        let text = fs::read_to_string(&path).unwrap();
        for (at, line) in text.lines().enumerate() {
            for rest in line.split("crate::").skip(1) {
                let used = rest.split(|c: char| !c.is_ascii_alphanumeric() && c != '_').next();
                if floor(used.unwrap()).is_none_or(|used| used > own) {
                    wrong.push(format!("{}:{}: {}", relative(&path), at + 1, line.trim()));
                }
            }
        }
    }
}

#[test]
fn files_are_short_and_say_what_they_are() {
    let mut lengths = Vec::new();
    let mut wrong = Vec::new();
    for path in files("rs") {
        let text = fs::read_to_string(&path).unwrap();
        let length = text.lines().count();
        lengths.push(length);
        if length > 500 {
            wrong.push(format!("{}: {length} lines, 500 at most", relative(&path)));
        }
        if !text.starts_with("//!") {
            wrong.push(format!("{}: does not begin with what it is (//!)", relative(&path)));
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
    lengths.sort_unstable();
    let median = lengths[lengths.len() / 2];
    assert!(median <= 120, "median of {} files is {median} lines", lengths.len());
}

/// Lines that the sources of a crate have at most; tests and benchmarks beside them do not count.
fn room(package: &str) -> usize {
    // The daemon is a thin program: what another one could use is a crate below it.
    if package == "genomd" { 5_000 } else { 12_000 }
}

#[test]
fn no_crate_outgrows_its_room() {
    let metadata = cargo_metadata::MetadataCommand::new()
        .manifest_path(repository().join("Cargo.toml"))
        .no_deps()
        .exec()
        .unwrap();
    let all = files("rs");
    let mut wrong = Vec::new();
    for package in &metadata.packages {
        let source = package.manifest_path.as_std_path().with_file_name("src");
        let own = all.iter().filter(|path| path.starts_with(&source));
        let lines = own.map(|path| fs::read_to_string(path).unwrap().lines().count());
        let lines: usize = lines.sum();
        let most = room(package.name.as_str());
        if lines > most {
            wrong.push(format!("{}: {lines} lines, {most} at most", package.name));
        }
    }
    assert!(wrong.is_empty(), "crates to be split by what their rooms do: {wrong:#?}");
}

#[test]
fn every_unsafe_block_says_why_it_is_sound() {
    // Clippy checks blocks; this finds `unsafe impl` and files that disable the lint.
    let mut wrong = Vec::new();
    for path in files("rs") {
        let text = fs::read_to_string(&path).unwrap();
        let lines: Vec<&str> = text.lines().collect();
        for (at, line) in lines.iter().enumerate() {
            let said = lines[at.saturating_sub(6)..at].iter().any(|line| line.contains("SAFETY"));
            if line.trim_start().starts_with("unsafe impl") && !said {
                wrong.push(format!("{}:{}", relative(&path), at + 1));
            }
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}

#[test]
fn the_runtime_speaks_no_middleware() {
    let words = ["topic", "topics", "qos", "iceoryx", "iceoryx2", "zenoh", "dds", "ros", "ros2"];
    let mut wrong = Vec::new();
    for path in files("rs") {
        if !relative(&path).starts_with("daemon/runtime/") {
            continue;
        }
        let text = fs::read_to_string(&path).unwrap().to_lowercase();
        for (at, line) in text.lines().enumerate() {
            let mut spoken = line.split(|c: char| !c.is_ascii_alphanumeric());
            if spoken.any(|word| words.contains(&word)) {
                wrong.push(format!("{}:{}: {}", relative(&path), at + 1, line.trim()));
            }
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}

#[test]
fn every_crate_follows_the_workspace() {
    let mut wrong = Vec::new();
    for path in files("toml") {
        if !path.ends_with("Cargo.toml") || path == repository().join("Cargo.toml") {
            continue;
        }
        let manifest: toml::Table = fs::read_to_string(&path).unwrap().parse().unwrap();
        if manifest.contains_key("workspace") {
            // A program of its own, which tests build as a peer.
            continue;
        }
        let workspace = |value: Option<&toml::Value>| {
            value.and_then(|value| value.get("workspace")).and_then(toml::Value::as_bool)
                == Some(true)
        };
        if !workspace(manifest.get("lints")) {
            wrong.push(format!("{}: lints.workspace = true is missing", relative(&path)));
        }
        for section in ["dependencies", "dev-dependencies", "build-dependencies"] {
            for (name, wanted) in
                manifest.get(section).and_then(|s| s.as_table()).into_iter().flatten()
            {
                if !workspace(Some(wanted)) {
                    let place = relative(&path);
                    wrong.push(format!("{place}: {name} has a version of its own"));
                }
            }
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}

/// crates.io takes crates that say what they are, and that need only what it has, in a version.
#[test]
fn crates_that_are_published_need_only_what_is_published() {
    let read = |path: &Path| -> toml::Table { fs::read_to_string(path).unwrap().parse().unwrap() };
    let root = read(&repository().join("Cargo.toml"));
    let version = &root["workspace"]["package"]["version"];
    let ours = root["workspace"]["dependencies"].as_table().unwrap();
    let mut wrong = Vec::new();
    let mut published = BTreeSet::new();
    let manifests = files("toml").into_iter().filter(|path| path.ends_with("Cargo.toml"));
    let manifests: Vec<_> = manifests.map(|path| read(&path)).collect();
    let crates: Vec<_> = manifests.iter().filter(|it| it.contains_key("package")).collect();
    for manifest in &crates {
        let package = &manifest["package"];
        if package.get("publish").and_then(toml::Value::as_bool) == Some(false) {
            continue;
        }
        let name = package["name"].as_str().unwrap();
        published.insert(name);
        if package.get("description").is_none() || package.get("license").is_none() {
            wrong.push(format!("{name}: description or license is missing"));
        }
        if let Some(entry) = ours.get(name).filter(|entry| entry.get("version") != Some(version)) {
            wrong.push(format!("{name}: {entry} does not name version {version}"));
        }
    }
    for manifest in
        crates.iter().filter(|it| published.contains(it["package"]["name"].as_str().unwrap()))
    {
        for section in ["dependencies", "build-dependencies"] {
            let needed = manifest.get(section).and_then(toml::Value::as_table);
            let needed = needed.into_iter().flat_map(toml::Table::keys);
            wrong.extend(
                needed
                    .filter(|it| {
                        ours[*it].get("path").is_some() && !published.contains(it.as_str())
                    })
                    .map(|it| {
                        format!(
                            "{} needs {it}, which is not published",
                            manifest["package"]["name"]
                        )
                    }),
            );
        }
    }
    assert!(published.contains("genomd") && published.contains("genomctl"), "{published:?}");
    assert!(wrong.is_empty(), "{wrong:#?}");
}

#[test]
fn the_changelog_has_a_place_for_what_is_new_and_tells_the_version_that_is_out() {
    let text = fs::read_to_string(repository().join("CHANGELOG.md")).unwrap();
    let titles: Vec<&str> = text.lines().filter_map(|line| line.strip_prefix("## ")).collect();
    let manifest: toml::Table =
        fs::read_to_string(repository().join("Cargo.toml")).unwrap().parse().unwrap();
    let version = manifest["workspace"]["package"]["version"].as_str().unwrap();
    let [new, out, ..] = titles[..] else { panic!("no versions in CHANGELOG.md: {titles:?}") };
    assert_eq!(new, "Unreleased");
    assert!(out.starts_with(&format!("{version} (")), "{out}, but the workspace is {version}");
}
