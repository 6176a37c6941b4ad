//! Default values as JSON (genom3.md 2.4, 3.8, appendix A).

use genom_description::model::{Ix as _, ServiceIx};
use serde_json::{Value, json};

use super::{component, plain};

/// The default of parameter `p` of a function, declared after `before`.
#[track_caller]
fn default(before: &str, parameter: &str) -> Value {
    let specification = plain(&format!("component c {{ {before} function f(in {parameter}); }};"));
    let c = component(&specification, "c");
    let default = c.services[ServiceIx::new(0)].parameters[0].default.clone().unwrap();
    default.value.unwrap_or(Value::Null)
}

const S: &str = "struct s { long a, b; double c[2]; string d; };";

#[test]
fn scalars_are_plain_values() {
    assert_eq!(default("", "long p = 1 + 2"), json!(3));
    assert_eq!(default("", "double p = 1"), json!(1.0));
    assert_eq!(default("", "boolean p = TRUE"), json!(true));
    assert_eq!(default("", "string p = \"x\" \"y\""), json!("xy"));
    assert_eq!(default("", "char p = 'c'"), json!("c"));
    assert_eq!(default("", "long p = -5"), json!(-5));
    assert_eq!(default("", "unsigned long long p = 0xffffffffffffffff"), json!(u64::MAX));
    assert_eq!(default("", "optional<long> p = 3"), json!(3));
    assert_eq!(default("enum e { A, B };", "e p = B"), json!("B"));
}

#[test]
fn structs_are_objects_with_what_is_given() {
    assert_eq!(
        default(S, "s p = { 1, 2, {3, 4}, \"d\" }"),
        json!({"a": 1, "b": 2, "c": [3.0, 4.0], "d": "d"})
    );
    assert_eq!(
        default(S, "s p = { .c = {[1] = 2.}, .d =: \"doc\", .a = 3, 4 }"),
        json!({"c": {"1": 2.0}, "a": 3, "b": 4})
    );
    assert_eq!(default(S, "s p = .b = 7"), json!({"b": 7}));
}

#[test]
fn elements_are_lists_when_they_are_all_there() {
    assert_eq!(default("", "long p[2][2] = {{1,2},{3,4}}"), json!([[1, 2], [3, 4]]));
    assert_eq!(default("", "sequence<long> p = {1,2}"), json!([1, 2]));
    assert_eq!(default("", "long p[3] = {1}"), json!({"0": 1}));
    assert_eq!(default("", "sequence<long> p = {[2] = 5}"), json!({"2": 5}));
}

#[test]
fn a_union_keeps_the_last_member_and_its_label() {
    let u = "union u switch (long) { case 4: long a; default: double b; };";
    assert_eq!(default(u, "u p = {1}"), json!({"d": 4, "u": {"a": 1}}));
    assert_eq!(default(u, "u p = { .b = 2 }"), json!({"d": 0, "u": {"b": 2.0}}));
}

#[test]
fn docs_are_kept_with_their_place() {
    let specification = plain(&format!(
        "component c {{ {S} function f(in s p = {{ .c = {{ 1: \"one\" }}, .d =: \"text\" }}: \"whole\"); }};"
    ));
    let default = component(&specification, "c").services[ServiceIx::new(0)].parameters[0]
        .default
        .clone()
        .unwrap();
    assert_eq!(default.doc.as_deref(), Some("whole"));
    let docs: Vec<_> =
        default.member_docs.iter().map(|(at, text)| (at.as_str(), text.as_str())).collect();
    assert_eq!(docs, [("/c/0", "one"), ("/d", "text")]);
}
