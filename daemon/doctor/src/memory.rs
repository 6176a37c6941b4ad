//! Shared memory that killed programs left behind, and damaged segments.

use std::fs;
use std::os::unix::fs::MetadataExt as _;

use genom_protocol::Diagnosis;

use crate::machine::Machine;

/// Prefixes of names of segments: genomd's default, and that of iceoryx2.
pub(crate) const PREFIXES: [&str; 2] = ["genomd_", "iox2_"];

/// Suffixes of names of iceoryx2's segments.
const KINDS: [&str; 5] = [".dynamic", ".data", ".connection", ".event_mgmt", ".global_mgmt"];

/// Maximum number of damaged segments that are listed.
const NAMED: usize = 3;

/// Directories of iceoryx2's files: those of each user's daemons, and iceoryx2's default.
pub(crate) fn roots(machine: &Machine) -> Vec<String> {
    let below = |folder: &str, start: &str, rest: &str| {
        let found = fs::read_dir(machine.path(folder)).into_iter().flatten().flatten();
        let names = found.filter_map(|entry| entry.file_name().into_string().ok());
        let names = names.filter(|name| name.starts_with(start));
        names.map(|name| format!("{folder}/{name}{rest}")).collect::<Vec<_>>()
    };
    let mut roots = vec!["/tmp/iceoryx2".to_owned()];
    roots.extend(below("/dev/shm", "genomd-", "/iceoryx2"));
    roots.extend(below("/run/user", "", "/genomd/iceoryx2"));
    roots
}

/// Checks for iceoryx2 nodes of dead processes. A node is a directory whose name, a number,
/// contains the process identifier.
pub(crate) fn nodes(machine: &Machine, roots: &[String]) -> Diagnosis {
    const ABOUT: &str = "iceoryx2 nodes";
    let (mut live, mut stale) = (0, Vec::new());
    for root in roots {
        let nodes = fs::read_dir(machine.path(&format!("{root}/nodes")));
        for node in nodes.into_iter().flatten().flatten() {
            let name = node.file_name();
            let Some(id) = name.to_str().and_then(|name| name.parse::<u128>().ok()) else {
                continue;
            };
            let process = (id >> 64) & u128::from(u32::MAX);
            if machine.path(&format!("/proc/{process}")).exists() {
                live += 1;
            } else {
                stale.push(process.to_string());
            }
        }
    }
    if stale.is_empty() {
        return Diagnosis::ok(ABOUT, format!("{live} at work, none left behind"));
    }
    stale.sort();
    let what = format!("left behind by processes that are gone: {}", stale.join(", "));
    Diagnosis::note(ABOUT, what, "the next `genomd --backend shm` removes what they left")
}

/// Checks for segments that were never completed or were truncated.
pub(crate) fn segments(machine: &Machine, prefixes: &[&str]) -> Diagnosis {
    const ABOUT: &str = "iceoryx2 segments";
    let (mut whole, mut damaged) = (0, Vec::new());
    for entry in fs::read_dir(machine.path("/dev/shm")).into_iter().flatten().flatten() {
        let name = entry.file_name().to_string_lossy().into_owned();
        let one = prefixes.iter().any(|prefix| name.starts_with(prefix));
        let Ok(told) = entry.metadata() else { continue };
        if !one || !KINDS.iter().any(|kind| name.ends_with(kind)) {
            continue;
        }
        let (mode, owner) = (told.mode() & 0o7777, told.uid());
        if told.len() == 0 {
            damaged.push(format!("/dev/shm/{name} has no bytes (user {owner}, mode {mode:o})"));
        } else if mode & 0o400 == 0 {
            damaged
                .push(format!("/dev/shm/{name} was never finished (user {owner}, mode {mode:o})"));
        } else {
            whole += 1;
        }
    }
    if damaged.is_empty() {
        return Diagnosis::ok(ABOUT, format!("{whole} there, none damaged"));
    }
    damaged.sort();
    let more = damaged.len().saturating_sub(NAMED);
    damaged.truncate(NAMED);
    let more = if more == 0 { String::new() } else { format!("; and {more} more") };
    let what = format!("programs wait that open them: {}{more}", damaged.join("; "));
    let fix = "`genomd --backend shm` on the same folder removes those of killed programs; `rm` \
               those that stay";
    Diagnosis::problem(ABOUT, what, fix)
}
