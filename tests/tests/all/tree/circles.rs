//! The files of a crate do not depend on each other in circles, so that each can be read with only
//! those below it.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;

use genom_tests::{files, repository};

use super::uses::{Uses, uses};

/// All files that each file uses, directly or indirectly.
fn reached(uses: &Uses) -> BTreeMap<&str, BTreeSet<&str>> {
    let mut below: BTreeMap<&str, BTreeSet<&str>> = BTreeMap::new();
    for (from, to) in uses.keys() {
        below.entry(from).or_default().insert(to);
    }
    let mut all = BTreeMap::new();
    for from in below.keys() {
        let mut reached = BTreeSet::new();
        let mut next = vec![*from];
        while let Some(file) = next.pop() {
            let used = below.get(file).into_iter().flatten();
            next.extend(used.copied().filter(|used| reached.insert(*used)));
        }
        all.insert(*from, reached);
    }
    all
}

/// Sets of files that use each other, directly or indirectly; each set once.
fn circles(uses: &Uses) -> Vec<BTreeSet<&str>> {
    let reached = reached(uses);
    let mut all = BTreeSet::new();
    for (file, used) in &reached {
        let back = |other: &str| reached.get(other).is_some_and(|used| used.contains(file));
        let circle: BTreeSet<&str> = used.iter().copied().filter(|other| back(other)).collect();
        all.insert(circle);
    }
    all.into_iter().filter(|circle| !circle.is_empty()).collect()
}

/// Describes a circle: which file uses which, through which names.
fn drawn(uses: &Uses, circle: &BTreeSet<&str>) -> String {
    let inside = |(from, to): &(String, String)| {
        circle.contains(from.as_str()) && circle.contains(to.as_str())
    };
    let of_circle = uses.iter().filter(|(between, _)| inside(between));
    let line = |((from, to), names): (&(String, String), &BTreeSet<String>)| {
        let names: Vec<&str> = names.iter().map(String::as_str).collect();
        format!("  {from} -> {to}: {}\n", names.join(", "))
    };
    of_circle.map(line).collect()
}

#[test]
fn no_file_uses_one_that_uses_it() {
    let metadata = cargo_metadata::MetadataCommand::new()
        .manifest_path(repository().join("Cargo.toml"))
        .no_deps()
        .exec()
        .unwrap();
    let relative = |path: &Path| path.strip_prefix(repository()).unwrap().display().to_string();
    let texts: BTreeMap<String, String> = files("rs")
        .iter()
        .map(|path| (relative(path), fs::read_to_string(path).unwrap()))
        .collect();
    let mut wrong = String::new();
    for package in &metadata.packages {
        let targets = package.targets.iter();
        for target in
            targets.filter(|t| t.is_lib() || t.is_bin() || t.is_proc_macro() || t.is_cdylib())
        {
            // Programs of the book are targets outside of their package.
            let root = relative(target.src_path.as_std_path()).replace("tests/../", "");
            let uses = uses(&root, &texts);
            for circle in circles(&uses) {
                wrong += &format!("{}:\n{}", package.name, drawn(&uses, &circle));
            }
        }
    }
    assert!(wrong.is_empty(), "files that use each other (what both need goes below):\n{wrong}");
}

/// The uses and circles of a made-up crate.
fn of(files: &[(&str, &str)]) -> (Uses, Vec<Vec<String>>) {
    let texts = files.iter().map(|(path, text)| ((*path).to_owned(), (*text).to_owned()));
    let uses = uses("src/lib.rs", &texts.collect());
    let circles = circles(&uses);
    let circles = circles.iter().map(|circle| circle.iter().map(|f| (*f).to_owned()).collect());
    let circles = circles.collect();
    (uses, circles)
}

#[test]
fn a_circle_over_several_files_is_found() {
    let (uses, circles) = of(&[
        ("src/lib.rs", "mod a; mod b; mod c; mod above;"),
        ("src/a.rs", "use crate::b::B; pub struct A(B);"),
        ("src/b.rs", "pub struct B; fn f() { super::c::g(); }"),
        ("src/c.rs", "pub fn g() -> [crate::a::A; 0] { [] }"),
        ("src/above.rs", "use crate::a::A; fn h(_: A) {}"),
    ]);
    assert_eq!(circles, [["src/a.rs", "src/b.rs", "src/c.rs"]]);
    let text = drawn(&uses, &circles[0].iter().map(String::as_str).collect());
    assert!(text.contains("src/b.rs -> src/c.rs: super::c::g\n"), "{text}");
    assert!(!text.contains("above"), "{text}");
}

#[test]
fn declaring_and_exporting_children_is_no_use_but_naming_them_in_code_is() {
    let child = ("src/room/child.rs", "use super::Room; pub struct Child(Room); pub fn make() {}");
    let lib = ("src/lib.rs", "mod room; pub use room::{Child, Room};");
    let declares = "mod child; pub use child::Child; pub struct Room { child: usize }";
    assert_eq!(of(&[lib, child, ("src/room/mod.rs", declares)]).1, [[""; 0]; 0]);
    for code in [
        "mod child; pub use child::Child; pub struct Room(Vec<Child>);",
        "mod child; pub struct Room; fn f() { child::make() }",
        "mod child; use child::make; pub struct Room; fn f() { make() }",
    ] {
        let circles = of(&[lib, child, ("src/room/mod.rs", code)]).1;
        assert_eq!(circles, [["src/room/child.rs", "src/room/mod.rs"]], "{code}");
    }
}

#[test]
fn names_are_followed_to_the_file_that_defines_them() {
    // Through a re-export, another name, a glob, a module inside a file, a list, a path inside a
    // macro.
    for code in [
        "use crate::b::Below; fn f(_: Below) {}",
        "use crate::b::inner::{self, Below as Other}; fn f(_: Other) {}",
        "use crate::b::{inner}; fn f(_: inner::Below) {}",
        "use crate::b::*; fn f(_: Below) {}",
        "mod own { use super::super::b::Below; fn f(_: Below) {} }",
        "fn f() { let _ = matches!(0, crate::b::Below); }",
        "fn f(way: &super::b::inner::Below) -> <crate::b::Below as Iterator>::Item {}",
    ] {
        let (uses, circles) = of(&[
            ("src/lib.rs", "mod a; mod b;"),
            ("src/a.rs", code),
            ("src/b/mod.rs", "pub mod inner; pub use inner::*;"),
            ("src/b/inner.rs", "pub struct Below;"),
        ]);
        let expected = ("src/a.rs".to_owned(), "src/b/inner.rs".to_owned());
        assert_eq!(uses.keys().collect::<Vec<_>>(), [&expected], "{code}");
        assert!(circles.is_empty(), "{code}");
    }
}

#[test]
fn tests_comments_strings_and_other_crates_are_no_use() {
    let (uses, _) = of(&[
        ("src/lib.rs", "mod a; mod b;"),
        ("src/b.rs", "pub struct B; pub const SIZE: usize = 1;"),
        (
            "src/a.rs",
            r#"
            //! Beside [`crate::b::B`].
            use std::fmt; use other::b::B;
            const WORDS: &str = "crate::b::B"; // crate::b::B
            #[cfg(test)] use crate::b::SIZE;
            #[cfg(test)] const AT: usize = { crate::b::SIZE };
            struct S { b: usize, #[cfg(test)] own: crate::b::B, c: usize }
            fn f(s: S) -> usize { s.b }
            #[test] fn g() { crate::b::SIZE; }
            #[cfg(test)] mod tests { use super::*; use crate::b::B; fn f(_: B) {} }
            #[cfg(all(test, unix))] mod more { use crate::b::B; }
            "#,
        ),
    ]);
    assert!(uses.is_empty(), "{uses:?}");
}
