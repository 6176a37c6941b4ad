//! Stops a process before a system call, by `ptrace` and seccomp. Contains all unsafe code of this
//! crate.

#![allow(unsafe_code, reason = "the one module of the tests that needs it")]

use std::io;
use std::mem::{offset_of, size_of};
use std::os::unix::process::CommandExt as _;
use std::process::Command;

use libc::{c_int, c_long, c_uint, c_ulong, c_void, pid_t, sock_filter, sock_fprog};

/// System calls that change files, or open and close them. The names are for the table, the numbers
/// for the filter.
pub(super) const CALLS: &[(&str, c_long)] = &[
    ("openat", libc::SYS_openat),
    ("close", libc::SYS_close),
    ("ftruncate", libc::SYS_ftruncate),
    ("fchmod", libc::SYS_fchmod),
    ("fchmodat", libc::SYS_fchmodat),
    ("fchown", libc::SYS_fchown),
    ("mmap", libc::SYS_mmap),
    ("write", libc::SYS_write),
    ("pwrite64", libc::SYS_pwrite64),
    ("unlinkat", libc::SYS_unlinkat),
    ("renameat2", libc::SYS_renameat2),
    ("flock", libc::SYS_flock),
    ("fcntl", libc::SYS_fcntl),
    ("mkdirat", libc::SYS_mkdirat),
    #[cfg(target_arch = "x86_64")]
    ("open", libc::SYS_open),
    #[cfg(target_arch = "x86_64")]
    ("creat", libc::SYS_creat),
    #[cfg(target_arch = "x86_64")]
    ("chmod", libc::SYS_chmod),
    #[cfg(target_arch = "x86_64")]
    ("unlink", libc::SYS_unlink),
    #[cfg(target_arch = "x86_64")]
    ("rename", libc::SYS_rename),
    #[cfg(target_arch = "x86_64")]
    ("renameat", libc::SYS_renameat),
    #[cfg(target_arch = "x86_64")]
    ("mkdir", libc::SYS_mkdir),
    #[cfg(target_arch = "x86_64")]
    ("rmdir", libc::SYS_rmdir),
];

/// Why a traced thread has stopped, or that it is gone.
#[derive(Debug)]
pub(super) enum Stop {
    /// Before a call that the filter selects, with its arguments.
    Call { name: &'static str, arguments: [u64; 6] },
    /// A signal is about to be delivered.
    Signal(c_int),
    /// An event of tracing itself.
    Other,
    /// The thread or its process has ended.
    Gone,
}

fn check(result: c_long) -> io::Result<c_long> {
    if result < 0 { Err(io::Error::last_os_error()) } else { Ok(result) }
}

fn statement(code: c_uint, k: u32) -> sock_filter {
    sock_filter { code: code as u16, jt: 0, jf: 0, k }
}

/// Stops at the calls above and allows all others.
fn filter() -> Vec<sock_filter> {
    let load = libc::BPF_LD | libc::BPF_W | libc::BPF_ABS;
    let number = offset_of!(libc::seccomp_data, nr) as u32;
    let mut program = vec![statement(load, number)];
    for (rank, (_, call)) in CALLS.iter().enumerate() {
        let mut jump = statement(libc::BPF_JMP | libc::BPF_JEQ | libc::BPF_K, *call as u32);
        // Jumps over the rest of the comparisons and the statement that allows the call.
        jump.jt = u8::try_from(CALLS.len() - rank).unwrap_or(u8::MAX);
        program.push(jump);
    }
    program.push(statement(libc::BPF_RET | libc::BPF_K, libc::SECCOMP_RET_ALLOW));
    program.push(statement(libc::BPF_RET | libc::BPF_K, libc::SECCOMP_RET_TRACE));
    program
}

/// Makes the program traceable by the thread that starts it.
pub(super) fn make_traced(command: &mut Command) {
    let mut filter = filter();
    let install = move || {
        let program = sock_fprog { len: filter.len() as u16, filter: filter.as_mut_ptr() };
        // SAFETY: these calls take integers, and a pointer to a program that outlives the call.
        unsafe {
            check(libc::ptrace(libc::PTRACE_TRACEME, 0, 0, 0))?;
            check(libc::prctl(libc::PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0).into())?;
            let program = std::ptr::from_ref(&program);
            let mode = libc::SECCOMP_MODE_FILTER;
            check(libc::prctl(libc::PR_SET_SECCOMP, mode, program, 0, 0).into())?;
        }
        Ok(())
    };
    // SAFETY: between fork and exec this only makes system calls, and allocates nothing.
    unsafe { command.pre_exec(install) };
}

/// Selects the events at which a process stops from now on. It is killed when the tracing thread
/// ends.
pub(super) fn follow(process: pid_t) -> io::Result<()> {
    let options = libc::PTRACE_O_TRACESECCOMP
        | libc::PTRACE_O_TRACECLONE
        | libc::PTRACE_O_TRACEFORK
        | libc::PTRACE_O_TRACEVFORK
        | libc::PTRACE_O_EXITKILL;
    // SAFETY: changes how the traced process stops, and nothing in this process.
    check(unsafe { libc::ptrace(libc::PTRACE_SETOPTIONS, process, 0, c_long::from(options)) })
        .map(drop)
}

/// Continues a thread, with a signal or 0.
pub(super) fn go_on(thread: pid_t, signal: c_int) {
    // SAFETY: continues the traced thread. If that is gone, the next wait reports it.
    let _ = unsafe { libc::ptrace(libc::PTRACE_CONT, thread, 0, c_long::from(signal)) };
}

/// Kills a process.
pub(super) fn kill(process: pid_t) {
    // SAFETY: sends a signal to a process that this thread started and has not waited for.
    unsafe { libc::kill(process, libc::SIGKILL) };
}

/// Waits until a process of this thread stops or ends; `None` if there is none left.
pub(super) fn wait() -> Option<(pid_t, Stop)> {
    let mut status = 0;
    let thread = loop {
        // SAFETY: writes one integer. Waits only for processes of this thread.
        let found = unsafe { libc::waitpid(-1, &raw mut status, libc::__WALL | libc::__WNOTHREAD) };
        if found > 0 {
            break found;
        }
        if io::Error::last_os_error().kind() != io::ErrorKind::Interrupted {
            return None;
        }
    };
    let stop = if libc::WIFEXITED(status) || libc::WIFSIGNALED(status) {
        Stop::Gone
    } else if status >> 16 == libc::PTRACE_EVENT_SECCOMP {
        call(thread).unwrap_or(Stop::Other)
    } else if status >> 16 != 0 {
        Stop::Other
    } else {
        Stop::Signal(libc::WSTOPSIG(status))
    };
    Some((thread, stop))
}

/// The call before which a thread has stopped.
fn call(thread: pid_t) -> Option<Stop> {
    // SAFETY: all members are integers, for which zero is a valid value.
    let mut told: libc::ptrace_syscall_info = unsafe { std::mem::zeroed() };
    let size = size_of::<libc::ptrace_syscall_info>();
    let into = (&raw mut told).cast::<c_void>();
    // SAFETY: the system writes at most `size` bytes.
    let got = unsafe { libc::ptrace(libc::PTRACE_GET_SYSCALL_INFO, thread, size, into) };
    check(got).ok()?;
    if told.op != libc::PTRACE_SYSCALL_INFO_SECCOMP {
        return None;
    }
    // SAFETY: `op` tells which member of the union was written.
    let told = unsafe { told.u.seccomp };
    let number = c_ulong::from(told.nr) as c_long;
    let name = CALLS.iter().find(|(_, call)| *call == number).map(|(name, _)| *name)?;
    Some(Stop::Call { name, arguments: told.args })
}
