//! The runner of codels in Lua (docs/lua.md): it loads genomd as a library, and makes C functions of the
//! functions of a script. What the two ask of each other is in docs/runners.md.
//!
//! Each component has a Lua state of its own, and a lock: of codels of one component, one runs at a time.
//! A codel that calls a service of another component is a coroutine, which yields to this code for the
//! time of the call, so that the lock is free meanwhile.

#![deny(unsafe_code)]

mod check;
mod codel;
mod events;
mod foreign;
mod handles;
mod layout;
mod limit;
mod loader;
pub mod measured;
mod names;
mod remotes;
mod request;
mod script;
mod seen;
mod state;
mod value;
mod view;

use std::ffi::OsString;
use std::fs;
use std::path::{Path, PathBuf};

use foreign::Runtime;
use loader::Loader;

/// The exit status of a runner that cannot run, whose reason is in the file [`REFUSAL`].
const REFUSED: u8 = 3;

/// Stands beside the configuration of a cell.
const REFUSAL: &str = "refusal";

/// Runs genomd with these arguments until it ends; returns its exit status.
pub fn run(arguments: impl IntoIterator<Item = OsString>) -> u8 {
    let arguments: Vec<OsString> = arguments.into_iter().collect();
    match Runtime::open(env!("CARGO_PKG_VERSION")) {
        Ok(runtime) => {
            for directory in read_later() {
                runtime.reads(&directory);
            }
            runtime.run(&arguments, Box::new(Loader::new(runtime.log())))
        }
        Err(why) => {
            if let Some(file) = refusal(&arguments) {
                // It is on standard error as well.
                let _ = fs::write(file, &why);
            }
            eprintln!("error: {why}");
            REFUSED
        }
    }
}

/// Where a cell tells why it does not run.
fn refusal(arguments: &[OsString]) -> Option<PathBuf> {
    arguments.iter().find(|word| *word == "--run-cell")?;
    let at = arguments.iter().position(|word| word == "--config")?;
    Some(Path::new(arguments.get(at + 1)?).parent()?.join(REFUSAL))
}

/// Directories of modules, which a sandbox has to leave open: those of `LUA_PATH`, and the usual ones.
fn read_later() -> Vec<PathBuf> {
    let usual = ["/usr/share/lua", "/usr/local/share/lua"].map(PathBuf::from);
    let named = ["LUA_PATH_5_4", "LUA_PATH"].into_iter().find_map(std::env::var_os);
    let named = named.map(|paths| paths.to_string_lossy().into_owned()).unwrap_or_default();
    let named = named.split(';').filter_map(|path| Some(PathBuf::from(path.split_once('?')?.0)));
    let all = named.filter(|path| path.is_absolute()).chain(usual);
    all.filter(|path| path.is_dir()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_a_cell_has_a_place_for_its_refusal() {
        let words = |words: &str| words.split(' ').map(OsString::from).collect::<Vec<_>>();
        let place = refusal(&words("--run-cell a --config /x/config.toml"));
        assert_eq!(place.as_deref(), Some(Path::new("/x/refusal")));
        assert_eq!(refusal(&words("--config /x/config.toml")), None);
        assert_eq!(refusal(&words("--run-cell a --config")), None);
    }
}
