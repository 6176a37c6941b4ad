//! What a dying process writes for the daemon that will report its crash: a text in a file that was
//! opened before, line by line, the most important first. One of the few unsafe modules.
//!
//! The writer runs in signal handlers of a process in an unknown state: it allocates nothing, takes
//! no lock and opens nothing but `/proc/self/maps`. What is written stays written, whatever happens
//! to the process next; a timer of the kernel ends one that hangs.
//!
//! Return addresses are those of `_Unwind_Backtrace`, since codels are compiled without frame
//! pointers. It finds its tables by `_dl_find_object`, which takes no lock (glibc 2.35 and later),
//! and it reads the stack, which may be destroyed: so it comes last, and a fault in it ends the
//! process as the first one would have. Where it finds no caller, as after a jump to nowhere, words
//! of the stack are written as guesses instead.
#![allow(unsafe_code)]

use std::ffi::{c_int, c_void};
use std::fmt::{self, Write as _};
use std::fs::File;
use std::mem::MaybeUninit;
use std::os::fd::{IntoRawFd as _, OwnedFd, RawFd};
use std::sync::atomic::{AtomicI32, Ordering};

use crate::process::keep_from_children;
use crate::running::{doing, is_own_process, words};

/// The file; -1 where nobody asked for notes.
static NOTE: AtomicI32 = AtomicI32::new(-1);

/// The thread that writes; there is one note per process.
static WRITER: AtomicI32 = AtomicI32::new(0);

/// Most return addresses.
const FRAMES: usize = 64;

/// How long the process may take to die, in seconds; and when somebody takes a dump of it.
const PATIENCE: libc::time_t = 2;
const PATIENCE_FOR_DUMP: libc::time_t = 20;

/// A socket at whose other end somebody takes a dump of this process; -1 where nobody does.
static DUMPER: AtomicI32 = AtomicI32::new(-1);

unsafe extern "C" {
    /// Of the unwinder that Rust and C++ share; it calls `each` with every frame, innermost first.
    fn _Unwind_Backtrace(
        each: extern "C" fn(*mut c_void, *mut c_void) -> c_int,
        data: *mut c_void,
    ) -> c_int;
    fn _Unwind_GetIP(frame: *mut c_void) -> usize;
}

/// From now on, a crash of this process is written to this file.
pub fn note_crashes_in(file: File) {
    keep_from_children(&file);
    // The unwinder prepares itself at its first use.
    Addresses::here();
    NOTE.store(file.into_raw_fd(), Ordering::Release);
}

/// From now on, after a crash is noted, the number of the thread is sent to this socket (4 bytes,
/// little endian), and the process waits for a byte before it ends: it can be looked at meanwhile.
pub fn wait_for_dumps_at(socket: OwnedFd) {
    keep_from_children(&socket);
    DUMPER.store(socket.into_raw_fd(), Ordering::Release);
}

/// Whether crashes are noted: what codels work on is then kept in words.
pub(crate) fn is_kept() -> bool {
    NOTE.load(Ordering::Relaxed) >= 0
}

/// Where a signal hit.
struct Hit {
    signal: c_int,
    code: c_int,
    address: usize,
    /// Program counter and stack pointer.
    pc: usize,
    sp: usize,
}

/// Writes the note of a fault. Signal handlers may call it.
///
/// # Safety
/// The arguments are those that the system passed to a handler with `SA_SIGINFO`.
pub(crate) unsafe fn of_signal(
    name: &str,
    signal: c_int,
    info: *const libc::siginfo_t,
    context: *const c_void,
) {
    // SAFETY: the caller's promise.
    let (pc, sp) = unsafe { registers(context) };
    // SAFETY: as above; signals that faults raise have an address.
    let (code, address) = unsafe {
        let code = (*info).si_code;
        (code, if code > 0 { (*info).si_addr() as usize } else { 0 })
    };
    write(name, Some(&Hit { signal, code, address, pc, sp }));
}

/// Writes the note of an end by a function, such as `exit`.
pub(crate) fn of_call(name: &str) {
    write(name, None);
}

#[cfg(target_arch = "x86_64")]
unsafe fn registers(context: *const c_void) -> (usize, usize) {
    let one = |rank: c_int| {
        // SAFETY: the system passed a `ucontext_t`, as the caller promises.
        let all = unsafe { &(*context.cast::<libc::ucontext_t>()).uc_mcontext.gregs };
        let value = usize::try_from(rank).ok().and_then(|rank| all.get(rank)).copied();
        value.map_or(0, |value| value.cast_unsigned() as usize)
    };
    (one(libc::REG_RIP), one(libc::REG_RSP))
}

#[cfg(target_arch = "aarch64")]
unsafe fn registers(context: *const c_void) -> (usize, usize) {
    // SAFETY: the system passed a `ucontext_t`, as the caller promises.
    let all = unsafe { &(*context.cast::<libc::ucontext_t>()).uc_mcontext };
    (all.pc as usize, all.sp as usize)
}

#[cfg(not(any(target_arch = "x86_64", target_arch = "aarch64")))]
unsafe fn registers(_: *const c_void) -> (usize, usize) {
    (0, 0)
}

fn write(what: &str, hit: Option<&Hit>) {
    let to = NOTE.load(Ordering::Acquire);
    if to < 0 || !is_own_process() {
        return;
    }
    // SAFETY: it has no preconditions.
    let thread = unsafe { libc::syscall(libc::SYS_gettid) };
    let thread = i32::try_from(thread).unwrap_or(i32::MAX);
    match WRITER.compare_exchange(0, thread, Ordering::AcqRel, Ordering::Acquire) {
        Ok(_) => {}
        // A fault while the note is written, or the same fault again.
        Err(writer) if writer == thread => return,
        // Another thread writes its own, and then ends the process.
        Err(_) => wait_for_the_end(),
    }
    let timer = end_in_time();
    let mut out = Out { to, room: [0; 256], used: 0 };
    // Nothing can be done about a note that cannot be written.
    let _ = facts(&mut out, what, hit, thread);
    out.flush();
    maps(&mut out);
    backtrace(&mut out, hit);
    let _ = out.write_str("end\n");
    out.flush();
    wait_for_dump(thread, timer);
}

fn wait_for_dump(thread: i32, timer: Option<c_int>) {
    let socket = DUMPER.load(Ordering::Acquire);
    let Some(timer) = timer.filter(|_| socket >= 0) else { return };
    end_after(timer, PATIENCE_FOR_DUMP);
    let number = thread.to_le_bytes();
    let flags = libc::MSG_NOSIGNAL | libc::MSG_DONTWAIT;
    // SAFETY: the bytes are those of an array.
    let sent = unsafe { libc::send(socket, number.as_ptr().cast(), number.len(), flags) };
    if usize::try_from(sent) != Ok(number.len()) {
        return;
    }
    let mut byte = 0_u8;
    loop {
        // SAFETY: there is room for a byte, and the C library's `errno` is this thread's.
        let goes_on = unsafe {
            libc::recv(socket, (&raw mut byte).cast(), 1, 0) < 0
                && *libc::__errno_location() == libc::EINTR
        };
        // The thread is stopped and resumed while it is looked at, which interrupts the call.
        if !goes_on {
            return;
        }
    }
}

fn wait_for_the_end() {
    loop {
        // SAFETY: it has no preconditions.
        unsafe { libc::pause() };
    }
}

/// Has the kernel end the process, whatever this thread does from here on; the timer that does.
fn end_in_time() -> Option<c_int> {
    let mut timer: c_int = 0;
    // By system calls: the C library's function may allocate.
    // SAFETY: all zeroes is a value of the type; the system reads it and writes a number.
    let made = unsafe {
        let mut event: libc::sigevent = MaybeUninit::zeroed().assume_init();
        event.sigev_notify = libc::SIGEV_SIGNAL;
        event.sigev_signo = libc::SIGKILL;
        let clock = libc::CLOCK_MONOTONIC;
        libc::syscall(libc::SYS_timer_create, clock, &raw mut event, &raw mut timer)
    };
    (made == 0).then(|| end_after(timer, PATIENCE)).map(|()| timer)
}

fn end_after(timer: c_int, seconds: libc::time_t) {
    // SAFETY: all zeroes is a value of the type; the system reads it.
    unsafe {
        let mut when: libc::itimerspec = MaybeUninit::zeroed().assume_init();
        when.it_value.tv_sec = seconds;
        let none = std::ptr::null_mut::<libc::itimerspec>();
        libc::syscall(libc::SYS_timer_settime, timer, 0, &raw const when, none);
    }
}

fn facts(out: &mut Out, what: &str, hit: Option<&Hit>, thread: i32) -> fmt::Result {
    writeln!(out, "what {what}")?;
    if let Some(hit) = hit {
        writeln!(out, "signal {} {}", hit.signal, hit.code)?;
        writeln!(out, "address {:#x}", hit.address)?;
        writeln!(out, "pc {:#x}", hit.pc)?;
    }
    let mut name = [0_u8; 16];
    // SAFETY: the system writes 16 bytes at most.
    unsafe { libc::prctl(libc::PR_GET_NAME, name.as_mut_ptr()) };
    write!(out, "thread {thread} ")?;
    out.text(name.split(|byte| *byte == 0).next().unwrap_or_default())?;
    if !words().is_empty() {
        out.write_str("words ")?;
        out.text(words().as_bytes())?;
    }
    if let Some(doing) = doing() {
        for (key, value) in [
            ("component ", doing.component.as_str()),
            ("owner ", doing.owner.as_str()),
            ("inputs ", doing.inputs.as_str()),
        ] {
            if !value.is_empty() {
                out.write_str(key)?;
                out.text(value.as_bytes())?;
            }
        }
        if doing.activity != 0 {
            writeln!(out, "activity {}", doing.activity)?;
        }
    }
    Ok(())
}

/// Copies the lines of `/proc/self/maps` that tell of code.
fn maps(out: &mut Out) {
    // SAFETY: a C string, and a descriptor that is closed below.
    let from = unsafe { libc::open(c"/proc/self/maps".as_ptr(), libc::O_RDONLY | libc::O_CLOEXEC) };
    if from < 0 {
        return;
    }
    let (mut line, mut length) = ([0_u8; 512], 0_usize);
    let mut read = [0_u8; 512];
    loop {
        // SAFETY: the buffer has this length.
        let count = unsafe { libc::read(from, read.as_mut_ptr().cast(), read.len()) };
        let Some(bytes) = usize::try_from(count).ok().and_then(|count| read.get(..count)) else {
            break;
        };
        if bytes.is_empty() {
            break;
        }
        for &byte in bytes {
            if byte != b'\n' {
                // A path that is too long is cut.
                if let Some(room) = line.get_mut(length) {
                    *room = byte;
                    length += 1;
                }
                continue;
            }
            let text = line.get(..length).unwrap_or_default();
            let rights = text.split(|byte| *byte == b' ').nth(1);
            if rights.is_some_and(|rights| rights.contains(&b'x')) {
                let _ = out.write_str("map ").and_then(|()| out.text(text));
            }
            length = 0;
        }
    }
    out.flush();
    // SAFETY: opened above.
    unsafe { libc::close(from) };
}

/// Return addresses, innermost first.
struct Addresses {
    all: [usize; FRAMES],
    count: usize,
}

impl Addresses {
    /// Those of this thread.
    #[inline(never)]
    fn here() -> Self {
        let mut found = Self { all: [0; FRAMES], count: 0 };
        // SAFETY: `each` gets this pointer back, and only during the call.
        unsafe { _Unwind_Backtrace(Self::each, (&raw mut found).cast()) };
        found
    }

    extern "C" fn each(frame: *mut c_void, found: *mut c_void) -> c_int {
        /// `_URC_END_OF_STACK`; 0 goes on.
        const STOP: c_int = 5;
        // SAFETY: the pointer that `here` passed; the unwinder's own frame.
        let (found, address) = unsafe { (&mut *found.cast::<Self>(), _Unwind_GetIP(frame)) };
        // The outermost frame of a thread has no address.
        let room = found.all.get_mut(found.count).filter(|_| address != 0);
        let Some(room) = room else { return STOP };
        *room = address;
        found.count += 1;
        0
    }

    fn all(&self) -> &[usize] {
        self.all.get(..self.count).unwrap_or_default()
    }
}

fn backtrace(out: &mut Out, hit: Option<&Hit>) {
    // What came before is in the file whatever the unwinder does.
    let found = Addresses::here();
    let all = found.all();
    let from = match hit {
        // The frames of the handler come first.
        Some(hit) => all.iter().position(|at| *at == hit.pc).map(|at| at + 1),
        None => Some(0),
    };
    let callers = from.and_then(|from| all.get(from..)).unwrap_or_default();
    for at in callers {
        let _ = writeln!(out, "caller {at:#x}");
    }
    if let Some(hit) = hit.filter(|_| callers.is_empty()) {
        guesses(out, hit.sp);
    }
}

/// Words of the stack, which may be return addresses.
fn guesses(out: &mut Out, mut from: usize) {
    for _ in 0..16 {
        let mut stack = [0_usize; 32];
        let size = size_of_val(&stack);
        let local = libc::iovec { iov_base: stack.as_mut_ptr().cast(), iov_len: size };
        let remote = libc::iovec { iov_base: from as *mut c_void, iov_len: size };
        // SAFETY: the system checks the addresses, and writes to the buffer only.
        let read = unsafe { libc::process_vm_readv(libc::getpid(), &local, 1, &remote, 1, 0) };
        if usize::try_from(read) != Ok(size) {
            return;
        }
        for word in stack.iter().filter(|word| **word > 0xffff) {
            let _ = writeln!(out, "guess {word:#x}");
        }
        from = from.wrapping_add(size);
    }
}

/// Gathers bytes, and writes them to a descriptor.
struct Out {
    to: RawFd,
    room: [u8; 256],
    used: usize,
}

impl Out {
    /// Writes a line of a text that may hold anything.
    fn text(&mut self, bytes: &[u8]) -> fmt::Result {
        bytes.iter().for_each(|byte| self.byte(if *byte < b' ' { b'?' } else { *byte }));
        self.byte(b'\n');
        Ok(())
    }

    fn byte(&mut self, byte: u8) {
        if self.used == self.room.len() {
            self.flush();
        }
        if let Some(room) = self.room.get_mut(self.used) {
            *room = byte;
            self.used += 1;
        }
    }

    fn flush(&mut self) {
        let bytes = self.room.get(..self.used).unwrap_or_default();
        // SAFETY: the bytes are those of a slice.
        unsafe { libc::write(self.to, bytes.as_ptr().cast(), bytes.len()) };
        self.used = 0;
    }
}

impl fmt::Write for Out {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        text.bytes().for_each(|byte| self.byte(byte));
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_callers_of_this_thread_are_found_innermost_first() {
        let found = Addresses::here();
        assert!(found.all().len() > 3 && found.all().iter().all(|at| *at != 0));
    }
}
