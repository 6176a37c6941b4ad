//! What the types of a port's layout are made of, for programs that read values of them.

use serde::Deserialize;
use serde_json::Number;

/// A type of [`PortType::types`](crate::PortType::types), without its place in memory. Types refer to
/// each other by index in that list.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(tag = "kind", rename_all = "lowercase")]
pub enum TypeKind {
    /// `boolean`.
    Boolean,
    /// `char`: a signed byte.
    Char,
    /// `octet`.
    Octet,
    /// `short`: 16 bits, signed.
    Short,
    /// `unsigned short`: 16 bits.
    #[serde(rename = "unsigned short")]
    UnsignedShort,
    /// `long`: 32 bits, signed.
    Long,
    /// `unsigned long`: 32 bits.
    #[serde(rename = "unsigned long")]
    UnsignedLong,
    /// `long long`: 64 bits, signed.
    #[serde(rename = "long long")]
    LongLong,
    /// `unsigned long long`: 64 bits.
    #[serde(rename = "unsigned long long")]
    UnsignedLongLong,
    /// `float`.
    Float,
    /// `double`.
    Double,
    /// `string`.
    String {
        /// Bytes, NUL included; `None` for an unbounded string.
        bound: Option<u32>,
    },
    /// An array.
    Array {
        /// Type of an element.
        element: u32,
        /// Number of elements.
        length: u32,
    },
    /// `sequence`.
    Sequence {
        /// Type of an element.
        element: u32,
        /// Greatest number of elements; `None` for an unbounded sequence.
        bound: Option<u32>,
    },
    /// `optional`.
    Optional {
        /// Type of the value when present.
        element: u32,
    },
    /// `enum`.
    Enum {
        /// `::SCOPE::NAME`.
        full_name: String,
        /// Short names in order.
        enumerators: Vec<String>,
    },
    /// `struct`.
    Struct {
        /// `::SCOPE::NAME`.
        full_name: String,
        /// Members in order of declaration.
        members: Vec<TypeMember>,
    },
    /// `union`.
    Union {
        /// `::SCOPE::NAME`.
        full_name: String,
        /// Type of the discriminant.
        discriminant: u32,
        /// Members in order of declaration.
        members: Vec<TypeMember>,
    },
}

/// A member of a struct or a union.
#[derive(Clone, Debug, PartialEq, Deserialize)]
pub struct TypeMember {
    /// Name as declared.
    pub name: String,
    /// Its type.
    #[serde(rename = "type")]
    pub ty: u32,
    /// The labels that select it, `None` for `default`; none for members of structs.
    #[serde(default)]
    pub labels: Vec<Option<Number>>,
}
