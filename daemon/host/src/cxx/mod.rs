//! Components with `lang "c++"` (genom3.md 6): names, types, ports and exceptions of C++, without
//! generated code.
//!
//! Codels use C++ objects; the rest of the host uses records in C layout. Values are copied between
//! them where requests and port operations begin and end.

mod error;
mod exceptions;
mod facts;
mod functions;
mod layout;
mod life;
mod object;
mod path;
mod ports;
mod shim;
mod spelling;
mod transfer;

pub(crate) use error::{CxxPathError, CxxTypeError};
pub(crate) use exceptions::{Catcher, DetailError, Exceptions};
pub(crate) use functions::{Function, find};
pub(crate) use layout::CxxType;
pub(crate) use object::{Object, copy, to_c, to_cxx};
pub(crate) use path::CxxPath;
pub(crate) use ports::{Action, CxxPort, Handle};
pub(crate) use shim::Raise;
