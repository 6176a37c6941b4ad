//! Values in C memory: making, releasing, copying and looking at them.
//!
//! The `unsafe` of this crate is here and in `cdr`. Callers promise that an address holds a
//! value of the type they name; everything read from it (lengths, pointers, presence) is still
//! treated as written by foreign code.

mod copy;
mod edit;
mod life;
mod raw;
mod repair;
mod resize;
mod shared;
mod view;

pub(crate) use copy::{copy, set_text};
pub(crate) use edit::Edit;
pub(crate) use life::{init, release};
pub(crate) use raw::{SequenceHeader, elements, integer, text};
pub(crate) use repair::repair;
pub(crate) use resize::resize;
pub(crate) use shared::give_up;
pub(crate) use view::View;
