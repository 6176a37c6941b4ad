//! Models for other tools name only what they declare. What they say is compared with Spin (`spin`), and
//! with an interpreter of the rules in UPPAAL's language (`uppaal`); TChecker and UPPAAL themselves are
//! no part of the tests.

#![allow(clippy::unwrap_used, clippy::panic)]

#[path = "../../formal/tests/support/mod.rs"]
mod support;

use std::collections::BTreeSet;

use genom_export::{ExportError, Format, export};
use genom_formal::Limits;
use support::{DUO, limits, running};

/// Their ticks are not at the same dates.
fn shifted() -> String {
    DUO.replace("period 10 ms;", "period 10 ms; delay 4 ms;")
}

/// What stands between `from` and the next of these characters.
fn after<'a>(text: &'a str, from: &str, ends: &[char]) -> Vec<&'a str> {
    text.split(from).skip(1).filter_map(|rest| rest.split(ends).next()).collect()
}

#[test]
fn tchecker_gets_all_states_and_each_step_leads_to_one() {
    let system = running(&shifted());
    let times = system.declared_times();
    let text = export(&system, Format::Tchecker, Some(&times), &limits()).unwrap();
    let declared: BTreeSet<&str> = after(&text, "\nlocation:p:", &['{']).into_iter().collect();
    let states = system.check_times(&times, &limits()).explored.states();
    let found = declared.iter().filter(|name| name.starts_with('s')).count();
    assert_eq!(found, states);
    for edge in after(&text, "\nedge:p:", &['{']) {
        let ends: Vec<&str> = edge.split(':').take(2).collect();
        assert!(ends.iter().all(|end| declared.contains(end)), "{edge}");
    }
    // At the start `fast` is 6 ms after a tick: its first one comes at 4 ms.
    assert!(text.contains("location:p:b0{initial: : invariant: t0<=6}"), "{text}");
    assert!(text.contains("labels: late_fast"), "{text}");
}

#[test]
fn uppaal_can_have_the_same_states_and_steps() {
    let system = running(&shifted());
    let times = system.declared_times();
    let flat = export(&system, Format::Tchecker, Some(&times), &limits()).unwrap();
    let text = export(&system, Format::UppaalFlat, Some(&times), &limits()).unwrap();
    let ids: BTreeSet<&str> = after(&text, "<location id=\"", &['"']).into_iter().collect();
    assert_eq!(ids.len(), after(&flat, "\nlocation:p:", &['{']).len());
    let refs = after(&text, " ref=\"", &['"']);
    assert!(refs.iter().all(|one| ids.contains(one)));
    assert_eq!(
        after(&text, "<transition>", &['\n']).len(),
        after(&flat, "\nedge:p:", &['{']).len()
    );
    assert!(text.contains("<formula>A[] not c.late_fast</formula>"), "{text}");
}

/// What an element contains, in order: names, each at least and at most so many times. An element that
/// is not here has text only.
const DOCUMENT_TYPE: [(&str, Contents); 7] = [
    ("nta", &[("declaration", 0, 1), ("template", 1, MANY), ("system", 1, 1), ("queries", 0, 1)]),
    (
        "template",
        &[
            ("name", 1, 1),
            ("parameter", 0, 1),
            ("location", 0, MANY),
            ("init", 0, 1),
            ("transition", 0, MANY),
        ],
    ),
    ("location", &[("name", 0, 1), ("label", 0, MANY), ("urgent", 0, 1), ("committed", 0, 1)]),
    ("transition", &[("source", 1, 1), ("target", 1, 1), ("label", 0, MANY)]),
    ("queries", &[("query", 0, MANY)]),
    ("query", &[("formula", 1, 1), ("comment", 1, 1)]),
    ("init", &[]),
];
const MANY: usize = usize::MAX;
type Contents = &'static [(&'static str, usize, usize)];

/// Whether an element and all in it is as the document type says.
fn is_valid(element: roxmltree::Node<'_, '_>) -> bool {
    let name = element.tag_name().name();
    let children: Vec<_> = element.children().filter(roxmltree::Node::is_element).collect();
    let known = DOCUMENT_TYPE.iter().find(|(own, _)| *own == name);
    let contains: Contents = known.map_or(&[], |one| one.1);
    let mut left = children.iter().map(|child| child.tag_name().name()).peekable();
    let in_order = contains.iter().all(|(name, least, most)| {
        let mut count = 0;
        while left.next_if_eq(name).is_some() {
            count += 1;
        }
        (*least..=*most).contains(&count)
    });
    in_order && left.next().is_none() && children.into_iter().all(is_valid)
}

#[test]
fn uppaal_gets_a_file_of_its_document_type_in_which_each_reference_is_to_a_location() {
    // With and without what comes before the first tick, and with names of what is done.
    for (text, format) in [
        (shifted(), Format::UppaalFlat),
        (DUO.to_owned(), Format::UppaalFlat),
        (shifted(), Format::Uppaal),
    ] {
        let system = running(&text);
        let times = system.declared_times();
        let text = export(&system, format, Some(&times), &limits()).unwrap();
        let options = roxmltree::ParsingOptions { allow_dtd: true, ..Default::default() };
        let document = roxmltree::Document::parse_with_options(&text, options).unwrap();
        let root = document.root_element();
        assert_eq!(root.tag_name().name(), "nta");
        assert!(is_valid(root), "{text}");
        let with = |attribute: &'static str| {
            document.descendants().filter_map(move |one| one.attribute(attribute))
        };
        let ids: BTreeSet<&str> = with("id").collect();
        assert_eq!(ids.len(), with("id").count(), "two have one id");
        assert!(with("ref").count() > ids.len() && with("ref").all(|one| ids.contains(one)));
        let ended =
            |name: &str| document.descendants().filter(|one| one.has_tag_name(name)).count();
        assert_eq!(with("ref").count(), 2 * ended("transition") + ended("init"));
    }
}

#[test]
fn uppaal_gets_tables_and_roles_beside_the_rules() {
    let system = running(
        "component tiny { task t { period 5 ms; delay 1 ms; codel<start> t0() yield pause::start wcet \
         2 ms; }; };",
    );
    let times = system.declared_times();
    let text = export(&system, Format::Uppaal, Some(&times), &limits()).unwrap();
    let (tables, rest) = text.split_once("\n/* --- Rules").unwrap();
    let (_, roles) = rest.split_once("\nclock ").unwrap();
    let short = format!("{tables}\n(the rules)\nclock {roles}");
    expect_test::expect_file!["golden/tiny.xml"].assert_eq(&short);
}

#[test]
fn uppaal_gets_no_longer_times_than_its_clocks_count() {
    let system = running(&DUO.replace("wcet 3 ms", "wcet 0.000001 ms").replace("40 ms", "4000 ms"));
    let times = system.declared_times();
    let refused = export(&system, Format::Uppaal, Some(&times), &limits()).unwrap_err();
    assert_eq!(
        refused.to_string(),
        "the component has 4000000000 units of time in one of its times, and a model in uppaal may have \
         1000000000"
    );
}

#[test]
fn clocks_want_times_of_all_codels() {
    let system = running(&shifted().replace("wcet 8 ms", ""));
    assert_eq!(export(&system, Format::Tchecker, None, &limits()), Err(ExportError::NoTimes));
    let few = Limits { states: 3, ..limits() };
    let times = system.declared_times();
    let refused = export(&system, Format::UppaalFlat, Some(&times), &few).unwrap_err();
    assert_eq!(
        refused.to_string(),
        "the states cannot be written out: more than 3 states; lower the bounds on clients"
    );
}
