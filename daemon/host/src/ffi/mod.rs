//! Calls from Rust into C, and from C into Rust, with types known at run time only.

mod arguments;
mod call;
mod class;
mod closure;
mod registers;
mod slots;

pub(crate) use arguments::{Arguments, Callback};
pub(crate) use call::{Interface, Thrown};
pub(crate) use class::{Class, Scalar};
pub(crate) use closure::NativeFunction;
