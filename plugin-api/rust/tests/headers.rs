//! The C and C++ headers compile without warnings in every supported standard, and their
//! definitions work in a loaded library.

#![allow(clippy::unwrap_used, reason = "it is a test")]

use std::ffi::{CStr, c_char, c_int, c_void};
use std::path::{Path, PathBuf};
use std::process::Command;

use genom::ContextInterface;
use libloading::{Library, Symbol};

fn here(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(path)
}

/// Compiles `tests/headers/mapping.c` to a library; any warning is an error.
fn build(language: &str, standard: &str, directory: &Path) -> PathBuf {
    let compiler = if language == "c++" { "c++" } else { "cc" };
    let library = directory.join(format!("{standard}.so"));
    let output = Command::new(compiler)
        .args(["-x", language, &format!("-std={standard}")])
        .args(["-Wall", "-Wextra", "-Werror", "-pedantic", "-fPIC", "-shared"])
        .arg("-I")
        .arg(here("../include"))
        .arg("-I")
        .arg(here("tests"))
        .arg(here("tests/headers/mapping.c"))
        .arg("-o")
        .arg(&library)
        .output()
        .unwrap();
    assert!(output.status.success(), "{standard}: {}", String::from_utf8_lossy(&output.stderr));
    library
}

/// Stores the code of the system error in the variable that `data` points to.
extern "C" fn raise(
    exception: *const c_char,
    detail: *const c_void,
    size: usize,
    context: *const ContextInterface,
) -> *const c_char {
    assert_eq!(size, 4);
    // SAFETY: `data` is the address of an `i32`, and the detail of a system error is one.
    unsafe { *(*context).data.cast::<i32>() = *detail.cast::<i32>() };
    exception
}

extern "C" fn raised(_: *mut *const c_char, _: *const ContextInterface) -> *const c_void {
    std::ptr::null()
}

fn check(language: &str, standard: &str) {
    type Fails = extern "C" fn(i32, *const ContextInterface) -> *const c_char;
    type Starts = extern "C" fn(*const ContextInterface) -> *const c_char;

    let directory = tempfile::tempdir().unwrap();
    let path = build(language, standard, directory.path());
    let mut code = 0_i32;
    let context = ContextInterface { raise, raised, data: (&raw mut code).cast() };

    // SAFETY: the library is `mapping.c`, whose functions and data have these types.
    unsafe {
        let library = Library::new(&path).unwrap();
        let description: Symbol<'_, *const c_char> = library.get(c"genom_description").unwrap();
        let description = CStr::from_ptr(*description);
        assert_eq!(description.to_str().unwrap(), include_str!("tank.gen"));

        let grows: Symbol<'_, extern "C" fn() -> c_int> = library.get(c"grows").unwrap();
        assert_eq!(grows(), 0, "expectation of that number in `grows`");

        let fails: Symbol<'_, Fails> = library.get(c"fails").unwrap();
        assert!(fails(0, &context).is_null());
        let event = fails(5, &context);
        assert_eq!((CStr::from_ptr(event), code), (c"::genom::syserr", 5));
        let own: Symbol<'_, *const c_char> = library.get(c"genom_syserr_id").unwrap();
        assert_eq!(event, *own, "an event of the library is the symbol of that name");

        let starts: Symbol<'_, Starts> = library.get(c"starts").unwrap();
        assert_eq!(CStr::from_ptr(starts(&context)), c"::m::start");
    }
}

#[test]
fn headers_serve_c99() {
    check("c", "c99");
}

#[test]
fn headers_serve_c11() {
    check("c", "c11");
}

#[test]
fn headers_serve_gnu17() {
    check("c", "gnu17");
}

#[test]
fn headers_serve_cpp11() {
    check("c++", "c++11");
}

#[test]
fn headers_serve_cpp17() {
    check("c++", "c++17");
}
