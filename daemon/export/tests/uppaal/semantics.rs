//! The interpreter itself: what UPPAAL's semantics says, and what it does not know.

use super::explore::{Explorer, Found};
use super::file::Model;

/// A model of one process, or of two with the same edges.
fn model(
    declaration: &str,
    locations: &[&str],
    edges: &[(usize, usize, &str)],
    two: bool,
) -> String {
    let places: String = locations
        .iter()
        .enumerate()
        .map(|(at, inner)| format!("<location id=\"l{at}\">{inner}</location>"))
        .collect();
    let edges: String = edges
        .iter()
        .map(|(from, to, labels)| {
            format!(
                "<transition><source ref=\"l{from}\"/><target ref=\"l{to}\"/>{labels}</transition>"
            )
        })
        .collect();
    let second = if two { "Q = P(1);\n" } else { "" };
    let system = if two { "O, Q" } else { "O" };
    format!(
        "<nta><declaration>{declaration}</declaration><template><name>P</name>\
         <parameter>const int[0,1] id</parameter>{places}<init ref=\"l0\"/>{edges}</template>\
         <system>O = P(0);\n{second}system {system};</system><queries>\
         <query><formula>A[] not deadlock</formula><comment>goes on</comment></query>\
         </queries></nta>"
    )
}

fn label(kind: &str, text: &str) -> String {
    format!("<label kind=\"{kind}\">{text}</label>")
}

fn found(text: &str) -> Found {
    Explorer::new(&Model::new(text)).explore(1000).unwrap()
}

#[test]
fn all_values_are_selected() {
    let edge = label("select", "k : int[1,3], m : int[0,1]") + &label("assignment", "a = k, b = m");
    let found = found(&model("int[0,3] a; int[0,1] b;", &[""], &[(0, 0, &edge)], false));
    assert_eq!((found.graph.steps.len(), found.holds("goes on")), (7, true));
}

#[test]
fn no_time_passes_where_a_step_is_urgent_or_a_location_is() {
    let declaration = "clock x[1]; const int most = 5; const int t[1] = { 5 };";
    let invariant = label("invariant", "x[0] &lt;= t[0]");
    let later = label("guard", "x[0] == most");
    let ends = |first: String, edge: String| {
        let declaration = format!("{declaration} urgent broadcast chan now;");
        found(&model(&declaration, &[&first, "<urgent/>"], &[(0, 1, &edge)], false))
            .graph
            .steps
            .len()
    };
    // Five units of time, then one state in which no more passes.
    assert_eq!(ends(invariant.clone(), later), 7);
    assert_eq!(ends(invariant.clone(), label("synchronisation", "now!")), 2);
    assert_eq!(ends(format!("{invariant}<urgent/>"), String::new()), 2);
    assert_eq!(ends(format!("{invariant}<committed/>"), String::new()), 2);
}

#[test]
fn what_is_committed_goes_first() {
    let one = |kind: &str| {
        let edges = [(0, 1, ""), (1, 2, "")];
        found(&model("", &["", kind, ""], &edges, true)).graph.steps.len()
    };
    // Of nine states of two processes, one has both in the middle.
    assert_eq!(one(""), 9);
    assert_eq!(one("<committed/>"), 8);
}

#[test]
fn waiting_is_no_deadlock_if_a_step_comes_of_it() {
    let declaration = "clock x[1]; const int t[1] = { 3 };";
    let goes_on = |guard: &str, invariant: &str| {
        let edge = label("guard", guard) + &label("assignment", "x[0] = 0");
        let place = label("invariant", invariant);
        found(&model(declaration, &[&place], &[(0, 0, &edge)], false)).holds("goes on")
    };
    assert!(goes_on("x[0] &gt;= 2", "x[0] &lt;= 3"));
    assert!(!goes_on("x[0] &gt;= 4", "x[0] &lt;= 3"));
    // Later than that nothing is possible, and one may wait for too long.
    assert!(!goes_on("x[0] &lt;= 2", "x[0] &lt;= 3"));
}

/// What is said when a model is read and explored.
fn refused(declaration: &str, edge: &str) -> String {
    let text = model(declaration, &[""], &[(0, 0, edge)], false);
    let result = std::panic::catch_unwind(|| found(&text));
    let error = result.expect_err(edge);
    let text = error.downcast_ref::<String>().cloned();
    text.or_else(|| error.downcast_ref::<&str>().map(|text| (*text).to_owned())).unwrap()
}

#[test]
fn what_uppaal_refuses_is_refused() {
    let declaration = "int[0,2] a; bool b; int[0,1] of[2]; clock x[1]; urgent broadcast chan now;
        void more() { a++; } void less() { }";
    for (edge, why) in [
        (label("assignment", "a++"), "3 is not from 0 to 2"),
        (label("assignment", "more()"), "3 is not from 0 to 2"),
        (label("assignment", "b = a + 2"), "2 is not from 0 to 1"),
        (label("assignment", "of[a] = 1, a = a + 1"), "index 2 of 2"),
        (label("guard", "b || of[a + 2] == 0"), "index 2 of 2"),
        (label("guard", "more() == 1"), "changes"),
        (label("guard", "less() == 1"), "Void"),
        (label("guard", "a++ == 1"), "changes"),
        (label("guard", "!(x[0] &lt;= 1)"), "! of"),
        (label("guard", "x[0] &lt; 1"), "Constraint"),
        (
            label("guard", "x[0] &lt;= 1") + &label("synchronisation", "now!"),
            "Invariant, and Int may be here",
        ),
        (label("synchronisation", "now?"), "nobody receives"),
        (label("assignment", "a == 1"), "does nothing"),
        (label("assignment", "c = 1"), "`c` is not known"),
        (label("assignment", "a = 1 / 1"), "unknown: / 1"),
        (label("probability", "1"), "<probability> is not known"),
    ] {
        let error = refused(declaration, &edge);
        assert!(error.contains(why), "{edge}: {error}");
    }
    for (declaration, why) in [
        ("int a; void f() { f(); }", "`f` is not known"),
        ("clock x[1]; void f() { x[0] = 0; }", "a function sets a clock"),
        ("int a; int a;", "two are named `a`"),
        ("int select;", "`select` is reserved"),
        ("int a[2]; void f() { int b = g(); }", "`g` is not known"),
        ("bool b; void f() { b++; }", "is changed"),
    ] {
        let error = refused(declaration, "");
        assert!(error.contains(why), "{declaration}: {error}");
    }
}
