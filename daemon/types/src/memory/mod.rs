//! Values in C memory: initialising, releasing, copying and inspecting them.
//!
//! Together with `cdr`, this is most of the crate's `unsafe` code. Callers guarantee that an
//! address holds a value of the type they name; lengths, pointers and flags read from it are still
//! checked, since foreign code wrote them.

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
