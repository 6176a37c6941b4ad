//! What editors ask about positions in a text: names, documentation, completion, also while a
//! statement is incomplete.

#![allow(clippy::unwrap_used, clippy::panic)]

use std::path::{Path, PathBuf};

use genom_description::Options;
use genom_description::source::Memory;
use genom_description_tools::navigate::{Navigator, Outline};

const TYPES: &str = "module m {\n  struct point { double x; double y; };\n};\n";
const ARM: &str = r#"#include "types.gen"
component arm {
  const long size = 3;
  /* Where it goes. */
  typedef sequence<m::point, size> way;
  exception FAR { double by; };
  ids { m::point at; way todo; };
  port out way plan { doc "What is to be done."; };
  task motion { period 10 ms; };
  attribute where(out at.x);
  activity walk(in m::point goal = { .x = 1.0 } : "The end", in long n) {
    doc "Walks.";
    task motion;
    codel<start> arm_go(in goal.y, in at, port out plan) yield move;
    codel<move> arm_move(inout todo) yield pause::move, ether;
    interrupts walk;
    throws FAR;
  };
};
"#;

fn read(text: &str) -> Navigator {
    let mut files = Memory::new();
    files.insert("types.gen", TYPES);
    files.insert("arm.gen", text);
    Navigator::read(&[PathBuf::from("arm.gen")], &Options::default(), &files)
}

fn offset(text: &str, marked: &str) -> u32 {
    let found = text.find(&marked.replace('|', "")).unwrap_or_else(|| panic!("no {marked}"));
    u32::try_from(found + marked.find('|').unwrap()).unwrap()
}

/// The declaration of the name at `|`: its line, from the name on.
fn goes_to(marked: &str) -> String {
    let arm = read(ARM);
    let file = arm.file(Path::new("arm.gen")).unwrap();
    let Some(span) = arm.definition(file, offset(ARM, marked)) else { return "nowhere".into() };
    let source = arm.analysis.sources.file(span.file).unwrap();
    let rest = source.text()[span.start as usize..].lines().next().unwrap().to_owned();
    format!("{}: {rest}", source.path().display())
}

#[test]
fn names_go_to_their_declarations() {
    for (marked, wanted) in [
        ("m::po|int, size", "types.gen: point { double x; double y; };"),
        ("<|m::point", "types.gen: m {"),
        ("point, si|ze", "arm.gen: size = 3;"),
        ("out at.|x", "types.gen: x; double y; };"),
        ("out |at.x", "arm.gen: at; way todo; };"),
        ("task mo|tion;", "arm.gen: motion { period 10 ms; };"),
        (".|x = 1.0", "types.gen: x; double y; };"),
        ("in goal|.y", "arm.gen: goal = { .x = 1.0 } : \"The end\", in long n) {"),
        ("goal.y|,", "types.gen: y; };"),
        ("out pl|an) yield", "arm.gen: plan { doc \"What is to be done.\"; };"),
        ("yield mo|ve;", "arm.gen: move> arm_move(inout todo) yield pause::move, ether;"),
        (
            "interrupts wa|lk",
            "arm.gen: walk(in m::point goal = { .x = 1.0 } : \"The end\", in long n) {",
        ),
        ("throws |FAR", "arm.gen: FAR { double by; };"),
        ("\"types|.gen\"", "types.gen: module m {"),
        ("per|iod", "nowhere"),
    ] {
        assert_eq!(goes_to(marked), wanted, "{marked}");
    }
}

fn hover(marked: &str) -> String {
    let arm = read(ARM);
    arm.hover(arm.file(Path::new("arm.gen")).unwrap(), offset(ARM, marked)).unwrap().1
}

#[test]
fn what_is_pointed_at_is_told_with_documentation_and_size() {
    for (marked, wanted) in [
        (
            "m::po|int, size",
            "```genom\nstruct point { double x; double y; }\n```\n\n16 bytes, alignment 8\n",
        ),
        ("out at.|x", "```genom\ndouble x\n```\n\n`double`: 8 bytes, alignment 8, offset 0\n"),
        ("goal.|y", "```genom\ndouble y\n```\n\n`double`: 8 bytes, alignment 8, offset 8\n"),
        ("out w|ay", "```genom\ntypedef sequence<m::point, size> way\n```\n\nWhere it goes.\n\n"),
        ("out pl|an)", "```genom\nport out way plan\n```\n\nWhat is to be done.\n\n`::arm::way`: "),
        ("in go|al.y", "The end\n\n`::m::point`: 16 bytes"),
        (
            "interrupts wa|lk",
            "activity walk(in m::point goal = { .x = 1.0 } : \"The end\", in long n)\n```\n\nWalks.\n",
        ),
    ] {
        let told = hover(marked);
        assert!(told.contains(wanted), "{marked}: {told}");
    }
}

#[test]
fn references_are_all_the_places_of_a_name() {
    let arm = read(ARM);
    let found =
        arm.references(arm.file(Path::new("arm.gen")).unwrap(), offset(ARM, "m::po|int, size"));
    assert_eq!(found.len(), 4, "its declaration and three uses: {found:?}");
}

#[test]
fn a_codel_is_one_function_in_all_its_places() {
    let text =
        "component c { function f() { codel go(); }; function g() { codel go(); codel no(); };
        task t { codel<start, go> go() yield go, ether; }; function h() { validate go(); }; };";
    let read = read(text);
    let file = read.file(Path::new("arm.gen")).unwrap();
    let places = |marked| read.references(file, offset(text, marked)).len();
    assert_eq!(places("f() { codel g|o"), 4, "the state of this name is none of them");
    assert_eq!(places("validate g|o"), 4);
    assert_eq!(places("codel n|o"), 1);
    assert_eq!(places("yield g|o"), 2);
    let spans = read.rename(file, offset(text, "validate g|o"), "run").unwrap();
    assert_eq!(spans.len(), 4);
}

#[test]
fn an_outline_is_a_tree_in_order() {
    fn names(list: &[Outline<'_>]) -> String {
        let one = |it: &Outline<'_>| {
            if it.children.is_empty() {
                it.symbol.name.to_string()
            } else {
                format!("{}({})", it.symbol.name, names(&it.children))
            }
        };
        list.iter().map(one).collect::<Vec<_>>().join(" ")
    }
    let arm = read(ARM);
    let outline = arm.outline(arm.file(Path::new("arm.gen")).unwrap());
    assert_eq!(
        names(&outline),
        "arm(size way FAR(by) ids(at todo) plan motion where walk(arm_go arm_move))"
    );
    for one in &outline {
        assert!(one.symbol.extent.start <= one.symbol.span.start);
        assert!(one.symbol.extent.end >= one.symbol.span.end);
    }
}

/// Completions at `|` in a statement of the component.
fn offered(statement: &str) -> Vec<String> {
    let last = ARM.rfind("};").unwrap();
    let (marked, rest) = (format!("{}{statement}", &ARM[..last]), &ARM[last..]);
    let at = u32::try_from(marked.rfind('|').unwrap()).unwrap();
    let text = format!("{}{rest}", marked.replacen('|', "", 1));
    let arm = read(&text);
    let found = arm.complete(arm.file(Path::new("arm.gen")).unwrap(), at);
    found.into_iter().map(|one| one.label).collect()
}

#[test]
fn completions_fit_the_place() {
    for (statement, wanted, unwanted) in [
        ("  |", "activity", "period"),
        ("  po|", "port", "period"),
        ("  port |", "in", "way"),
        ("  port out |", "way", "plan"),
        ("  port out m::|", "point", "way"),
        ("  task t { | };", "period", "port"),
        ("  attribute a(in |", "todo", "way"),
        ("  attribute a(in at.|", "y", "todo"),
        ("  function f(|", "inout", "way"),
        ("  function f(in |", "way", "todo"),
        ("  function f(in long n) { codel c(in |); };", "n", "way"),
        ("  function f(in long n) { codel c(port |); };", "out", "plan"),
        ("  function f(in long n) { codel c(port out |); };", "plan", "n"),
        ("  function f(in m::point p) { codel c(in p.|); };", "x", "p"),
        ("  activity g() { task |; };", "motion", "walk"),
        ("  activity g() { interrupts |; };", "walk", "motion"),
        ("  activity g() { throws |; };", "FAR", "way"),
        ("  activity g() { codel<start> c() yield |; };", "ether", "walk"),
        ("  activity g() { codel<start> c() |; };", "yield", "ether"),
        ("  typedef sequence<|", "double", "component"),
        ("  const long other = |", "size", "way"),
    ] {
        let found = offered(statement);
        assert!(found.iter().any(|label| label == wanted), "{statement}: {found:?}");
        assert!(!found.iter().any(|label| label == unwanted), "{statement}: {found:?}");
    }
    assert_eq!(offered("  doc \"|\";"), Vec::<String>::new());
    assert_eq!(offered("  // |"), Vec::<String>::new());
    assert_eq!(offered("  /* | */"), Vec::<String>::new());
}

#[test]
fn no_place_in_no_text_makes_it_fail() {
    for cut in (0..ARM.len()).step_by(7) {
        let text = &ARM[..cut];
        let arm = read(text);
        let file = arm.file(Path::new("arm.gen")).unwrap();
        for at in (cut.saturating_sub(12)..=cut + 2).chain([0, cut / 2]) {
            let at = u32::try_from(at).unwrap();
            let _ = (arm.complete(file, at), arm.hover(file, at), arm.definition(file, at));
            let _ = (arm.references(file, at), arm.outline(file));
        }
    }
}
