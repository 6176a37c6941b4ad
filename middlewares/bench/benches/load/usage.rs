//! Processor time of this process.

use std::fs;
use std::time::Duration;

/// Clock ticks of `/proc` in a second (`sysconf(_SC_CLK_TCK)`), 100 on all machines with Linux.
const TICKS: u64 = 100;

/// Processor time of all threads so far, `proc_pid_stat(5)`.
pub(crate) fn processor() -> Duration {
    let stat = fs::read_to_string("/proc/self/stat").unwrap_or_default();
    // The name of the program before it may contain spaces.
    let after = stat.rsplit_once(')').map_or("", |(_, after)| after);
    let ticks: u64 =
        after.split_whitespace().skip(11).take(2).filter_map(|word| word.parse::<u64>().ok()).sum();
    Duration::from_millis(ticks * 1000 / TICKS)
}
