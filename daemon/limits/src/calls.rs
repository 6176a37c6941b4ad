//! System calls that are refused, by seccomp: network, child processes, and what no component has
//! to do with.

use std::collections::BTreeMap;
use std::io;

use genom_configuration::CellLimits;
use libc::{AF_UNIX, CLONE_THREAD, EACCES, ENOSYS, EPERM, SOCK_SEQPACKET, SOCK_STREAM, c_long};
use seccompiler::{
    BackendError, BpfProgram, SeccompAction, SeccompCmpArgLen, SeccompCmpOp, SeccompCondition,
    SeccompFilter, SeccompRule, TargetArch, apply_filter, apply_filter_all_threads,
};

/// Calls, with the conditions under which each is refused; none: always.
type Calls = BTreeMap<c_long, Vec<SeccompRule>>;

/// What changes the machine, or reads other processes. `io_uring` does what the filter would not
/// see.
const DANGEROUS: [c_long; 22] = [
    libc::SYS_ptrace,
    libc::SYS_process_vm_readv,
    libc::SYS_process_vm_writev,
    libc::SYS_bpf,
    libc::SYS_perf_event_open,
    libc::SYS_userfaultfd,
    libc::SYS_io_uring_setup,
    libc::SYS_open_by_handle_at,
    libc::SYS_init_module,
    libc::SYS_finit_module,
    libc::SYS_delete_module,
    libc::SYS_kexec_load,
    libc::SYS_reboot,
    libc::SYS_mount,
    libc::SYS_umount2,
    libc::SYS_pivot_root,
    libc::SYS_setns,
    libc::SYS_unshare,
    libc::SYS_swapon,
    libc::SYS_swapoff,
    libc::SYS_add_key,
    libc::SYS_keyctl,
];

/// Types of sockets; the others bits are flags.
const KIND: u64 = 0xf;

/// Refuses what the limits say; returns what does not hold.
pub(crate) fn refuse(limits: &CellLimits) -> Vec<String> {
    let mut missing = Vec::new();
    let mut install = |what: &str, calls: Result<Calls, BackendError>, errno: i32| {
        let program = calls.and_then(|calls| program(calls, errno));
        let done = program.map_err(seccompiler::Error::Backend).and_then(|it| apply_filter(&it));
        if let Err(error) = done {
            missing.push(format!("{what} not refused: {error}"));
        }
    };
    if limits.is_sandbox() {
        let calls = DANGEROUS.map(|call| (call, Vec::new())).into();
        install("dangerous system calls are", Ok(calls), EPERM);
        if limits.network != Some(true) {
            install("the network is", sockets(), EACCES);
        }
    }
    if limits.processes == Some(0) {
        install("child processes are", children(), EPERM);
        // Its flags are in memory, where no filter sees them: the C library takes `clone` instead.
        install("child processes are", Ok([(libc::SYS_clone3, Vec::new())].into()), ENOSYS);
    }
    missing
}

/// Refuses new connections over Unix sockets to any thread of this process, which could command
/// this daemon over its control plane; a cell has its own by now. Only with a sandbox without
/// network: middlewares of the network use such sockets themselves.
///
/// # Errors
/// The kernel refuses.
pub fn close_doors(limits: &CellLimits) -> io::Result<()> {
    if !limits.is_sandbox() || limits.network == Some(true) {
        return Ok(());
    }
    let program = streams().and_then(|calls| program(calls, EACCES));
    let done = program.map_err(seccompiler::Error::Backend);
    done.and_then(|program| apply_filter_all_threads(&program)).map_err(io::Error::other)
}

fn program(calls: Calls, errno: i32) -> Result<BpfProgram, BackendError> {
    let errno = SeccompAction::Errno(errno.unsigned_abs());
    let machine = TargetArch::try_from(std::env::consts::ARCH)?;
    SeccompFilter::new(calls, SeccompAction::Allow, errno, machine)?.try_into()
}

/// A call is refused when this holds of an argument.
fn when(argument: u8, op: SeccompCmpOp, value: u64) -> Result<SeccompRule, BackendError> {
    let condition = SeccompCondition::new(argument, SeccompCmpArgLen::Dword, op, value)?;
    SeccompRule::new(vec![condition])
}

/// Sockets that are not Unix ones.
fn sockets() -> Result<Calls, BackendError> {
    let others = when(0, SeccompCmpOp::Ne, AF_UNIX.unsigned_abs().into())?;
    Ok([(libc::SYS_socket, vec![others])].into())
}

/// Sockets that can be connected to a listening one.
fn streams() -> Result<Calls, BackendError> {
    let of = |kind: i32| when(1, SeccompCmpOp::MaskedEq(KIND), kind.unsigned_abs().into());
    Ok([(libc::SYS_socket, vec![of(SOCK_STREAM)?, of(SOCK_SEQPACKET)?])].into())
}

/// Processes that are no threads.
fn children() -> Result<Calls, BackendError> {
    let thread: u64 = CLONE_THREAD.unsigned_abs().into();
    let processes = when(0, SeccompCmpOp::MaskedEq(thread), 0)?;
    let mut calls: Calls = [(libc::SYS_clone, vec![processes])].into();
    #[cfg(target_arch = "x86_64")]
    calls.extend([(libc::SYS_fork, Vec::new()), (libc::SYS_vfork, Vec::new())]);
    Ok(calls)
}
