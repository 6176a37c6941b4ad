//! The files of a component: finds its library and its description ([`locate`]), and reads the
//! description, which is kept for the next component that has it ([`Known`]).

#![forbid(unsafe_code)]

mod installed;
mod known;
mod locate;
mod undefined;

pub use known::{Description, Known, ReadError, Reading, Texts};
pub use locate::{LocateError, Located, component_name, locate, names_script};
pub use undefined::defined_in;
