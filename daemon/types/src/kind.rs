//! The kinds of IDL types (GenoM3 manual, "IDL types"; genom3.md 2.5).

use std::fmt;

use serde::{Deserialize, Serialize};

/// Index of a type in its [`TypeTable`](crate::TypeTable).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
pub struct TypeId(pub(crate) u32);

impl TypeId {
    /// Position of the type in its table, from 0 in order of declaration.
    #[must_use]
    pub fn index(self) -> usize {
        self.0 as usize
    }
}

/// A full name such as `::demo::state`, outermost scope first.
#[derive(Clone, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
pub struct ScopedName(Vec<String>);

impl ScopedName {
    /// A name from its segments, outermost first.
    pub fn new<S: Into<String>>(segments: impl IntoIterator<Item = S>) -> Self {
        Self(segments.into_iter().map(Into::into).collect())
    }

    /// The segments, outermost first.
    #[must_use]
    pub fn segments(&self) -> &[String] {
        &self.0
    }

    /// The last segment, empty for the root.
    #[must_use]
    pub fn last(&self) -> &str {
        self.0.last().map_or("", String::as_str)
    }

    /// This name with one more segment.
    #[must_use]
    pub fn join(&self, segment: &str) -> Self {
        let mut segments = self.0.clone();
        segments.push(segment.to_owned());
        Self(segments)
    }

    /// The C name: segments joined by `_` (genom3.md 5.1).
    #[must_use]
    pub fn to_c(&self) -> String {
        self.0.join("_")
    }
}

impl fmt::Display for ScopedName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.iter().try_for_each(|segment| write!(f, "::{segment}"))
    }
}

/// The kind of a type, with the types it is made of.
#[derive(Clone, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum Kind {
    /// `boolean`, C `bool`.
    Boolean,
    /// `char`, C `int8_t`.
    Char,
    /// `octet`, C `uint8_t`.
    Octet,
    /// `short`, C `int16_t`.
    Short,
    /// `unsigned short`, C `uint16_t`.
    UnsignedShort,
    /// `long`, C `int32_t`.
    Long,
    /// `unsigned long`, C `uint32_t`.
    UnsignedLong,
    /// `long long`, C `int64_t`.
    LongLong,
    /// `unsigned long long`, C `uint64_t`.
    UnsignedLongLong,
    /// `float`.
    Float,
    /// `double`.
    Double,
    /// `string` (C `char *`) or `string<n>` (C `char[n]`, the NUL included).
    String {
        /// Bytes of the C array, NUL included; `None` for an unbounded string.
        bound: Option<u32>,
    },
    /// `T x[n]`; several dimensions are arrays of arrays, outermost first.
    Array {
        /// Type of an element.
        element: TypeId,
        /// Number of elements.
        length: u32,
    },
    /// `sequence<T>` or `sequence<T, n>`.
    Sequence {
        /// Type of an element.
        element: TypeId,
        /// Greatest number of elements; `None` for an unbounded sequence.
        bound: Option<u32>,
    },
    /// `optional<T>`.
    Optional {
        /// Type of the value when present.
        element: TypeId,
    },
    /// `enum`, C `uint32_t` counting from 0.
    Enum {
        /// Full name of the enum.
        name: ScopedName,
        /// Short names in order; their scope is the enum's own scope (genom3.md 4.2).
        enumerators: Vec<String>,
    },
    /// `struct`, also the IDS and the input, output and local records of a service.
    Struct {
        /// Full name of the struct.
        name: ScopedName,
        /// Members in order of declaration.
        members: Vec<Member>,
    },
    /// `union`.
    Union {
        /// Full name of the union.
        name: ScopedName,
        /// Boolean, char, integer or enum type, possibly behind typedefs.
        discriminant: TypeId,
        /// Members in order of declaration.
        members: Vec<UnionMember>,
    },
    /// `exception`; one without members is no data type (genom3.md N11).
    Exception {
        /// Full name of the exception.
        name: ScopedName,
        /// Members of the detail in order of declaration.
        members: Vec<Member>,
    },
    /// `typedef`: another name of `target`.
    Typedef {
        /// Full name of the typedef.
        name: ScopedName,
        /// The type it names.
        target: TypeId,
    },
    /// `struct X;` or `union X;` not completed yet; completing replaces the kind in place.
    Forward {
        /// Full name of the announced type.
        name: ScopedName,
        /// Whether it was announced as a union.
        union: bool,
    },
    /// `native`: a C type that only codels know; a pointer in memory.
    Native {
        /// Full name of the native type.
        name: ScopedName,
    },
    /// `any`: parses, and has no mapping.
    Any,
}

impl Kind {
    /// The Rust type of a number: the one of its size and sign (genom3.md 5.2); `None` for anything
    /// else. `char` of IDL is a signed byte.
    #[must_use]
    pub fn rust_number(&self) -> Option<&'static str> {
        Some(match self {
            Kind::Char => "i8",
            Kind::Octet => "u8",
            Kind::Short => "i16",
            Kind::UnsignedShort => "u16",
            Kind::Long => "i32",
            Kind::UnsignedLong => "u32",
            Kind::LongLong => "i64",
            Kind::UnsignedLongLong => "u64",
            Kind::Float => "f32",
            Kind::Double => "f64",
            _ => return None,
        })
    }

    /// The full name, for kinds that have one.
    #[must_use]
    pub fn name(&self) -> Option<&ScopedName> {
        match self {
            Kind::Enum { name, .. }
            | Kind::Struct { name, .. }
            | Kind::Union { name, .. }
            | Kind::Exception { name, .. }
            | Kind::Typedef { name, .. }
            | Kind::Forward { name, .. }
            | Kind::Native { name } => Some(name),
            _ => None,
        }
    }

    /// The types that it is made of, one after the other: element, target, members.
    #[must_use]
    pub fn parts(&self) -> Vec<TypeId> {
        self.clone().parts_mut().into_iter().map(|part| *part).collect()
    }

    pub(crate) fn parts_mut(&mut self) -> Vec<&mut TypeId> {
        match self {
            Kind::Array { element, .. }
            | Kind::Sequence { element, .. }
            | Kind::Optional { element } => vec![element],
            Kind::Typedef { target, .. } => vec![target],
            Kind::Struct { members, .. } | Kind::Exception { members, .. } => {
                members.iter_mut().map(|member| &mut member.ty).collect()
            }
            Kind::Union { discriminant, members, .. } => {
                let members = members.iter_mut().map(|member| &mut member.ty);
                std::iter::once(discriminant).chain(members).collect()
            }
            _ => Vec::new(),
        }
    }
}

/// A member of a struct or exception.
#[derive(Clone, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub struct Member {
    /// Name as declared; unique within the struct.
    pub name: String,
    /// Type as declared, typedefs included.
    pub ty: TypeId,
}

/// A member of a union, with the labels that select it.
#[derive(Clone, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub struct UnionMember {
    /// Name as declared; unique within the union.
    pub name: String,
    /// Type as declared, typedefs included.
    pub ty: TypeId,
    /// The `case` labels; at least one.
    pub labels: Vec<Label>,
}

/// A `case` label, as the integer the discriminant takes in memory.
///
/// Booleans are 0 and 1, chars their code, enumerators their rank.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum Label {
    /// `case N:`
    Value(i128),
    /// `default:`
    Default,
}
