//! Values made by codels: memory is released by the function they chose, and their mistakes do no
//! harm.

#![allow(clippy::unwrap_used)] // also in helpers, where clippy.toml does not reach

use std::collections::HashSet;
use std::ffi::{c_char, c_void};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use genom_types::{DataType, Kind, Member, Record, ScopedName, TypeTable, foreign};
use serde_json::json;

unsafe extern "C" {
    fn strdup(text: *const c_char) -> *mut c_char;
}

/// `struct sequence_T` as codels see it.
#[repr(C)]
struct Sequence<T> {
    maximum: u32,
    length: u32,
    buffer: *mut T,
    release: Option<unsafe extern "C" fn(*mut c_void)>,
}

#[repr(C)]
struct State {
    name: *mut c_char,
    numbers: Sequence<i32>,
    names: Sequence<*mut c_char>,
}

/// `struct state { string name; sequence<long> numbers; sequence<string> names; }`
fn state() -> DataType {
    let mut t = TypeTable::default();
    let string = t.add(Kind::String { bound: None });
    let long = t.add(Kind::Long);
    let numbers = t.add(Kind::Sequence { element: long, bound: None });
    let names = t.add(Kind::Sequence { element: string, bound: None });
    let members = [("name", string), ("numbers", numbers), ("names", names)]
        .map(|(name, ty)| Member { name: name.to_owned(), ty })
        .into();
    let id = t.add(Kind::Struct { name: ScopedName::new(["state"]), members });
    DataType::new(&Arc::new(t), id).unwrap()
}

fn codel(record: &mut Record) -> &mut State {
    // SAFETY: the record is of type `state`, which C declares as `State`.
    unsafe { &mut *record.as_mut_ptr().cast() }
}

static RELEASED: AtomicUsize = AtomicUsize::new(0);

unsafe extern "C" fn release(_buffer: *mut c_void) {
    RELEASED.fetch_add(1, Ordering::SeqCst);
}

#[test]
fn buffers_of_codels_go_back_through_their_release() {
    let mut numbers = [1, 2, 3];
    let mut record = Record::new(&state());
    let it = codel(&mut record);
    it.numbers =
        Sequence { maximum: 3, length: 2, buffer: numbers.as_mut_ptr(), release: Some(release) };
    // SAFETY: a string for the C library.
    it.name = unsafe { strdup(c"made by a codel".as_ptr()) };
    let copy = record.clone();
    drop(record);
    assert_eq!(RELEASED.load(Ordering::SeqCst), 1);
    let shown = json!({"name": "made by a codel", "numbers": [1, 2], "names": []});
    assert_eq!(copy.to_json(), shown);
    drop(copy);
    assert_eq!(RELEASED.load(Ordering::SeqCst), 1, "the copy has a buffer of its own");
}

#[test]
fn static_buffers_are_never_freed() {
    let mut numbers = [7; 4];
    let mut record = Record::new(&state());
    codel(&mut record).numbers =
        Sequence { maximum: 4, length: 4, buffer: numbers.as_mut_ptr(), release: None };
    record.merge_json(&json!({"numbers": [1, 2, 3, 4, 5]})).unwrap();
    assert_eq!(record.to_json()["numbers"], json!([1, 2, 3, 4, 5]));
    assert_eq!(numbers, [7; 4]);
}

#[test]
fn a_buffer_lent_without_its_maximum_counts_as_long_as_it_says() {
    // As codels do to show an image without copying it: they set no `_maximum`.
    let mut numbers = [4, 5, 6];
    let mut record = Record::new(&state());
    codel(&mut record).numbers =
        Sequence { maximum: 0, length: 3, buffer: numbers.as_mut_ptr(), release: None };
    assert_eq!(record.to_json()["numbers"], json!([4, 5, 6]));
    assert_eq!(record.clone().to_json()["numbers"], json!([4, 5, 6]));
    let (mut payload, mut other) = (Vec::new(), Record::new(&state()));
    record.encode_cdr(&mut payload).unwrap();
    other.decode_cdr(&payload).unwrap();
    assert_eq!(other.to_json()["numbers"], json!([4, 5, 6]));
    record.merge_json(&json!({"numbers": [1]})).unwrap();
    assert_eq!(record.to_json()["numbers"], json!([1]));
    assert_eq!(numbers, [4, 5, 6], "what was lent is not ours to write");
}

#[test]
fn what_a_lent_buffer_points_to_is_not_freed() {
    // Freeing string literals would abort the process.
    let mut names = [c"one".as_ptr().cast_mut(), c"two".as_ptr().cast_mut()];
    let lent = |buffer| Sequence { maximum: 2, length: 2, buffer, release: None };
    let mut record = Record::new(&state());
    codel(&mut record).names = lent(names.as_mut_ptr());
    let copy = record.clone();
    record.merge_json(&json!({"names": ["three"]})).unwrap();
    assert_eq!(record.to_json()["names"], json!(["three"]));
    codel(&mut record).names = lent(names.as_mut_ptr());
    drop(record);
    assert_eq!(copy.to_json()["names"], json!(["one", "two"]));
}

#[test]
fn what_two_records_point_to_is_freed_once() {
    let mut one = Record::new(&state());
    one.merge_json(&json!({"name": "n", "numbers": [1], "names": ["a", "b"]})).unwrap();
    let mut two = Record::new(&state());
    // SAFETY: what a codel does with `*two = *one`; freeing twice would abort.
    unsafe { std::ptr::copy_nonoverlapping(one.as_ptr(), two.as_mut_ptr(), state().size()) };
    let mut seen = HashSet::new();
    one.give_up_shared(&mut seen);
    two.give_up_shared(&mut seen);
    assert_eq!(two.to_json(), json!({"name": "", "numbers": [], "names": []}));
    drop(two);
    assert_eq!(one.to_json(), json!({"name": "n", "numbers": [1], "names": ["a", "b"]}));
}

#[test]
fn wrong_lengths_are_read_as_far_as_there_is_memory() {
    let mut numbers = [4, 5];
    let mut record = Record::new(&state());
    let it = codel(&mut record);
    it.numbers = Sequence { maximum: 2, length: 900, buffer: numbers.as_mut_ptr(), release: None };
    it.names = Sequence { maximum: 9, length: 9, buffer: std::ptr::null_mut(), release: None };
    let shown = json!({"name": "", "numbers": [4, 5], "names": []});
    assert_eq!(record.to_json(), shown);
    assert_eq!(record.clone().to_json(), shown);
    let (mut payload, mut other) = (Vec::new(), Record::new(&state()));
    record.encode_cdr(&mut payload).unwrap();
    other.decode_cdr(&payload).unwrap();
    assert_eq!(other.to_json(), shown);
}

#[test]
fn values_at_addresses_of_others_change_as_records_do() {
    let ty = state();
    let mut owner = Record::new(&ty);
    let at = owner.as_mut_ptr();
    // SAFETY: the address holds a value of the type, used here only.
    unsafe {
        foreign::merge_json_at(&ty, at, &json!({"names": ["a", "b"]})).unwrap();
        assert!(foreign::merge_json_at(&ty, at, &json!({"names": ["c"], "nam": 1})).is_err());
        let shown = json!({"name": "", "numbers": [], "names": ["a", "b"]});
        assert_eq!(foreign::json_of(&ty, at), shown);
        let mut payload = Vec::new();
        foreign::encode_cdr_of(&ty, at, &mut payload).unwrap();
        foreign::release_value(&ty, at);
        let mut copy = Record::new(&ty);
        copy.decode_cdr(&payload).unwrap();
        foreign::copy_value(&ty, copy.as_ptr(), at);
        drop(copy);
        assert_eq!(foreign::json_of(&ty, at), shown);
    }
}
