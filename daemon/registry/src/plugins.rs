//! Middlewares in libraries of their own, which command line and configuration name: by a path, or
//! by a name that is searched.

use std::env;
use std::path::{Path, PathBuf};

use genom_plugin_host::Library;
use toml::{Table, Value};

use crate::known::{BackendError, Known, LIBRARY, SectionError, add, check, known};

/// The variable that says where libraries of middlewares are searched, before the directory
/// `lib/genomd` beside that of the program.
pub const PATH: &str = "GENOMD_BACKEND_PATH";

/// Where a section says that the library is.
fn given(name: &str, section: Option<&Table>) -> Result<Option<PathBuf>, BackendError> {
    match section.and_then(|section| section.get(LIBRARY)) {
        None => Ok(None),
        Some(Value::String(path)) => Ok(Some(PathBuf::from(path))),
        Some(_) => {
            let why = SectionError::Refused(format!("{LIBRARY} has to be the path of a library"));
            Err(BackendError::Options { name: name.to_owned(), why })
        }
    }
}

/// Whether there may be a middleware of that name: the same as [`named`], but no library is opened.
///
/// # Errors
/// There is none.
pub fn has(name: &str, section: Option<&Table>) -> Result<(), BackendError> {
    match given(name, section)?.or_else(|| found(name)) {
        Some(_) => Ok(()),
        None => check(name).map(|_| ()),
    }
}

/// The middleware of that name, for who starts a daemon: one that is known, or that of the library
/// which its section of the configuration names, or which is found under its name.
///
/// # Errors
/// There is none, or the library is no middleware, or has another name.
pub fn named(name: &str, section: Option<&Table>) -> Result<Known, BackendError> {
    let path = given(name, section)?;
    if let Some(known) = known().iter().find(|known| known.name == name) {
        if let Some(path) = path.filter(|path| known.library() != Some(real(path).as_path())) {
            let other = known.library().map(|library| library.display().to_string());
            let other = other.unwrap_or_else(|| "one of its own".to_owned());
            return Err(BackendError::NameTaken { path, name: name.to_owned(), other });
        }
        return Ok(*known);
    }
    let Some(path) = path.or_else(|| found(name)) else { return check(name) };
    let library = open(name, &path)?;
    if library.name() != name {
        let (found, name) = (library.name().to_owned(), name.to_owned());
        return Err(BackendError::OtherName { path, found, name });
    }
    add(library)
}

/// The middleware of the library at this path.
///
/// # Errors
/// It is none, or its name is taken.
pub fn of_path(path: &Path) -> Result<Known, BackendError> {
    add(open(&path.display().to_string(), path)?)
}

fn open(name: &str, path: &Path) -> Result<&'static Library, BackendError> {
    Library::open(path).map_err(|why| BackendError::Library { name: name.to_owned(), why })
}

fn real(path: &Path) -> PathBuf {
    path.canonicalize().unwrap_or_else(|_| path.to_owned())
}

/// The library of that name: `libgenomd_NAME.so` in a directory of [`PATH`], or beside the program.
fn found(name: &str) -> Option<PathBuf> {
    let plain = |byte: u8| byte.is_ascii_lowercase() || byte.is_ascii_digit() || byte == b'_';
    if !name.bytes().all(plain) {
        return None;
    }
    let variable = env::var_os(PATH).unwrap_or_default();
    let program = env::current_exe().ok();
    let installed = program.as_deref().and_then(Path::parent).map(|dir| dir.join("../lib/genomd"));
    let file = format!("libgenomd_{name}.so");
    let places = env::split_paths(&variable).filter(|dir| dir.is_absolute()).chain(installed);
    places.map(|directory| directory.join(&file)).find(|path| path.is_file())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_is_no_path() {
        for name in ["../x", "/tmp/x", "a.b", "x/y"] {
            assert_eq!(found(name), None);
            assert!(matches!(named(name, None), Err(BackendError::Unknown { .. })));
        }
    }

    #[test]
    fn a_middleware_of_this_daemon_is_in_no_library() {
        let section: Table = toml::from_str("library = '/tmp/x.so'").unwrap();
        let told = named("zenoh", Some(&section)).map(|_| ()).unwrap_err().to_string();
        assert!(told.contains("this daemon has one already: one of its own"), "{told}");
        let section: Table = toml::from_str("library = 3").unwrap();
        let told = named("mine", Some(&section)).map(|_| ()).unwrap_err().to_string();
        assert_eq!(told, "[backends.mine]: library has to be the path of a library");
    }
}
