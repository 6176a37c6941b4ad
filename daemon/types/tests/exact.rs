//! Values in files: random ones come back unchanged, also those that plain JSON cannot say; values of
//! another type are taken over by the names of their members.

#![allow(clippy::unwrap_used)] // also in helpers, where clippy.toml does not reach

mod support;

use std::sync::Arc;

use genom_types::{
    Conversion, DataType, Kind, Label, Member, Record, ScopedName, TypeId, TypeTable, UnionMember,
};
use proptest::prelude::*;
use serde_json::{Value, json};
use support::{Rng, Types, value};

proptest! {
    #![proptest_config(ProptestConfig { cases: 1500, failure_persistence: None, ..Default::default() })]

    #[test]
    fn a_value_of_any_type_comes_back_from_text(seed: u64, depth in 0u32..5) {
        let (mut table, mut rng) = (TypeTable::default(), Rng::new(seed));
        let id = Types { table: &mut table, rng: &mut rng, fixed: false, count: 0 }.any(depth);
        let (json, other) = (value(&table, id, &mut rng), value(&table, id, &mut rng));
        let ty = DataType::new(&Arc::new(table), id).unwrap();
        let mut record = Record::new(&ty);
        record.merge_json(&json).unwrap();
        let text = record.to_exact_json().value.to_string();
        // Into a record with another value, so that leftovers would show.
        let mut back = Record::new(&ty);
        back.merge_json(&other).unwrap();
        let told = back.take_over(&serde_json::from_str(&text).unwrap());
        prop_assert!(told.is_exact(), "{:?}: {}", told, text);
        let (mut one, mut same) = (Vec::new(), Vec::new());
        record.encode_cdr(&mut one).unwrap();
        back.encode_cdr(&mut same).unwrap();
        prop_assert_eq!(one, same);
    }

    #[test]
    fn bytes_that_are_no_text_and_enums_out_of_range_come_back_too(seed: u64, depth in 0u32..5) {
        let (mut table, mut rng) = (TypeTable::default(), Rng::new(seed));
        let id = Types { table: &mut table, rng: &mut rng, fixed: true, count: 0 }.any(depth);
        let ty = DataType::new(&Arc::new(table), id).unwrap();
        let mut record = Record::new(&ty);
        let noise: Vec<u8> = (0..ty.size()).map(|_| rng.next() as u8).collect();
        if record.set_bytes(&noise).is_ok() {
            let mut back = Record::new(&ty);
            let told = back.take_over(&record.to_exact_json().value);
            // But for strings without their NUL, which get one. Of many, the last line tells how
            // many more there are.
            let others = [&told.new, &told.gone, &told.unfit];
            prop_assert!(others.iter().all(|list| list.is_empty()), "{:?}", told);
            let cut = |line: &String| line.contains(": cut to ") || line.starts_with("and ");
            prop_assert!(told.converted.listed().iter().all(cut), "{:?}", told);
            let exact = back.to_exact_json().value;
            let mut again = Record::new(&ty);
            prop_assert!(again.take_over(&exact).is_exact());
            prop_assert_eq!(again.to_exact_json().value, exact);
        }
    }

    #[test]
    fn any_json_for_any_type_is_taken_or_told(seed: u64, depth in 0u32..4) {
        let mut rng = Rng::new(seed);
        let mut any = || {
            let mut table = TypeTable::default();
            let id = Types { table: &mut table, rng: &mut rng, fixed: false, count: 0 }.any(depth);
            let json = value(&table, id, &mut rng);
            (DataType::new(&Arc::new(table), id).unwrap(), json)
        };
        let ((ty, _), (_, json)) = (any(), any());
        let mut record = Record::new(&ty);
        let told = record.take_over(&json);
        // Whatever it became is a value that comes back.
        let exact = record.to_exact_json().value;
        prop_assert!(Record::new(&ty).take_over(&exact).is_exact(), "{:?} {}", told, exact);
    }
}

fn member(name: &str, ty: TypeId) -> Member {
    Member { name: name.to_owned(), ty }
}

fn structure(members: impl FnOnce(&mut TypeTable) -> Vec<Member>) -> DataType {
    let mut table = TypeTable::default();
    let members = members(&mut table);
    let id = table.add(Kind::Struct { name: ScopedName::new(["s"]), members });
    DataType::new(&Arc::new(table), id).unwrap()
}

#[test]
fn what_plain_json_cannot_say_is_said() {
    let ty = structure(|t| {
        let double = t.add(Kind::Double);
        let float = t.add(Kind::Float);
        let maybe = t.add(Kind::Optional { element: double });
        let maybe_maybe = t.add(Kind::Optional { element: maybe });
        let text = t.add(Kind::String { bound: None });
        let octet = t.add(Kind::Octet);
        let image = t.add(Kind::Sequence { element: octet, bound: None });
        let list = t.add(Kind::Sequence { element: double, bound: None });
        let lists = t.add(Kind::Optional { element: list });
        let driver = t.add(Kind::Native { name: ScopedName::new(["driver"]) });
        vec![
            member("reals", list),
            member("small", float),
            member("maybe", maybe),
            member("twice", maybe_maybe),
            member("lists", lists),
            member("text", text),
            member("image", image),
            member("driver", driver),
        ]
    });
    let octets: Vec<u8> = (0..40).collect();
    let exact = json!({
        "reals": [null, "inf", "-inf", -0.0, 0.1, 5e-324],
        "small": 0.1,
        "maybe": [null],
        "twice": [[null]],
        "lists": [null],
        "text": {"base64": "/w=="},
        "image": {"base64": "AAECAwQFBgcICQoLDA0ODxAREhMUFRYXGBkaGxwdHh8gISIjJCUmJw=="},
    });
    let mut record = Record::new(&ty);
    assert_eq!(record.take_over(&exact), Conversion::default());
    let written = record.to_exact_json();
    assert_eq!(written.value.to_string(), exact.to_string(), "-0 and 0 differ as texts");
    assert_eq!(written.left_out.listed(), ["driver"]);
    let plain = record.to_json();
    assert_eq!(plain["image"], json!(octets));
    assert_eq!((&plain["maybe"], &plain["twice"]), (&Value::Null, &Value::Null));
}

#[test]
fn members_are_taken_over_by_name_and_each_difference_is_told() {
    let old = structure(|t| {
        let (long, double) = (t.add(Kind::Long), t.add(Kind::Double));
        let text = t.add(Kind::String { bound: None });
        let mode = t.add(Kind::Enum {
            name: ScopedName::new(["mode"]),
            enumerators: vec!["IDLE".to_owned(), "MOVING".to_owned()],
        });
        let list = t.add(Kind::Sequence { element: double, bound: None });
        vec![
            member("count", long),
            member("speed", double),
            member("name", text),
            member("mode", mode),
            member("old", long),
            member("list", list),
            member("large", double),
        ]
    });
    let new = structure(|t| {
        let (long, double) = (t.add(Kind::Long), t.add(Kind::Double));
        let octet = t.add(Kind::Octet);
        let text = t.add(Kind::String { bound: Some(4) });
        let mode = t.add(Kind::Enum {
            name: ScopedName::new(["mode"]),
            enumerators: vec!["PAUSED".to_owned(), "MOVING".to_owned(), "IDLE".to_owned()],
        });
        let list = t.add(Kind::Sequence { element: double, bound: Some(2) });
        let maybe = t.add(Kind::Optional { element: double });
        vec![
            member("fresh", long),
            member("mode", mode),
            member("name", text),
            member("speed", long),
            member("count", maybe),
            member("list", list),
            member("large", octet),
        ]
    });
    let (mut from, mut into) = (Record::new(&old), Record::new(&new));
    from.merge_json(&json!({
        "count": 7, "speed": 2.6, "name": "aéé", "mode": "IDLE", "old": 1,
        "list": [1, 2, 3], "large": 300
    }))
    .unwrap();
    into.merge_json(&json!({"fresh": 9, "large": 4})).unwrap();
    let told = into.convert_from(&from);
    assert_eq!(
        told.lines(),
        [
            "fresh is new",
            "old is gone",
            "name: cut to 3 bytes",
            "speed: 2.6 is now 3",
            "list: 3 elements are now 2",
            "large: 300.0 is not between 0 and 255",
        ]
    );
    assert_eq!(
        into.to_json(),
        json!({"fresh": 9, "mode": "IDLE", "name": "aé", "speed": 3, "count": 7.0, "list": [1.0, 2.0], "large": 4})
    );
}

#[test]
fn a_union_whose_members_changed_keeps_what_its_discriminant_still_selects() {
    let choice = |names: [&str; 2]| {
        structure(|t| {
            let long = t.add(Kind::Long);
            let label = |label| vec![Label::Value(label)];
            let members = names.iter().zip(0..).map(|(name, at)| UnionMember {
                name: (*name).to_owned(),
                ty: long,
                labels: label(at),
            });
            let members = members.collect();
            let name = ScopedName::new(["choice"]);
            let choice = t.add(Kind::Union { name, discriminant: long, members });
            vec![member("c", choice)]
        })
    };
    let (mut from, mut into) = (Record::new(&choice(["a", "b"])), Record::new(&choice(["a", "z"])));
    from.merge_json(&json!({"c": {"d": 1, "u": {"b": 5}}})).unwrap();
    assert_eq!(into.convert_from(&from).lines(), ["c.z is new", "c.b is gone"]);
    from.merge_json(&json!({"c": {"d": 0, "u": {"a": 6}}})).unwrap();
    assert!(into.convert_from(&from).is_exact());
    assert_eq!(into.to_json(), json!({"c": {"d": 0, "u": {"a": 6}}}));
}

#[test]
fn reports_of_differences_are_limited() {
    let ty = structure(|t| {
        let octet = t.add(Kind::Octet);
        vec![member("list", t.add(Kind::Sequence { element: octet, bound: None }))]
    });
    let told = Record::new(&ty).take_over(&json!({"list": vec![300; 5000]}));
    assert_eq!(told.lines().len(), 101);
    assert_eq!(told.lines()[100], "and 4900 more");
}
