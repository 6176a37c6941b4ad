//! `genomd`: runs GenoM3 components on a middleware chosen at run time. The program is the library of
//! this crate, which interpreters load as well.

#![forbid(unsafe_code)]

use std::process::ExitCode;

fn main() -> ExitCode {
    if let Some(code) = genom_cells::read_symbols() {
        return code;
    }
    if let Some(code) = genom_floor::asked() {
        return code;
    }
    ExitCode::from(genomd::run(std::env::args_os()))
}
