//! `genom_client` for C: `include/genomd.h` documents each function.
//!
//! A pointer that C passes is one that these functions returned, or NULL, which is refused.

mod failure;

use std::ffi::{CStr, CString, OsStr, c_char, c_int, c_void};
use std::os::unix::ffi::{OsStrExt as _, OsStringExt as _};
use std::path::PathBuf;
use std::time::Duration;

use genom_client::{Daemon, In, OpenError, Options, Out};

use crate::failure::{Failure, guarded};

/// A daemon, and what is told of it.
pub struct Genomd {
    daemon: Daemon,
    socket: CString,
    log: CString,
}

/// A port of either kind.
pub enum Port {
    /// In.
    In(In),
    /// Out.
    Out(Out),
}

/// Starts a daemon.
///
/// # Safety
/// `program` is NULL or a string, and `arguments` NULL or an array of strings that NULL ends.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn genomd_start(
    program: *const c_char,
    arguments: *const *const c_char,
) -> *mut Genomd {
    guarded(std::ptr::null_mut(), || {
        let mut options = Options::new();
        if !program.is_null() {
            // SAFETY: it is a string, as the caller guarantees.
            options =
                options.program(OsStr::from_bytes(unsafe { CStr::from_ptr(program) }.to_bytes()));
        }
        let mut next = arguments;
        // SAFETY: as long as it is not NULL, a string is there and another pointer follows.
        while let Some(argument) = unsafe { next.as_ref() }.filter(|argument| !argument.is_null()) {
            // SAFETY: it is a string, as the caller guarantees.
            let argument = unsafe { CStr::from_ptr(*argument) };
            options = options.argument(OsStr::from_bytes(argument.to_bytes()));
            next = next.wrapping_add(1);
        }
        let daemon = Daemon::start(&options)?;
        let (socket, log) = (text(daemon.socket())?, text(daemon.log())?);
        Ok(Box::into_raw(Box::new(Genomd { daemon, socket, log })))
    })
}

/// Stops a daemon.
///
/// # Safety
/// It is NULL, or a daemon that was not stopped.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn genomd_stop(daemon: *mut Genomd) {
    if !daemon.is_null() {
        // SAFETY: `genomd_start` made it, and it is not used any more.
        let daemon = unsafe { Box::from_raw(daemon) };
        guarded((), || {
            drop(daemon);
            Ok(())
        });
    }
}

/// Its socket.
///
/// # Safety
/// It is NULL, or a daemon that was not stopped.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn genomd_socket(daemon: *const Genomd) -> *const c_char {
    // SAFETY: it is such a daemon, as the caller guarantees.
    guarded(std::ptr::null(), || Ok(given(unsafe { daemon.as_ref() })?.socket.as_ptr()))
}

/// Its log.
///
/// # Safety
/// It is NULL, or a daemon that was not stopped.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn genomd_log(daemon: *const Genomd) -> *const c_char {
    // SAFETY: it is such a daemon, as the caller guarantees.
    guarded(std::ptr::null(), || Ok(given(unsafe { daemon.as_ref() })?.log.as_ptr()))
}

/// Steps its clock.
///
/// # Safety
/// `daemon` is NULL, or a daemon that was not stopped and is not used by another thread; `now` is NULL
/// or can be written.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn genomd_step(
    daemon: *mut Genomd,
    nanoseconds: u64,
    now: *mut u64,
) -> c_int {
    guarded(-1, || {
        // SAFETY: it is such a daemon, as the caller guarantees.
        let daemon = given(unsafe { daemon.as_mut() })?;
        let time = daemon.daemon.step(Duration::from_nanos(nanoseconds))?;
        // SAFETY: it is NULL or can be written, as the caller guarantees.
        if let Some(now) = unsafe { now.as_mut() } {
            *now = u64::try_from(time.as_nanos()).unwrap_or(u64::MAX);
        }
        Ok(0)
    })
}

/// Shares an in port.
///
/// # Safety
/// `daemon` as for [`genomd_step`]; `address` is NULL or a string.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn genomd_in(
    daemon: *mut Genomd,
    address: *const c_char,
    size: usize,
) -> *mut Port {
    // SAFETY: they are such, as the caller guarantees.
    unsafe { share(daemon, address, size, |by, at| In::open(by, at).map(Port::In)) }
}

/// Shares an out port.
///
/// # Safety
/// As for [`genomd_in`].
#[unsafe(no_mangle)]
pub unsafe extern "C" fn genomd_out(
    daemon: *mut Genomd,
    address: *const c_char,
    size: usize,
) -> *mut Port {
    // SAFETY: they are such, as the caller guarantees.
    unsafe { share(daemon, address, size, |by, at| Out::open(by, at).map(Port::Out)) }
}

/// Shares a port of either kind.
///
/// # Safety
/// As for [`genomd_in`].
unsafe fn share(
    daemon: *mut Genomd,
    address: *const c_char,
    size: usize,
    open: fn(&mut Daemon, &str) -> Result<Port, OpenError>,
) -> *mut Port {
    guarded(std::ptr::null_mut(), || {
        // SAFETY: they are such, as the caller guarantees.
        let (daemon, address) = (given(unsafe { daemon.as_mut() })?, unsafe { string(address) }?);
        let port = open(&mut daemon.daemon, address)?;
        let is = match &port {
            Port::In(port) => port.size(),
            Port::Out(port) => port.size(),
        };
        sized(address, is, size)?;
        Ok(Box::into_raw(Box::new(port)))
    })
}

/// Ends sharing.
///
/// # Safety
/// It is NULL, or a port that was not closed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn genomd_close(port: *mut Port) {
    if !port.is_null() {
        // SAFETY: `genomd_in` or `genomd_out` made it, and it is not used any more.
        let port = unsafe { Box::from_raw(port) };
        guarded((), || {
            drop(port);
            Ok(())
        });
    }
}

/// The value.
///
/// # Safety
/// It is NULL, or a port that was not closed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn genomd_data(port: *const Port) -> *const c_void {
    // SAFETY: it is such a port, as the caller guarantees.
    guarded(std::ptr::null(), || match given(unsafe { port.as_ref() })? {
        Port::In(port) => Ok(port.as_ptr().cast()),
        Port::Out(port) => Ok(port.as_ptr().cast()),
    })
}

/// The value of an in port, to be changed.
///
/// # Safety
/// It is NULL, or a port that was not closed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn genomd_in_data(port: *mut Port) -> *mut c_void {
    // SAFETY: it is such a port, as the caller guarantees.
    guarded(std::ptr::null_mut(), || match given(unsafe { port.as_mut() })? {
        Port::In(port) => Ok(port.as_mut_ptr().cast()),
        Port::Out(port) => Err(Failure::of_out_port(port.address())),
    })
}

/// How often it was written.
///
/// # Safety
/// It is NULL, or a port that was not closed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn genomd_count(port: *const Port) -> u64 {
    // SAFETY: it is such a port, as the caller guarantees.
    guarded(0, || match given(unsafe { port.as_ref() })? {
        Port::In(port) => Ok(port.count()),
        Port::Out(port) => Ok(port.count()),
    })
}

/// Has the next step publish the value.
///
/// # Safety
/// It is NULL, or a port that was not closed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn genomd_write(port: *mut Port) -> c_int {
    // SAFETY: it is such a port, as the caller guarantees.
    guarded(-1, || match given(unsafe { port.as_mut() })? {
        Port::In(port) => Ok(port.write().map(|()| 0)?),
        Port::Out(port) => Err(Failure::of_out_port(port.address())),
    })
}

/// Whether the port is there.
///
/// # Safety
/// It is NULL, or a port that was not closed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn genomd_check(port: *const Port) -> c_int {
    // SAFETY: it is such a port, as the caller guarantees.
    guarded(-1, || match given(unsafe { port.as_ref() })? {
        Port::In(port) => Ok(port.check().map(|()| 0)?),
        Port::Out(port) => Ok(port.check().map(|()| 0)?),
    })
}

/// Why the last function that failed in this thread did so.
#[unsafe(no_mangle)]
pub extern "C" fn genomd_error() -> *const c_char {
    failure::last()
}

fn given<T>(pointer: Option<T>) -> Result<T, Failure> {
    pointer.ok_or(Failure::null())
}

/// # Safety
/// It is NULL or a string, which stays there for as long as the result is used.
unsafe fn string<'a>(address: *const c_char) -> Result<&'a str, Failure> {
    if address.is_null() {
        return Err(Failure::null());
    }
    // SAFETY: it is a string, as the caller guarantees.
    let address = unsafe { CStr::from_ptr(address) };
    address.to_str().map_err(|_| Failure::no_text())
}

fn sized(address: &str, is: usize, asked: usize) -> Result<(), Failure> {
    if is == asked { Ok(()) } else { Err(Failure::of_size(address, is, asked)) }
}

fn text(path: PathBuf) -> Result<CString, Failure> {
    CString::new(path.into_os_string().into_vec()).map_err(|_| Failure::no_text())
}
