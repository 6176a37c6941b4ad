//! Whether the system ended processes for want of memory: the kernel counts them for the control
//! group of the daemon, which its cells share.

use std::fs;
use std::path::PathBuf;
use std::sync::Mutex;

/// The count that was seen last.
#[derive(Debug)]
pub(super) struct Shortage {
    /// `memory.events` of the control group; `None` without groups of version 2.
    events: Option<PathBuf>,
    seen: Mutex<Option<u64>>,
}

impl Shortage {
    pub(super) fn new() -> Self {
        let groups = fs::read_to_string("/proc/self/cgroup").unwrap_or_default();
        let own = groups.lines().find_map(|line| line.strip_prefix("0::/"));
        Self::of(own.map(|own| PathBuf::from("/sys/fs/cgroup").join(own).join("memory.events")))
    }

    fn of(events: Option<PathBuf>) -> Self {
        let new = Self { events, seen: Mutex::default() };
        let now = new.count();
        Self { seen: Mutex::new(now), ..new }
    }

    fn count(&self) -> Option<u64> {
        let text = fs::read_to_string(self.events.as_ref()?).ok()?;
        let count = text.lines().find_map(|line| line.strip_prefix("oom_kill "))?;
        count.trim().parse().ok()
    }

    /// Whether there were more since the last question; `None` if that cannot be told.
    pub(super) fn came(&self) -> Option<bool> {
        let now = self.count()?;
        let mut seen = self.seen.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        Some(seen.replace(now)? < now)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_process_ended_for_want_of_memory_is_told_once() {
        let scratch = tempfile::tempdir().unwrap();
        let events = scratch.path().join("memory.events");
        let write = |count: u32| fs::write(&events, format!("oom 9\noom_kill {count}\n")).unwrap();
        write(3);
        let shortage = Shortage::of(Some(events.clone()));
        assert_eq!(shortage.came(), Some(false));
        write(4);
        assert_eq!(shortage.came(), Some(true));
        assert_eq!(shortage.came(), Some(false));
        assert_eq!(Shortage::of(None).came(), None);
    }
}
