//! Libraries whose threads outlive them. One of the few unsafe modules.
#![allow(unsafe_code)]

use super::{Library, threads};

impl Library {
    /// Whether threads that codels started are still in its code, now that nobody calls it any
    /// more: it then stays mapped for good, and what its threads may hold has to stay as well.
    ///
    /// A library with functions of its own for the end is believed to end its threads there.
    pub(crate) fn is_outlived(&mut self) -> bool {
        let parts = self.mappings.iter().filter(|part| part.executable);
        let code: Vec<_> = parts.map(|part| part.range.clone()).collect();
        if threads::inside(&code) == 0 {
            return false;
        }
        match self.finishers {
            Some((_, more)) if more > 1 => return false,
            Some((at, 1)) => self.finish(at),
            _ => {}
        }
        let left = threads::inside(&code);
        if left > 0 {
            tracing::warn!(
                "{}: {left} of its threads run on, so its code and IDS stay in memory; end them \
                 in the task's codel<stop>",
                self.path.display()
            );
            self.handle.keep();
        }
        left > 0
    }

    /// Destroys its C++ objects: threads may be theirs. Closing does not do so again.
    fn finish(&self, at: u64) {
        let base = self.mappings.iter().map(|part| part.range.start).min();
        let place = base.zip(usize::try_from(at).ok()).map(|(base, at)| base + at);
        let lies = |place: &usize| self.mappings.iter().any(|part| part.range.contains(place));
        if let Some(place) = place.filter(lies) {
            // SAFETY: the file says that its finishing functions are there.
            unsafe { self.handle.finish(place) }
        }
    }
}
