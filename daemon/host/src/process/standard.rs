//! Standard input, output and error, protected from codels that close them. One of the few unsafe
//! modules.
//!
//! A new file or socket gets the lowest free descriptor. If a codel closed descriptor 2, the next
//! connection of a client would get that number, and everything that libraries print. The daemon
//! itself writes to a copy of standard error.
#![allow(unsafe_code)]

use std::ffi::c_int;
use std::fs::File;
use std::io::{self, Write};
use std::mem::MaybeUninit;
use std::os::fd::{AsRawFd as _, FromRawFd as _, OwnedFd, RawFd};
use std::sync::OnceLock;
use std::sync::atomic::{AtomicBool, Ordering};

use super::forked;
use super::notes::{self, Act};
use crate::running;

const NAMES: [&str; 3] = ["input", "output", "error"];
/// Copies get descriptors from this number on, out of the way of code that expects low numbers.
const HIGH: RawFd = 100;

/// Copies of the three, as they were at the start.
static COPIES: OnceLock<[Option<File>; 3]> = OnceLock::new();

fn copies() -> &'static [Option<File>; 3] {
    COPIES.get_or_init(|| [0, 1, 2].map(copy))
}

/// A copy of a descriptor, which no executed program inherits.
fn copy(of: RawFd) -> Option<File> {
    let copy = File::from(duplicate(of).ok()?);
    // A pipe ends for its reader only when every copy is closed, also those in children.
    forked::keep_from_children(&copy);
    Some(copy)
}

/// A high descriptor of the same file, or any above the standard ones if few are allowed.
fn duplicate(of: RawFd) -> io::Result<OwnedFd> {
    let mut error = None;
    for lowest in [HIGH, libc::STDERR_FILENO + 1] {
        // SAFETY: duplicating a descriptor reads no memory; the new one belongs to nobody else.
        let found = unsafe { libc::fcntl(of, libc::F_DUPFD_CLOEXEC, lowest) };
        if found >= 0 {
            // SAFETY: the system has just made it.
            return Ok(unsafe { OwnedFd::from_raw_fd(found) });
        }
        error = Some(io::Error::last_os_error());
    }
    Err(error.unwrap_or_else(io::Error::last_os_error))
}

/// Standard error as it was when the process started, whatever codels do to descriptor 2.
#[derive(Clone, Copy, Debug)]
pub struct StandardError(());

impl StandardError {
    /// Standard error. Call this once before codels run, since the first call copies it.
    #[must_use]
    pub fn get() -> Self {
        let _ = copies();
        Self(())
    }
}

impl Write for StandardError {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        match copies()[2].as_ref() {
            Some(mut file) => file.write(bytes),
            // It was closed when the process started.
            None => Ok(bytes.len()),
        }
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

/// The descriptor for crash reports. Signal handlers may call it.
pub(crate) fn error_descriptor() -> RawFd {
    if forked::is_child() {
        return libc::STDERR_FILENO;
    }
    let copies = COPIES.get();
    copies.and_then(|all| all[2].as_ref()).map_or(libc::STDERR_FILENO, |file| file.as_raw_fd())
}

/// Opens descriptors again that were closed; returns a message for each.
pub(super) fn put_back() -> Vec<String> {
    let closed = |descriptor: &RawFd| {
        // SAFETY: asking for flags reads no memory.
        unsafe { libc::fcntl(*descriptor, libc::F_GETFD) < 0 }
    };
    let again = notes::take(&[Act::Reopened]).into_iter().map(|note| note.number);
    let closed: Vec<_> = (0..3).filter(closed).filter(|one| reopen(*one)).chain(again).collect();
    let told = |one: RawFd| format!("a codel closed standard {}: it is open again", name(one));
    let mut all: Vec<String> = closed.into_iter().map(told).collect();
    all.extend(TAKEN.iter().filter_map(Taken::look));
    all
}

/// Whether the number of a standard descriptor leads to another file than at the start. What has
/// the number now belongs to somebody, so it is told, once, and stays.
struct Taken {
    descriptor: RawFd,
    told: AtomicBool,
}

static TAKEN: [Taken; 2] = [Taken::new(libc::STDOUT_FILENO), Taken::new(libc::STDERR_FILENO)];

impl Taken {
    const fn new(descriptor: RawFd) -> Self {
        Self { descriptor, told: AtomicBool::new(false) }
    }

    fn look(&self) -> Option<String> {
        let copy = copies().get(usize::try_from(self.descriptor).ok()?)?.as_ref()?;
        self.compare(file_of(self.descriptor)?, file_of(copy.as_raw_fd())?)
    }

    fn compare(&self, now: OpenFile, before: OpenFile) -> Option<String> {
        let is = now != before && !self.told.swap(true, Ordering::Relaxed);
        is.then(|| {
            format!(
                "standard {} is another file than at the start: a codel closed or redirected it, \
                 and what codels print goes there",
                name(self.descriptor)
            )
        })
    }
}

/// Device and number of an open file.
type OpenFile = (libc::dev_t, libc::ino_t);

fn file_of(descriptor: RawFd) -> Option<OpenFile> {
    let mut found = MaybeUninit::<libc::stat>::uninit();
    // SAFETY: the system writes into `found`, and does so completely if it returns 0.
    let found =
        unsafe { (libc::fstat(descriptor, found.as_mut_ptr()) == 0).then(|| found.assume_init()) }?;
    Some((found.st_dev, found.st_ino))
}

/// Opens a standard descriptor again, unless its number was reused.
fn reopen(descriptor: RawFd) -> bool {
    let Some(Some(copy)) = usize::try_from(descriptor).ok().and_then(|at| copies().get(at)) else {
        return false;
    };
    // Takes the lowest free number, so that one that was reused meanwhile is not overwritten.
    // SAFETY: duplicating a descriptor reads no memory; the new one is kept open or closed here.
    unsafe {
        let made = libc::fcntl(copy.as_raw_fd(), libc::F_DUPFD, descriptor);
        if made > descriptor {
            libc::close(made);
        }
        made == descriptor
    }
}

/// Moves a descriptor that got the number of a standard one to a higher number, and opens the
/// standard one again.
///
/// # Errors
/// No more descriptors are available.
pub fn keep_off(found: OwnedFd) -> io::Result<OwnedFd> {
    if found.as_raw_fd() > libc::STDERR_FILENO {
        return Ok(found);
    }
    let moved = duplicate(found.as_raw_fd())?;
    let low = found.as_raw_fd();
    drop(found);
    if reopen(low) {
        notes::add(Act::Reopened, low, 0, "");
    }
    Ok(moved)
}

/// The system's `close`, except that codels cannot close the standard descriptors. A descriptor
/// that children had to close ([`forked::keep_from_children`]) is not tracked any more.
///
/// # Safety
/// As for the system's function.
#[unsafe(no_mangle)]
pub(super) unsafe extern "C" fn close(descriptor: c_int) -> c_int {
    if (0..3).contains(&descriptor) && running::in_codel() {
        notes::add(Act::Close, descriptor, 0, running::words());
        return 0;
    }
    forked::forget(descriptor);
    // SAFETY: the caller's own argument.
    c_int::try_from(unsafe { libc::syscall(libc::SYS_close, descriptor) }).unwrap_or(-1)
}

/// The name of a standard descriptor.
pub(super) fn name(descriptor: c_int) -> &'static str {
    usize::try_from(descriptor).ok().and_then(|at| NAMES.get(at)).unwrap_or(&"")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_got_the_place_of_a_standard_descriptor_is_moved_and_the_place_is_filled() {
        let _ = StandardError::get();
        assert!(error_descriptor() >= HIGH);
        // SAFETY: nothing here reads standard input.
        unsafe { libc::close(0) };
        let taken = OwnedFd::from(File::open("/dev/null").unwrap());
        assert_eq!(taken.as_raw_fd(), 0);
        let moved = keep_off(taken).unwrap();
        assert!(moved.as_raw_fd() >= HIGH);
        let told = ["a codel closed standard input: it is open again"];
        assert_eq!(put_back(), told, "and it is open already");
        // SAFETY: as above.
        unsafe { libc::close(0) };
        assert_eq!(put_back(), told);
    }

    #[test]
    fn a_number_that_leads_elsewhere_is_told_once() {
        let _ = StandardError::get();
        let taken = Taken::new(libc::STDOUT_FILENO);
        assert_eq!(taken.look(), None, "it is the file of the start");
        let file = tempfile::tempfile().unwrap();
        let [now, before] =
            [file.as_raw_fd(), libc::STDOUT_FILENO].map(|one| file_of(one).unwrap());
        let told = taken.compare(now, before).unwrap();
        assert!(told.starts_with("standard output is another file"), "{told}");
        assert_eq!(taken.compare(now, before), None);
        assert_eq!(file_of(-1), None);
    }
}
