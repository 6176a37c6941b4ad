//! Limits of resources: memory, files, processes, processor time, and what goes with them.

use std::fs;

use genom_configuration::CellLimits;
use rustix::process::{Resource, Rlimit, getrlimit, getuid, setpriority_process, setrlimit};
use rustix::thread::{CpuSet, sched_setaffinity};

/// Microseconds from the signal that tells a thread to wait (`SIGXCPU`) to the one that ends the
/// process whatever it does about it.
const GRACE: u64 = 1_000_000;

/// Sets what is given; returns what could not be set.
pub(crate) fn limit(limits: &CellLimits) -> Vec<String> {
    let mut missing = Vec::new();
    if let Some(score) = limits.oom_score_adj
        && let Err(error) = fs::write("/proc/self/oom_score_adj", score.to_string())
    {
        missing.push(format!(
            "oom_score_adj = {score}: {error} (less than the daemon's own needs CAP_SYS_RESOURCE)"
        ));
    }
    if let Some(nice) = limits.nice
        && let Err(error) = setpriority_process(None, nice)
    {
        missing.push(format!("nice = {nice}: {error} (see RLIMIT_NICE, CAP_SYS_NICE)"));
    }
    if let Some(cpus) = &limits.cpus {
        let mut set = CpuSet::new();
        cpus.iter().filter(|cpu| **cpu < CpuSet::MAX_CPU).for_each(|cpu| set.set(*cpu));
        if let Err(error) = sched_setaffinity(None, &set) {
            missing.push(format!("cpus = {cpus:?}: {error}: this machine has none of them"));
        }
    }
    // Private writable memory, not address space (RLIMIT_AS): the C library reserves 64 MiB of
    // addresses for each thread that allocates, and uses few of them.
    let bytes = limits.memory.map(|mebibytes| mebibytes << 20);
    missing.extend(set(Resource::Data, "memory", bytes, 0));
    missing.extend(set(Resource::Nofile, "files", limits.files, 0));
    if let Some(most) = limits.processes.filter(|most| *most > 0) {
        missing.extend(set(Resource::Nproc, "processes", Some(most), 0));
        if getuid().is_root() {
            missing.push(format!(
                "processes = {most} has no effect: the kernel counts no processes of root; run the \
                 daemon as a user, or set processes = 0"
            ));
        }
    }
    let microseconds = limits.rttime.map(|milliseconds| milliseconds * 1000);
    missing.extend(set(Resource::Rttime, "rttime", microseconds, GRACE));
    if limits.real_time == Some(false) {
        missing.extend(set(Resource::Rtprio, "real_time", Some(0), 0));
    }
    missing
}

/// Sets one limit, for good: the hard one is `grace` above the soft one. Says why not.
fn set(resource: Resource, key: &str, wanted: Option<u64>, grace: u64) -> Option<String> {
    let wanted = wanted?;
    let allowed = getrlimit(resource).maximum;
    let within = |limit: u64| Some(allowed.map_or(limit, |allowed| limit.min(allowed)));
    let new = Rlimit { current: within(wanted), maximum: within(wanted + grace) };
    if let Err(error) = setrlimit(resource, new) {
        return Some(format!("{key} cannot be limited: {error}"));
    }
    // A lower limit than the wanted one holds, too: nothing to tell but where more is expected.
    let less = allowed.filter(|allowed| *allowed < wanted)?;
    let unit = if resource == Resource::Data { " bytes" } else { "" };
    Some(format!("{key}: the daemon itself is limited to {less}{unit}, so the cell is, too"))
}
