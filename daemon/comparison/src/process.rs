//! What a process and all processes below it take.

use std::fs;
use std::time::Duration;

/// Unit of processor time in `/proc/PID/stat`: Linux has 100 of them in a second on all processors
/// that Rust's standard library supports.
const TICK: Duration = Duration::from_millis(10);

/// What a process and all below it have taken.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Usage {
    /// Time of processors, of the processes that run now and of ended ones they have waited for.
    pub processor: Duration,
    /// Memory in bytes: what a process shares with others counts in proportion.
    pub memory: u64,
    /// Number of processes.
    pub processes: usize,
}

impl Usage {
    /// Reads it from `/proc`; processes that end meanwhile are left out.
    #[must_use]
    pub fn of(root: u32) -> Self {
        let all: Vec<Stat> = fs::read_dir("/proc")
            .into_iter()
            .flatten()
            .flatten()
            .filter_map(|entry| entry.file_name().to_str()?.parse().ok())
            .filter_map(Stat::of)
            .collect();
        let mut tree = vec![root];
        let mut at = 0;
        while let Some(parent) = tree.get(at).copied() {
            tree.extend(all.iter().filter(|one| one.parent == parent).map(|one| one.id));
            at += 1;
        }
        let mine = all.iter().filter(|one| tree.contains(&one.id));
        mine.fold(Self::default(), |sum, one| Self {
            processor: sum.processor + TICK.saturating_mul(one.ticks),
            memory: sum.memory + memory(one.id),
            processes: sum.processes + 1,
        })
    }
}

/// What `/proc/PID/stat` says (proc_pid_stat(5)).
struct Stat {
    id: u32,
    parent: u32,
    ticks: u32,
}

impl Stat {
    fn of(id: u32) -> Option<Self> {
        Self::read(id, &fs::read_to_string(format!("/proc/{id}/stat")).ok()?)
    }

    fn read(id: u32, text: &str) -> Option<Self> {
        // The name of the process, in parentheses, may contain any characters. Field 3 follows it.
        let fields: Vec<&str> = text.rsplit_once(')')?.1.split_whitespace().collect();
        let field = |number: usize| fields.get(number - 3)?.parse::<u32>().ok();
        // utime, stime, cutime, cstime.
        let ticks = [14, 15, 16, 17].into_iter().map(field).sum::<Option<u32>>()?;
        Some(Self { id, parent: field(4)?, ticks })
    }
}

/// Proportional set size in bytes; where that may not be read, the resident set.
fn memory(process: u32) -> u64 {
    let value = |file: &str, key: &str| {
        let text = fs::read_to_string(format!("/proc/{process}/{file}")).ok()?;
        let line = text.lines().find_map(|line| line.strip_prefix(key))?;
        line.split_whitespace().next()?.parse::<u64>().ok()
    };
    value("smaps_rollup", "Pss:").or_else(|| value("status", "VmRSS:")).unwrap_or(0) * 1024
}

#[cfg(test)]
mod tests {
    use std::process::Command;
    use std::thread;
    use std::time::Instant;

    use rustix::process::{Pid, Signal, kill_process};

    use super::*;

    #[test]
    fn a_process_counts_with_those_below_it() {
        let mut child = Command::new("sh").args(["-c", "sleep 60 & wait"]).spawn().unwrap();
        let end = Instant::now() + Duration::from_secs(60);
        let below = loop {
            let usage = Usage::of(child.id());
            if usage.processes == 2 || Instant::now() > end {
                break usage;
            }
            thread::yield_now();
        };
        let sleeping = fs::read_to_string(format!("/proc/{0}/task/{0}/children", child.id()));
        for pid in
            sleeping.unwrap_or_default().split_whitespace().filter_map(|pid| pid.parse().ok())
        {
            let _ = kill_process(Pid::from_raw(pid).unwrap(), Signal::KILL);
        }
        let _ = child.kill();
        child.wait().unwrap();
        assert!(below.processes == 2 && below.memory > 0, "{below:?}");
        assert_eq!(Usage::of(child.id()), Usage::default());
    }

    #[test]
    fn the_name_of_a_process_is_no_field() {
        let text = "7 (a ) R 1) S 3 7 7 0 -1 0 0 0 0 0 11 22 33 44 20 0 1 0 5 1 1";
        let stat = Stat::read(7, text).unwrap();
        assert_eq!((stat.parent, stat.ticks), (3, 110));
    }
}
