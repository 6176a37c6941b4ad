//! Memory, functions and the library of genomd. The only unsafe module: what genomd says of addresses
//! and layouts is believed here, and nowhere else is an address used.
#![allow(unsafe_code)]

mod calls;
mod closure;
mod library;
mod log;
mod memory;
mod stuck;

pub(crate) use calls::{Class, Context, Function, codel, named, passed, raise, raised, simple};
pub(crate) use closure::{Arguments, Callee, Closure};
pub(crate) use library::{Runtime, Scripts};
pub(crate) use log::Log;
pub(crate) use memory::{At, Memory};
pub(crate) use stuck::{Running, StateAt, tell_lines, thread};

use mlua::{Lua, LuaOptions, StdLib};

/// A Lua state with all libraries. The prelude leaves scripts of `debug` what cannot break it.
pub(crate) fn lua() -> Lua {
    // SAFETY: modules in C, which `require` could load, do not link with this program, which exports no
    // functions of Lua; `debug` is taken from scripts before they run.
    unsafe { Lua::unsafe_new_with(StdLib::ALL, LuaOptions::default()) }
}
