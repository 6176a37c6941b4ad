//! Records are zero at first, copied deep and released, and refuse bytes that are no values.

#![allow(clippy::unwrap_used)] // also in helpers, where clippy.toml does not reach

use std::sync::Arc;

use genom_types::{
    CompiledPath, DataType, Kind, Label, LayoutError, Member, PathError, PathStep, Record,
    ScopedName, TypeId, TypeTable, UnionMember, foreign,
};

fn member(name: &str, ty: TypeId) -> Member {
    Member { name: name.to_owned(), ty }
}

fn record_of(build: impl FnOnce(&mut TypeTable) -> TypeId) -> DataType {
    let mut table = TypeTable::default();
    let id = build(&mut table);
    DataType::new(&Arc::new(table), id).unwrap()
}

#[test]
fn layouts_are_the_measured_ones() {
    // genom3.md 5.10, "Layouts measured".
    let ty = record_of(|t| {
        let members = vec![
            member("a", t.add(Kind::Long)),
            member("b", t.add(Kind::String { bound: Some(8) })),
            member("c", t.add(Kind::Boolean)),
        ];
        t.add(Kind::Struct { name: ScopedName::new(["s"]), members })
    });
    assert_eq!((ty.size(), ty.align(), &ty.layout().offsets[..]), (16, 4, &[0, 4, 12][..]));
    let ty = record_of(|t| {
        let element = t.add(Kind::Double);
        t.add(Kind::Sequence { element, bound: Some(4) })
    });
    assert_eq!((ty.size(), ty.align(), ty.layout().offsets[2]), (40, 8, 8));
    let ty = record_of(|t| {
        let element = t.add(Kind::Float);
        t.add(Kind::Optional { element })
    });
    assert_eq!((ty.size(), ty.align(), &ty.layout().offsets[..]), (8, 4, &[4][..]));
}

#[test]
fn a_new_record_is_zero_with_the_maximum_of_bounded_sequences_set() {
    let ty = record_of(|t| {
        let long = t.add(Kind::Long);
        let element = t.add(Kind::Sequence { element: long, bound: Some(3) });
        t.add(Kind::Array { element, length: 2 })
    });
    let record = Record::new(&ty);
    let words: Vec<u32> = record
        .bytes()
        .unwrap()
        .chunks(4)
        .map(|word| u32::from_le_bytes(word.try_into().unwrap()))
        .collect();
    assert_eq!(words, [3, 0, 0, 0, 0, 3, 0, 0, 0, 0]);
}

#[test]
fn bytes_that_are_no_value_change_nothing() {
    let ty = record_of(|t| {
        let color = t.add(Kind::Enum {
            name: ScopedName::new(["color"]),
            enumerators: vec!["RED".to_owned(), "BLUE".to_owned()],
        });
        let list = t.add(Kind::Sequence { element: color, bound: Some(2) });
        let members = vec![member("on", t.add(Kind::Boolean)), member("list", list)];
        t.add(Kind::Struct { name: ScopedName::new(["s"]), members })
    });
    let mut record = Record::new(&ty);
    let words = |words: [u32; 5]| words.map(u32::to_le_bytes).concat();
    record.set_bytes(&words([7, 99, 1, 1, 0])).unwrap();
    // The boolean is 1 and the maximum 2, as declared.
    assert_eq!(record.bytes().unwrap()[0], 1);
    assert_eq!(record.bytes().unwrap()[4..], words([1, 2, 1, 1, 0])[4..]);
    let before = record.bytes().unwrap().to_vec();
    assert!(record.set_bytes(&words([1, 2, 3, 0, 0])).is_err(), "longer than its bound");
    assert!(record.set_bytes(&words([1, 2, 1, 2, 0])).is_err(), "enum out of range");
    assert!(record.set_bytes(&[0]).is_err(), "size");
    assert_eq!(record.bytes().unwrap(), before);
}

#[test]
fn types_without_mapping_are_refused() {
    let mut t = TypeTable::default();
    let any = t.add(Kind::Any);
    let name = ScopedName::new(["s"]);
    let forward = t.add(Kind::Forward { name: name.clone(), union: false });
    let void = t.add(Kind::Exception { name: name.clone(), members: vec![] });
    let own = t.add(Kind::Forward { name: name.clone(), union: false });
    let pair = t.add(Kind::Array { element: own, length: 2 });
    t.complete(own, Kind::Struct { name, members: vec![member("kids", pair)] });
    let octet = t.add(Kind::Octet);
    let row = t.add(Kind::Array { element: octet, length: u32::MAX });
    let nothing = t.add(Kind::Array { element: octet, length: 0 });
    let nothings = t.add(Kind::Array { element: nothing, length: u32::MAX });
    let empties = t.add(Kind::Sequence { element: nothing, bound: None });
    let t = Arc::new(t);
    let error = |id| DataType::new(&t, id).unwrap_err();
    assert_eq!(error(any), LayoutError::Any);
    assert!(matches!(error(forward), LayoutError::Incomplete { .. }));
    assert!(matches!(error(void), LayoutError::Void { .. }));
    assert!(matches!(error(own), LayoutError::Recursive { .. }));
    assert!(matches!(error(row), LayoutError::TooLarge { .. }));
    assert!(matches!(error(nothings), LayoutError::TooLarge { .. }));
    assert!(matches!(error(empties), LayoutError::EmptyElement { .. }));
    assert_eq!(DataType::new(&t, nothing).unwrap().size(), 0);
}

#[test]
fn unions_switched_by_reals_and_bottomless_nesting_are_refused() {
    let mut t = TypeTable::default();
    let double = t.add(Kind::Double);
    let label = UnionMember { name: "x".to_owned(), ty: double, labels: vec![Label::Default] };
    let union = t.add(Kind::Union {
        name: ScopedName::new(["u"]),
        discriminant: double,
        members: vec![label],
    });
    let mut deep = double;
    for level in 0..100_000 {
        let name = ScopedName::new([format!("s{level}")]);
        deep = t.add(Kind::Struct { name, members: vec![member("x", deep)] });
    }
    let t = Arc::new(t);
    let error = |id| DataType::new(&t, id).unwrap_err();
    assert!(matches!(error(union), LayoutError::Discriminant { .. }));
    assert!(matches!(error(deep), LayoutError::TooDeep { .. }));
    // Names, digests and comparisons of such a type terminate too.
    assert!(!t.digest(deep).is_empty() && t.equal(deep, deep) && t.is_fixed_size(deep));
}

#[test]
fn types_of_two_tables_are_compared_by_structure() {
    let pair = |name: &str, second: Kind| {
        record_of(|t| {
            let members = vec![member("a", t.add(Kind::Long)), member("b", t.add(second))];
            t.add(Kind::Struct { name: ScopedName::new([name]), members })
        })
    };
    let (one, same) = (pair("one", Kind::Float), pair("same", Kind::Float));
    let mut target = Record::new(&same);
    target.copy_from(&Record::new(&one)).unwrap();
    let error = target.copy_from(&Record::new(&pair("one", Kind::Long))).unwrap_err();
    assert_eq!(error.to_string(), "cannot copy a value of type ::one into one of type ::same");
}

#[test]
fn a_path_goes_through_optionals_arrays_and_sequences() {
    let ty = record_of(|t| {
        let long = t.add(Kind::Long);
        let point = t.add(Kind::Struct {
            name: ScopedName::new(["p"]),
            members: vec![member("x", long), member("y", long)],
        });
        let maybe = t.add(Kind::Optional { element: point });
        let some = t.add(Kind::Array { element: maybe, length: 3 });
        let list = t.add(Kind::Sequence { element: point, bound: None });
        let few = t.add(Kind::Sequence { element: point, bound: Some(2) });
        let members = vec![member("some", some), member("list", list), member("few", few)];
        t.add(Kind::Struct { name: ScopedName::new(["s"]), members })
    });
    use PathStep::{Index, Member};
    let y = CompiledPath::new(&ty, &[Member(0), Index(2), Member(1)]).unwrap();
    // Two optionals of 12 bytes, `_present` and padding, `x`.
    assert_eq!(y.constant_offset(), Some(24 + 4 + 4));
    assert_eq!(y.target().name(), "long");
    let mut record = Record::new(&ty);
    let few = CompiledPath::new(&ty, &[Member(2), Index(1), Member(1)]).unwrap();
    let list = CompiledPath::new(&ty, &[Member(1), Index(0)]).unwrap();
    assert_eq!((few.constant_offset(), list.constant_offset()), (None, None));
    let base = record.as_mut_ptr();
    let few_at = ty.member_offset(2).unwrap();
    // SAFETY: the record is of the paths' root type; `_length` is within the bound.
    unsafe {
        assert!(few.locate(base).is_none() && list.locate(base).is_none());
        base.add(few_at + 4).cast::<u32>().write(2);
        assert_eq!(few.locate(base), Some(base.add(few_at + 8 + 8 + 4)));
        // A length beyond the maximum, without a buffer: an error of foreign code must not crash.
        base.add(ty.member_offset(1).unwrap() + 4).cast::<u32>().write(9);
        assert!(list.locate(base).is_none());
    }
    assert!(matches!(
        CompiledPath::new(&ty, &[Member(0), Index(3)]),
        Err(PathError::Element { length: 3, .. })
    ));
    assert!(matches!(CompiledPath::new(&ty, &[Member(9)]), Err(PathError::Member { .. })));
}

#[test]
fn foreign_values_are_copied_and_released() {
    let ty = record_of(|t| {
        let element = t.add(Kind::Long);
        t.add(Kind::Sequence { element, bound: Some(2) })
    });
    let mut memory = [0u32; 4];
    let at = memory.as_mut_ptr().cast::<u8>();
    let mut record = Record::new(&ty);
    // SAFETY: the memory is zeroed, aligned and as large as the type.
    unsafe {
        foreign::init_value(&ty, at);
        at.add(4).cast::<[u32; 3]>().write([1, 8, 0]);
        foreign::copy_value(&ty, at, record.as_mut_ptr());
        foreign::release_value(&ty, at);
    }
    assert_eq!(memory, [2, 0, 0, 0]);
    assert_eq!(record.bytes().unwrap(), [2, 1, 8, 0].map(u32::to_le_bytes).concat());
}
