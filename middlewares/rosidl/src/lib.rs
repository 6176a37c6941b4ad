//! What IDL types are in ROS 2: names, members, hashes, and the `.msg`, `.srv` and `.action` text.
//!
//! [`Mapper`] says which messages carry the types of a description: what the backend puts on the
//! wire and what `genomctl ros2-package` writes. [`Library`] knows the messages of ROS itself, for
//! types that masquerade as one of them.
//!
//! Pure but for `Library`, which reads files where it is told to. It knows no DDS and no `.gen`
//! text.

#![forbid(unsafe_code)]

mod hash;
mod interface;
mod library;
mod map;
mod masquerade;
mod names;
mod package;
mod parse;
mod standard;
mod structure;
mod text;

pub use hash::{HashError, hash};
pub use interface::{Action, Base, Constant, Field, Interface, Message, Service, Shape};
pub use library::{Library, LibraryError};
pub use map::{MapError, Mapper, Place, Problem};
pub use masquerade::{Failure, Manner, MasqueradeError, Ours, Typed};
pub use names::{TypeName, masqueraded, message, service, service_of};
pub use package::{PackageError, Packages};
pub use parse::{Mistake, ParseError, parse};
pub use structure::{Difference, Find, compare};
