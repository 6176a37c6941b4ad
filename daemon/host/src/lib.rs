//! Foreign code: opens libraries of codels, checks them against their description, and calls them.
//!
//! [`Library`] opens a private copy of a file; [`Component`] is one instance of a component with
//! that library: the [`Body`](genom_runtime::body::Body) that the runtime runs. Modules with unsafe
//! code say so in their first lines; all others are safe.

#![deny(unsafe_code)]

pub mod component;
mod context;
pub mod contract;
mod crash_note;
mod cxx;
mod detail;
mod events;
mod exchanged;
mod ffi;
mod last_words;
pub mod library;
mod ports;
mod process;
mod remotes;
mod running;
mod shared;
mod what;

pub use component::{
    CannotExchange, Component, Conversions, LoadError, LoadErrors, MemoryCheck, check_memory,
};
pub use crash_note::{note_crashes_in, wait_for_dumps_at};
pub use genom_elf::languages;
pub use genom_interpreter as interpreter;
pub use last_words::{abort_in, end_is_ours, tell_last_words};
pub use library::{Contents, Digest, EmbeddedDescription, Library, OpenError, is_script};
pub use process::{
    KeptProcess, StandardError, guard_process, keep_from_children, keep_off, raised_to_stop,
    signal_name, take_variable, without_leftovers,
};
