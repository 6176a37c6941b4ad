//! JSON of values: its form, and the messages for what is refused.

#![allow(clippy::unwrap_used)] // also in helpers, where clippy.toml does not reach

use std::sync::Arc;

use expect_test::{Expect, expect};
use genom_types::{
    DataType, Kind, Label, Member, Record, ScopedName, TypeId, TypeTable, UnionMember,
};
use serde_json::{Value, json};

fn member(name: &str, ty: TypeId) -> Member {
    Member { name: name.to_owned(), ty }
}

/// A struct with one member of each kind.
fn everything() -> DataType {
    let mut t = TypeTable::default();
    let long = t.add(Kind::Long);
    let octet = t.add(Kind::Octet);
    let float = t.add(Kind::Float);
    let double = t.add(Kind::Double);
    let name = t.add(Kind::String { bound: Some(5) });
    let text = t.add(Kind::String { bound: None });
    let color = t.add(Kind::Enum {
        name: ScopedName::new(["m", "color"]),
        enumerators: ["RED", "GREEN", "BLUE"].map(str::to_owned).into(),
    });
    let point = t.add(Kind::Struct {
        name: ScopedName::new(["m", "point"]),
        members: vec![member("x", long), member("y", long)],
    });
    let label = |label| vec![Label::Value(label)];
    let choice = t.add(Kind::Union {
        name: ScopedName::new(["m", "choice"]),
        discriminant: color,
        members: vec![
            UnionMember { name: "i".to_owned(), ty: long, labels: label(0) },
            UnionMember { name: "s".to_owned(), ty: text, labels: label(1) },
        ],
    });
    let members = vec![
        member("on", t.add(Kind::Boolean)),
        member("letter", t.add(Kind::Char)),
        member("octet", octet),
        member("long", long),
        member("big", t.add(Kind::UnsignedLongLong)),
        member("float", float),
        member("double", double),
        member("name", name),
        member("text", text),
        member("color", color),
        member("row", t.add(Kind::Array { element: point, length: 2 })),
        member("few", t.add(Kind::Sequence { element: point, bound: Some(2) })),
        member("many", t.add(Kind::Sequence { element: text, bound: None })),
        member("maybe", t.add(Kind::Optional { element: point })),
        member("choice", choice),
    ];
    let id = t.add(Kind::Struct { name: ScopedName::new(["m", "all"]), members });
    DataType::new(&Arc::new(t), id).unwrap()
}

fn full() -> Value {
    json!({
        "on": true, "letter": "k", "octet": 255, "long": -5, "big": u64::MAX,
        "float": 0.1, "double": 0.1, "name": "four", "text": "été",
        "color": "BLUE", "row": [{"x": 1, "y": 2}, {"x": 3, "y": 4}],
        "few": [{"x": 5, "y": 6}], "many": ["a", "", "c"], "maybe": {"x": 7, "y": 8},
        "choice": {"d": "GREEN", "u": {"s": "chosen"}},
    })
}

#[test]
fn a_value_reads_back_as_it_was_written() {
    let mut record = Record::new(&everything());
    record.merge_json(&full()).unwrap();
    assert_eq!(record.to_json(), full());
}

#[test]
fn an_empty_record_is_zeros() {
    let shown = Record::new(&everything()).to_json();
    assert_eq!(
        shown,
        json!({
            "on": false, "letter": "\0", "octet": 0, "long": 0, "big": 0, "float": 0.0,
            "double": 0.0, "name": "", "text": "", "color": "RED",
            "row": [{"x": 0, "y": 0}, {"x": 0, "y": 0}], "few": [], "many": [], "maybe": null,
            "choice": {"d": "RED", "u": {"i": 0}},
        })
    );
}

#[test]
fn partial_values_keep_the_rest() {
    let mut record = Record::new(&everything());
    record.merge_json(&full()).unwrap();
    let part = json!({
        "on": 0, "color": "::m::GREEN", "row": {"1": {"y": 40}}, "few": {"1": {"x": 50}},
        "many": ["z"], "maybe": {"x": 70}, "choice": {"u": {"s": "again"}}, "double": null,
    });
    record.merge_json(&part).unwrap();
    let mut expected = full();
    expected["on"] = json!(false);
    expected["color"] = json!("GREEN");
    expected["row"][1]["y"] = json!(40);
    expected["few"] = json!([{"x": 5, "y": 6}, {"x": 50, "y": 0}]);
    expected["many"] = json!(["z"]);
    expected["maybe"]["x"] = json!(70);
    expected["choice"]["u"]["s"] = json!("again");
    expected["double"] = Value::Null;
    assert_eq!(record.to_json(), expected);
    record.merge_json(&json!({"maybe": null, "choice": {"d": "BLUE"}, "double": "-inf"})).unwrap();
    expected["maybe"] = Value::Null;
    expected["choice"] = json!({"d": "BLUE", "u": {}});
    expected["double"] = json!("-inf");
    assert_eq!(record.to_json(), expected);
}

#[track_caller]
fn refused(wrong: Value, message: Expect) {
    let mut record = Record::new(&everything());
    record.merge_json(&full()).unwrap();
    let error = record.merge_json(&wrong).unwrap_err();
    assert_eq!(record.to_json(), full(), "a refused value changes nothing");
    message.assert_eq(&error.to_string());
}

#[test]
fn errors_say_where_and_what_would_do() {
    refused(
        json!({"long": 1, "row": {"0": {"x": 1}, "1": {"x": 3_000_000_000u32}}}),
        expect![
            "row[1].x: 3000000000 is out of range for long, which goes from -2147483648 to 2147483647"
        ],
    );
    refused(
        json!({"long": 1, "lettre": "k"}),
        expect!["::m::all has no member `lettre`; did you mean `letter`?"],
    );
    refused(
        json!({"maybe": {"z": 1}}),
        expect!["maybe: ::m::point has no member `z`; it has x, y"],
    );
    refused(
        json!({"color": "PURPLE"}),
        expect!["color: ::m::color has no enumerator `PURPLE`; it has RED, GREEN, BLUE"],
    );
    refused(
        json!({"name": "fives"}),
        expect!["name: 5 bytes are too many for string<5>, which takes at most 4"],
    );
    refused(
        json!({"few": [{}, {}, {}]}),
        expect!["few: 3 elements are too many for sequence<::m::point,2>, which takes at most 2"],
    );
    refused(
        json!({"many": ["a", "b\0"]}),
        expect!["many[1]: the string holds a NUL character, which ends strings in C; remove it"],
    );
    refused(json!({"on": 2}), expect!["on: 2 is out of range for boolean, which goes from 0 to 1"]);
    refused(json!({"long": 1.5}), expect!["long: expected long (an integer), found 1.5"]);
    refused(
        json!({"letter": "kk"}),
        expect![[r#"letter: expected char (a string of one character), found the string "kk""#]],
    );
    refused(
        json!({"choice": {"u": {"i": 1}}}),
        expect![[
            r#"choice.u: member `i` of ::m::choice is not selected by d = "GREEN"; give `s` or another ::m::color as "d""#
        ]],
    );
    refused(
        json!({"many": {"4000000000": "a"}}),
        expect![[r#"many: `4000000000` is no index of sequence<string>; use "0" to "2097151""#]],
    );
    refused(json!([]), expect!["expected ::m::all (an object), found an array of 0"]);
}

#[test]
fn indices_beyond_the_ends_make_no_memory_without_bound() {
    let mut t = TypeTable::default();
    let double = t.add(Kind::Double);
    let row = t.add(Kind::Sequence { element: double, bound: None });
    let rows = t.add(Kind::Sequence { element: row, bound: None });
    let mut record = Record::new(&DataType::new(&Arc::new(t), rows).unwrap());
    let far = json!({"1000000": 1.0});
    record.merge_json(&json!([far, far])).unwrap();
    record.merge_json(&json!([{}, {"1000001": 1.0}])).unwrap();
    // Each one alone is within the limits; together they are not.
    let error = Record::new(record.ty()).merge_json(&json!([far, far, far])).unwrap_err();
    assert!(error.to_string().starts_with("[2]: `1000000` is no index of "), "{error}");
}
