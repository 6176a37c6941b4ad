//! How arguments of codels are passed (genom3.md 5.5).

use genom_description::model::Direction;
use genom_types::Kind;

/// How an argument is passed in the C ABI.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Class {
    /// By value.
    Value(Scalar),
    /// A pointer that is stored in the object (`in` strings and natives).
    Held,
    /// The address of the object.
    Address,
}

/// A C type that fits a register.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs)]
pub(crate) enum Scalar {
    Bool,
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    I64,
    U64,
    F32,
    F64,
}

impl Class {
    /// The class in C++ (genom3.md 6): strings are passed by reference, as objects are.
    pub(crate) fn of_cxx(kind: &Kind, direction: Direction) -> Self {
        match kind {
            Kind::String { .. } => Self::Address,
            _ => Self::of(kind, direction),
        }
    }

    /// The class of an argument of this kind (typedefs resolved) and direction.
    pub(crate) fn of(kind: &Kind, direction: Direction) -> Self {
        if direction != Direction::In {
            return Self::Address;
        }
        match kind {
            Kind::Boolean => Self::Value(Scalar::Bool),
            Kind::Char => Self::Value(Scalar::I8),
            Kind::Octet => Self::Value(Scalar::U8),
            Kind::Short => Self::Value(Scalar::I16),
            Kind::UnsignedShort => Self::Value(Scalar::U16),
            Kind::Long => Self::Value(Scalar::I32),
            Kind::UnsignedLong | Kind::Enum { .. } => Self::Value(Scalar::U32),
            Kind::LongLong => Self::Value(Scalar::I64),
            Kind::UnsignedLongLong => Self::Value(Scalar::U64),
            Kind::Float => Self::Value(Scalar::F32),
            Kind::Double => Self::Value(Scalar::F64),
            Kind::String { bound: None } | Kind::Native { .. } => Self::Held,
            _ => Self::Address,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use genom_types::ScopedName;

    #[test]
    fn a_string_is_passed_by_its_pointer_when_in_and_by_the_address_of_it_when_out() {
        let string = Kind::String { bound: None };
        assert_eq!(Class::of(&string, Direction::In), Class::Held);
        assert_eq!(Class::of(&string, Direction::Out), Class::Address);
        assert_eq!(Class::of(&Kind::String { bound: Some(8) }, Direction::In), Class::Address);
    }

    #[test]
    fn an_enum_is_an_unsigned_32_bit_integer() {
        let kind = Kind::Enum { name: ScopedName::new(["e"]), enumerators: vec!["A".into()] };
        assert_eq!(Class::of(&kind, Direction::In), Class::Value(Scalar::U32));
        assert_eq!(Class::of(&kind, Direction::InOut), Class::Address);
    }
}
