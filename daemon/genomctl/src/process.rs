//! State of the daemon's process, from `/proc`.

/// Whether a process is stopped, by a signal or a debugger.
pub(crate) fn is_stopped(process: i32) -> bool {
    let status = std::fs::read_to_string(format!("/proc/{process}/stat")).unwrap_or_default();
    // The name of the process, before the state, may contain any characters.
    let state = status.rsplit_once(')').and_then(|(_, rest)| rest.trim_start().chars().next());
    matches!(state, Some('T' | 't'))
}
