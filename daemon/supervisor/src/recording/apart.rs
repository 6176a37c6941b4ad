//! Which other processes of this daemon record what they tell themselves.

use std::collections::HashMap;
use std::sync::{Arc, Mutex, PoisonError};

use genom_bus::Teller;

/// The processes of cells that take part in a recording. What they tell is told on to the daemon,
/// too; its own part of the recording leaves that out, since it would be there twice, the second time
/// with the date of its arrival.
#[derive(Debug, Default)]
pub struct Apart(Mutex<HashMap<Arc<str>, Since>>);

#[derive(Clone, Copy, Debug)]
struct Since {
    process: u32,
    /// Number of the last change before its recording.
    after: u64,
}

impl Apart {
    /// This process of a cell records what it tells after change number `after`; the process before
    /// it has ended.
    pub fn begins(&self, cell: &str, process: u32, after: u64) {
        let mut all = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        all.insert(cell.into(), Since { process, after });
    }

    /// Whether what was told is in the recording of who told it.
    pub(super) fn has(&self, teller: &Teller) -> bool {
        let all = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        all.get(&teller.cell)
            .is_some_and(|since| since.process == teller.process && since.after < teller.id)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_change_is_in_the_recording_of_its_process_if_it_came_after_its_beginning() {
        let apart = Apart::default();
        let has = |process, id| apart.has(&Teller { cell: "arm".into(), process, id });
        assert!(!has(7, 4), "no process of that cell is recorded");
        apart.begins("arm", 7, 3);
        assert_eq!([has(7, 3), has(7, 4)], [false, true]);
        assert!(!has(8, 4), "the next process is not recorded yet");
        apart.begins("arm", 8, 0);
        assert!(has(8, 1) && !has(7, 4));
        assert!(!apart.has(&Teller { cell: "leg".into(), process: 8, id: 1 }));
    }
}
