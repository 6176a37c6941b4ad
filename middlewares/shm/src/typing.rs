//! Names and layouts of IDL types in iceoryx2.
//!
//! | IDL | type name |
//! |---|---|
//! | `boolean` | `bool` |
//! | `char`, `octet` | `i8`, `u8` |
//! | `short` ... `unsigned long long` | `i16`, `u16`, `i32`, `u32`, `i64`, `u64` |
//! | `float`, `double` | `f32`, `f64` |
//! | `string<n>` | `[i8; n]` |
//! | `T x[n]` | `[T; n]`, outermost dimension last |
//! | struct, union, enum, exception | full name without the leading `::`: `demo::state` |
//! | bounded sequence, optional | IDL spelling, or the full name of its typedef in the same form |
//! | anything of variable size | slice of `u8`: a CDR message (with its encapsulation header), then 16 bytes that CDR readers ignore |
//!
//! A typedef of a named or basic type has the name of that type. Basic types have Rust's names, so
//! `publish_subscribe::<f64>()` reads a port of type `double`; a `#[repr(C)]` struct declares
//! `#[type_name("demo::state")]`, a Python `ctypes.Structure` has a static method `type_name()`.
//! Size and alignment are those of C; the user header is `()`.

use genom_types::{DataType, Kind};

/// Greatest length in bytes of an iceoryx2 type name.
pub const MAX_NAME: usize = 255;

/// A type as iceoryx2 sees it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Wire {
    /// Type name of the payload, or of one element of a slice.
    pub name: String,
    /// Size in bytes of the payload, or of one element of a slice.
    pub size: usize,
    /// Alignment in bytes of the payload, or of one element of a slice.
    pub align: usize,
    /// Whether the payload is a slice.
    pub slice: bool,
}

/// How values of the type are sent.
#[must_use]
pub fn wire(ty: &DataType) -> Wire {
    if ty.is_fixed_size() {
        Wire { name: type_name(ty), size: ty.size(), align: ty.align(), slice: false }
    } else {
        Wire { name: "u8".to_owned(), size: 1, align: 1, slice: true }
    }
}

/// The iceoryx2 type name of a type of fixed size.
#[must_use]
pub fn type_name(ty: &DataType) -> String {
    if let Some(number) = ty.kind().rust_number() {
        return number.to_owned();
    }
    match ty.kind() {
        Kind::Boolean => "bool".to_owned(),
        Kind::String { bound } => format!("[i8; {}]", bound.unwrap_or(0)),
        Kind::Array { length, .. } => {
            let element = ty.element().map_or_else(String::new, |element| type_name(&element));
            format!("[{element}; {length}]")
        }
        other => match other.name() {
            Some(name) => name.segments().join("::"),
            None => ty.name().trim_start_matches("::").to_owned(),
        },
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use genom_conformance::samples::{basic, image, note, state};

    #[test]
    fn basic_types_have_the_names_rust_gives_them() {
        assert_eq!(type_name(&basic(Kind::Double)), std::any::type_name::<f64>());
        assert_eq!(type_name(&basic(Kind::Boolean)), std::any::type_name::<bool>());
        assert_eq!(type_name(&basic(Kind::Octet)), std::any::type_name::<u8>());
        let name = basic(Kind::String { bound: Some(8) });
        assert_eq!(type_name(&name), std::any::type_name::<[i8; 8]>());
        let pixels = image().member(0).expect("pixels");
        assert_eq!(type_name(&pixels), std::any::type_name::<[u8; 4_194_304]>());
    }

    #[test]
    fn named_types_have_their_full_name() {
        assert_eq!(
            wire(&state()),
            Wire { name: "demo::state".to_owned(), size: 64, align: 8, slice: false }
        );
        assert!(wire(&note()).slice);
    }
}
