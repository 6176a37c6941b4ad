//! Values in C memory: making, releasing, copying and looking at them.
//!
//! The `unsafe` of this crate is here and in `cdr`. Callers promise that an address holds a
//! value of the type they name; everything read from it (lengths, pointers, presence) is still
//! treated as written by foreign code.

mod copy;
mod edit;
mod raw;
mod shared;
mod view;

pub(crate) use copy::{copy, init, release, repair, set_text};
pub(crate) use edit::Edit;
pub(crate) use raw::{SequenceHeader, elements, integer, resize, text};
pub(crate) use shared::give_up;
pub(crate) use view::View;
