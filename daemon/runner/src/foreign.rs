//! What the interpreter calls, and what it is called by. The only unsafe module.
#![allow(unsafe_code)]

use std::ffi::{CStr, OsString, c_char, c_int};
use std::os::unix::ffi::OsStringExt as _;
use std::path::PathBuf;
use std::sync::{Mutex, PoisonError};
use std::time::Duration;

use genom_description::model::Span;
use genom_host::Contents;
use genom_host::interpreter::{self, Given, Interpreter};
use genom_runtime::plan::Plan;

use crate::loaded::{LARGEST, Loaded, understand};
use crate::script;

unsafe extern "C" {
    /// Of the host: reports who ends the process, as for functions of the C library that do.
    fn genom_host_process_ends(how: *const c_char) -> bool;
}

/// Loads a script: gets a description of it as JSON, and gives the result to [`genom_answer`] before it
/// returns.
type Load = unsafe extern "C" fn(request: *const u8, size: usize, answer: *mut Answer);

/// Forgets a script that was loaded, by its number: nothing calls its functions any more.
type Release = unsafe extern "C" fn(number: u64);

/// Writes into the log at which lines the codel of this name is.
type Where = unsafe extern "C" fn(codel: *const u8, size: usize);

/// Takes what the interpreter says of a script.
pub struct Answer(Vec<u8>);

/// The runner that has this process.
struct Runner {
    language: String,
    load: Load,
    release: Release,
    tells_where: Where,
}

/// Where the interpreter imports from.
static READS: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

/// A script that is loaded.
struct Kept {
    number: u64,
    release: Release,
}

impl Drop for Kept {
    fn drop(&mut self) {
        // SAFETY: the interpreter passed this function, and lives as long as the process.
        unsafe { (self.release)(self.number) };
    }
}

impl Interpreter for Runner {
    fn language(&self) -> &str {
        &self.language
    }

    fn load(
        &self,
        script: &Contents,
        plan: &Plan,
        within: Duration,
        locate: &dyn Fn(Span) -> String,
    ) -> Result<Given, Vec<String>> {
        let request = script::request(script, plan, within, locate)?;
        let mut answer = Answer(Vec::new());
        // SAFETY: the interpreter passed this function, and lives as long as the process; the request
        // and the answer live until it returns, and it keeps neither.
        unsafe { (self.load)(request.as_ptr(), request.len(), &raw mut answer) };
        let Loaded { functions, events, number } = understand(&answer.0)?;
        let kept = Box::new(Kept { number, release: self.release });
        Ok(Given { functions, events, kept })
    }

    fn reads(&self) -> Vec<PathBuf> {
        READS.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    fn tell_where(&self, codel: &str) {
        // SAFETY: the interpreter passed this function, and lives as long as the process; the name
        // lives until it returns.
        unsafe { (self.tells_where)(codel.as_ptr(), codel.len()) };
    }
}

/// Says that this process reads what is in a directory; to be called before [`genom_run`].
///
/// # Safety
/// `directory` is a C string.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn genom_reads(directory: *const c_char) {
    // SAFETY: the caller's promise.
    let text = unsafe { CStr::from_ptr(directory) };
    let directory = PathBuf::from(OsString::from_vec(text.to_bytes().to_vec()));
    READS.lock().unwrap_or_else(PoisonError::into_inner).push(directory);
}

/// Runs `genomd` with these arguments, its name first, as a process that can load scripts of a
/// language, named as in `lang`; returns its exit status.
///
/// # Safety
/// `language` is a C string. `arguments` are `count` C strings. The functions may be called from any thread until the process
/// ends, and do what their types say. The process calls this once.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn genom_run(
    language: *const c_char,
    count: usize,
    arguments: *const *const c_char,
    load: Load,
    release: Release,
    tells_where: Where,
) -> c_int {
    let argument = |rank| {
        // SAFETY: the caller's promise.
        let text = unsafe { CStr::from_ptr(*arguments.add(rank)) };
        OsString::from_vec(text.to_bytes().to_vec())
    };
    let arguments: Vec<OsString> = (0..count).map(argument).collect();
    // SAFETY: the caller's promise.
    let language = unsafe { CStr::from_ptr(language) }.to_string_lossy().into_owned();
    interpreter::set(Box::new(Runner { language, load, release, tells_where }));
    c_int::from(genomd::run(arguments))
}

/// Takes the answer of a load: JSON.
///
/// # Safety
/// `answer` was passed to the load that has not returned yet; `text` has `size` bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn genom_answer(answer: *mut Answer, text: *const u8, size: usize) {
    // So much of one that is too large shows that it is.
    let size = size.min(LARGEST + 1);
    // SAFETY: the caller's promise.
    unsafe { (*answer).0 = std::slice::from_raw_parts(text, size).to_vec() };
}

/// Writes an entry of the log: an error of a codel, with the lines where it happened.
///
/// # Safety
/// `text` has `size` bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn genom_log(text: *const u8, size: usize) {
    // SAFETY: the caller's promise.
    let text = unsafe { std::slice::from_raw_parts(text, size) };
    tracing::error!("{}", String::from_utf8_lossy(text));
}

/// Says that the calling thread is about to end the process by `os._exit`.
#[unsafe(no_mangle)]
pub extern "C" fn genom_exits() {
    // SAFETY: it takes a C string.
    unsafe { genom_host_process_ends(c"os._exit".as_ptr()) };
}

/// The version of this library, which is that of the package `genom`.
#[unsafe(no_mangle)]
pub extern "C" fn genom_version() -> *const c_char {
    const VERSION: &str = concat!(env!("CARGO_PKG_VERSION"), "\0");
    VERSION.as_ptr().cast()
}
