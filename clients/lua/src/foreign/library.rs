//! genomd as a library.

use std::ffi::{CStr, CString, OsString, c_char, c_int, c_void};
use std::os::unix::ffi::OsStringExt as _;
use std::path::Path;
use std::sync::OnceLock;

use libloading::Library;

use super::log::{Log, Write};

/// Names the library.
const VARIABLE: &str = "GENOM_RUNTIME";

type Load = unsafe extern "C" fn(*const u8, usize, *mut c_void);
type Release = unsafe extern "C" fn(u64);
type Where = unsafe extern "C" fn(*const u8, usize);
type Run =
    unsafe extern "C" fn(*const c_char, usize, *const *const c_char, Load, Release, Where) -> c_int;
type Answer = unsafe extern "C" fn(*mut c_void, *const u8, usize);
type Reads = unsafe extern "C" fn(*const c_char);

/// The library, which stays as long as the process.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Runtime {
    run: Run,
    answer: Answer,
    log: Write,
    reads: Reads,
}

/// What the functions that genomd calls work on.
struct Running {
    scripts: Box<dyn Scripts>,
    answer: Answer,
}

static RUNNING: OnceLock<Running> = OnceLock::new();

/// The scripts of this process, as genomd asks for them.
pub(crate) trait Scripts: Send + Sync {
    /// The answer to a request.
    fn load(&self, request: &[u8]) -> Vec<u8>;

    /// Forgets a script: nothing calls its functions any more.
    fn release(&self, number: u64);

    /// Tells in the log where a codel is.
    fn tell_where(&self, codel: &str);
}

impl Runtime {
    /// Opens the library that the environment names.
    ///
    /// # Errors
    /// There is none, or it is of another version than this program.
    pub(crate) fn open(version: &str) -> Result<Self, String> {
        let path = std::env::var_os(VARIABLE).filter(|path| !path.is_empty()).ok_or_else(|| {
            format!(
                "{VARIABLE} names no library: genomd starts this program, and found no \
                 libgenom_runner.so beside itself; install all of its package"
            )
        })?;
        let shown = Path::new(&path).display();
        // SAFETY: the library of genomd does nothing when it is loaded.
        let library = unsafe { Library::new(&path) }.map_err(|why| format!("{shown}: {why}"))?;
        let library: &'static Library = Box::leak(Box::new(library));
        // SAFETY: genomd says that this function has this type, in each version.
        let tells =
            unsafe { library.get::<unsafe extern "C" fn() -> *const c_char>(b"genom_version\0") };
        let tells = tells.map_err(|why| format!("{shown}: {why}"))?;
        // SAFETY: it returns a constant.
        let its = unsafe { CStr::from_ptr(tells()) }.to_string_lossy();
        if its != version {
            return Err(format!("{shown} is genomd {its}, and this genom-lua is {version}"));
        }
        // SAFETY: it is of this version, where the functions have these types.
        let all = unsafe {
            (|| {
                Ok::<Self, libloading::Error>(Self {
                    run: *library.get::<Run>(b"genom_run\0")?,
                    answer: *library.get::<Answer>(b"genom_answer\0")?,
                    log: *library.get::<Write>(b"genom_log\0")?,
                    reads: *library.get::<Reads>(b"genom_reads\0")?,
                })
            })()
        };
        all.map_err(|why| format!("{shown}: {why}"))
    }

    /// Says that this process reads what is in a directory.
    pub(crate) fn reads(self, directory: &Path) {
        let bytes = directory.as_os_str().to_owned().into_vec();
        let Ok(directory) = CString::new(bytes) else { return };
        // SAFETY: it takes a C string.
        unsafe { (self.reads)(directory.as_ptr()) };
    }

    /// The log of genomd.
    pub(crate) fn log(self) -> Log {
        Log::new(self.log)
    }

    /// Runs genomd with these arguments until it ends; returns its exit status.
    pub(crate) fn run(self, arguments: &[OsString], scripts: Box<dyn Scripts>) -> u8 {
        RUNNING.get_or_init(|| Running { scripts, answer: self.answer });
        let words = [OsString::from("genomd")].into_iter().chain(arguments.iter().cloned());
        // An argument of a process has no NUL inside.
        let words = words.filter_map(|word| CString::new(word.into_vec()).ok());
        let words: Vec<CString> = words.collect();
        let pointers: Vec<*const c_char> = words.iter().map(|word| word.as_ptr()).collect();
        // SAFETY: the arguments are C strings and live until it returns; the functions live as long as
        // the process, and can be called by any thread.
        let status = unsafe {
            (self.run)(
                c"lua".as_ptr(),
                pointers.len(),
                pointers.as_ptr(),
                load,
                release,
                tell_where,
            )
        };
        u8::try_from(status).unwrap_or(1)
    }
}

unsafe extern "C" fn load(request: *const u8, size: usize, answer: *mut c_void) {
    let Some(running) = RUNNING.get() else { return };
    // SAFETY: genomd passes so many bytes, which live until this returns.
    let request = unsafe { std::slice::from_raw_parts(request, size) };
    let told = running.scripts.load(request);
    // SAFETY: within the load that the answer is for.
    unsafe { (running.answer)(answer, told.as_ptr(), told.len()) };
}

unsafe extern "C" fn release(number: u64) {
    if let Some(running) = RUNNING.get() {
        running.scripts.release(number);
    }
}

unsafe extern "C" fn tell_where(codel: *const u8, size: usize) {
    let Some(running) = RUNNING.get() else { return };
    // SAFETY: genomd passes so many bytes, which live until this returns.
    let codel = unsafe { std::slice::from_raw_parts(codel, size) };
    running.scripts.tell_where(&String::from_utf8_lossy(codel));
}
