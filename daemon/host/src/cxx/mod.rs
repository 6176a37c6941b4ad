//! Components with `lang "c++"` (genom3.md 6): names, types, ports and exceptions of C++ without
//! any generated code.
//!
//! C++ objects are the codels' memory; records in C layout, which everything else of the host
//! works on, are filled from them and fill them where requests and ports begin and end.

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
