//! IDL types in ROS 2: their names, members and hashes, and `.msg`, `.srv` and `.action` text.
//!
//! [`Mapper`] determines the messages for the types of a description. The ROS 2 backend sends
//! these, and `genomctl ros2-package` writes them to files. [`Library`] has the definitions of
//! ROS's own messages, for types that masquerade as one of them.
//!
//! Only `Library` does I/O: it reads files from given folders. This crate uses no DDS and reads no
//! `.gen` text.

#![forbid(unsafe_code)]

mod description;
mod hash;
mod interface;
mod library;
mod map;
mod masquerade;
mod names;
mod package;
mod parse;
mod source;
mod standard;
mod structure;
mod text;

pub use description::{Description, FieldType, Missing, fields};
pub use hash::hash;
pub use interface::{Action, Base, Constant, Field, Interface, Message, Service, Shape};
pub use library::{Library, LibraryError};
pub use map::{MapError, Mapper, Place, Problem};
pub use masquerade::{Failure, Manner, MasqueradeError, Ours, Typed};
pub use names::{TypeName, masqueraded, message, service, service_of};
pub use package::{PackageError, Packages};
pub use parse::{Mistake, ParseError, parse};
pub use source::{Source, sources};
pub use structure::{Difference, Find, compare};
