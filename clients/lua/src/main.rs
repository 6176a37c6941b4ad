//! `genom-lua`: what genomd starts for a cell with codels in Lua.

#![forbid(unsafe_code)]

use std::process::ExitCode;

fn main() -> ExitCode {
    ExitCode::from(genom_lua::run(std::env::args_os().skip(1)))
}
