//! Compares descriptors and layouts of data types with the C mapping (genom3.md 5.2).

#![allow(clippy::unwrap_used, reason = "it is a test")]

use std::ffi::CStr;

use genom::abi::{Kind, TypeDescriptor};
use genom::{
    Bool, BoundedSequence, BoundedString, Data, Enum, Enumeration, Exception, Native, NativeType,
    Optional, Sequence, Text,
};

#[derive(Clone, Copy, Debug, PartialEq, Data)]
#[genom(name = "::m::col")]
enum Colour {
    Red,
    Green,
}

#[derive(Data)]
#[genom(name = "::m::all")]
#[repr(C)]
struct All {
    a: i32,
    b: BoundedString<8>,
    c: Bool,
    r#type: Enum<Colour>,
    text: Text,
    optional: Optional<f32>,
    grid: [[i16; 3]; 2],
    points: BoundedSequence<f64, 4>,
    /// A struct may hold a sequence of itself.
    children: Sequence<All>,
}

#[derive(Clone, Copy, Exception)]
#[genom(name = "::m::e_sys")]
#[repr(C)]
struct Sys {
    code: i16,
    what: BoundedString<128>,
}

#[derive(Clone, Copy, Exception)]
#[genom(name = "::m::e_void")]
struct Void;

#[derive(NativeType)]
#[genom(name = "::m::driver")]
struct Driver {
    count: u32,
}

fn text(name: *const std::ffi::c_char) -> &'static str {
    // SAFETY: names in descriptors are NUL-terminated constants.
    unsafe { CStr::from_ptr(name) }.to_str().unwrap()
}

fn described<T: Data>() -> &'static TypeDescriptor {
    // SAFETY: descriptors are constants of this program.
    unsafe { &*T::TYPE }
}

fn members(ty: &TypeDescriptor) -> Vec<(&'static str, usize, Kind)> {
    // SAFETY: the descriptor is a constant of this program, and so are its members' types.
    unsafe { ty.members.as_slice() }
        .iter()
        .map(|member| (text(member.name), member.offset, unsafe { (*member.ty).kind }))
        .collect()
}

#[test]
fn a_struct_tells_name_size_and_members() {
    let ty = described::<All>();
    assert_eq!((ty.kind, text(ty.name)), (Kind::STRUCT, "::m::all"));
    // Offsets as measured with gcc on the C mapping of the same members.
    assert_eq!(
        members(ty),
        [
            ("a", 0, Kind::LONG),
            ("b", 4, Kind::STRING),
            ("c", 12, Kind::BOOLEAN),
            ("type", 16, Kind::ENUM),
            ("text", 24, Kind::STRING),
            ("optional", 32, Kind::OPTIONAL),
            ("grid", 40, Kind::ARRAY),
            ("points", 56, Kind::SEQUENCE),
            ("children", 96, Kind::SEQUENCE),
        ]
    );
    assert_eq!((ty.size, ty.align), (120, 8));
}

#[test]
fn a_recursive_struct_leads_back_to_itself() {
    // SAFETY: descriptors are constants of this program.
    let children = unsafe { &*described::<All>().members.as_slice()[8].ty };
    assert_eq!(children.bound, 0);
    assert!(std::ptr::eq(children.element, All::TYPE));
}

#[test]
fn templates_have_the_sizes_of_the_c_mapping() {
    let shape = |ty: &TypeDescriptor| (ty.size, ty.align, ty.bound);
    assert_eq!(shape(described::<Sequence<i32>>()), (24, 8, 0));
    assert_eq!(shape(described::<BoundedSequence<f64, 4>>()), (40, 8, 4));
    assert_eq!(shape(described::<BoundedSequence<BoundedString<4>, 2>>()), (16, 4, 2));
    assert_eq!(shape(described::<Optional<f32>>()), (8, 4, 0));
    assert_eq!(shape(described::<BoundedString<16>>()), (16, 1, 16));
    assert_eq!(shape(described::<Text>()), (8, 8, 0));
    assert_eq!(shape(described::<[[i16; 3]; 2]>()), (12, 2, 2));
    assert_eq!(shape(described::<Native<Driver>>()), (8, 8, 0));
}

#[test]
fn exceptions_describe_their_detail() {
    // SAFETY: descriptors are constants of this program.
    let (sys, void) = unsafe { (&*Sys::TYPE, &*Void::TYPE) };
    assert_eq!((sys.kind, text(sys.name)), (Kind::EXCEPTION, "::m::e_sys"));
    assert_eq!((sys.size, sys.align), (130, 2));
    assert_eq!(members(sys), [("code", 0, Kind::SHORT), ("what", 2, Kind::STRING)]);
    assert_eq!((void.size, members(void).len()), (0, 0));
    assert_eq!(Void::ID, c"::m::e_void");
}

#[test]
fn an_enum_lists_its_values_and_survives_a_bad_rank() {
    // SAFETY: descriptors are constants of this program.
    let values = unsafe { (*<Colour as Enumeration>::TYPE).members.as_slice() };
    assert_eq!(values.iter().map(|value| text(value.name)).collect::<Vec<_>>(), ["Red", "Green"]);

    let mut colour = Enum::from(Colour::Red);
    colour.set(Colour::Green);
    assert_eq!((colour.rank(), colour.get()), (1, Some(Colour::Green)));
    // SAFETY: an `Enum` holds any number.
    let bad: Enum<Colour> = unsafe { std::mem::transmute(7_u32) };
    assert_eq!(bad.get(), None);
    // SAFETY: a `Bool` holds any byte.
    let odd: Bool = unsafe { std::mem::transmute(2_u8) };
    assert!(odd.get());
}

#[test]
fn a_sequence_grows_shrinks_and_releases_what_it_owns() {
    let mut sequence: Sequence<Text> = ["a", "b", "c"].iter().map(|text| Text::new(text)).collect();
    sequence.push(Text::new("d"));
    sequence.push(Text::new("e"));
    sequence.truncate(4);
    sequence.reserve_exact(2);
    assert_eq!(sequence.iter().map(|text| text.to_str()).collect::<Vec<_>>(), ["a", "b"]);
    let copy = sequence.clone();
    sequence[0].set("other");
    sequence.clear();
    assert!(sequence.is_empty());
    assert_eq!(copy[0].to_str(), "a");
}

#[test]
fn bounded_types_refuse_or_cut_what_does_not_fit() {
    let mut sequence = BoundedSequence::<u8, 2>::default();
    assert_eq!((sequence.push(1), sequence.push(2), sequence.push(3)), (Ok(()), Ok(()), Err(3)));
    assert_eq!(*sequence, [1, 2]);

    // Three bytes of text fit; a character of two bytes is not split.
    assert_eq!(BoundedString::<4>::new("abé").to_str(), "ab");
    assert_eq!(BoundedString::<1>::new("abc").to_str(), "");
    // SAFETY: a bounded string holds any bytes; here a full one without NUL, as strncpy leaves.
    let full: BoundedString<3> = unsafe { std::mem::transmute(*b"abc") };
    assert_eq!(full.to_str(), "abc");
}

#[test]
fn a_native_is_null_until_set_and_comes_back_whole() {
    // SAFETY: all data is valid when zero.
    let mut native: Native<Driver> = unsafe { std::mem::zeroed() };
    assert!(native.get().is_none() && native.take().is_none());
    native.set(Driver { count: 1 });
    native.set(Driver { count: 2 });
    assert_eq!(native.take().map(|driver| driver.count), Some(2));
    assert!(native.get().is_none());
}
