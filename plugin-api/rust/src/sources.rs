//! The sources of this crate and of its macros, for programs that install them: components in Rust
//! can then be built from an installed genomd.

/// A file below `src`, and its text.
pub type Source = (&'static str, &'static str);

macro_rules! sources {
    ($($name:literal)*) => {
        /// The files of this crate.
        pub const SDK: &[Source] = &[$(($name, include_str!($name))),*];
    };
}

sources! {
    "abi.rs"
    "argument.rs"
    "component.rs"
    "context.rs"
    "data/enumeration.rs"
    "data/mod.rs"
    "data/native.rs"
    "data/optional.rs"
    "data/scalar.rs"
    "data/sequence.rs"
    "data/string.rs"
    "event.rs"
    "exception.rs"
    "lib.rs"
    "memory.rs"
    "outcome.rs"
    "port.rs"
    "remote.rs"
    "sources.rs"
}

/// The files of `genom-derive`.
pub const MACROS: &[Source] = genom_derive::sources!();
