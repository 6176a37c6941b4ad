//! Whether shared memory has room left. The system gives its pages when they are first written,
//! and ends the process (SIGBUS) when there are none: a container has 64 MB unless told otherwise.
//!
//! So ports are opened only while something is left, and large samples are asked for before they
//! are written for the first time. Small ones live on what is kept free.

use genom_middleware::{Address, OpenError};

use crate::error::failed;

/// Samples from this size on are asked for.
const LARGE: usize = 64 << 10;

/// Samples of one port that are remembered; those beyond are asked for each time.
const REMEMBERED: usize = 256;

/// Bytes left; as many as there can be where the system does not tell.
fn left() -> u64 {
    let told = rustix::fs::statvfs("/dev/shm");
    told.map_or(u64::MAX, |memory| memory.f_bavail.saturating_mul(memory.f_frsize))
}

/// Refuses to open what would take from the bytes that are kept free.
pub(crate) fn check(at: &Address, keep_free: u64) -> Result<(), OpenError> {
    let left = left();
    if left >= keep_free {
        return Ok(());
    }
    Err(failed(at, &format!("only {} KiB of shared memory are left: {WAY_OUT}", left >> 10)))
}

/// What to do about it.
pub(crate) const WAY_OUT: &str = "enlarge /dev/shm (`mount -o remount,size=1G /dev/shm`, `docker \
                                  run --shm-size=1g`), or remove what fills it";

/// The samples of a port that were written before: their pages are there.
#[derive(Debug)]
pub(crate) struct Written {
    /// Addresses and sizes. Never longer than its first capacity: writing allocates nothing.
    samples: Vec<(usize, usize)>,
    keep_free: u64,
}

impl Written {
    /// None yet, of samples of this size, or of any size.
    pub(crate) fn new(size: Option<usize>, keep_free: u64) -> Self {
        let remembered = if size.is_some_and(|size| size < LARGE) { 0 } else { REMEMBERED };
        Self { samples: Vec::with_capacity(remembered), keep_free }
    }

    /// Whether a sample may be written there.
    pub(crate) fn may(&mut self, at: usize, size: usize) -> bool {
        if size < LARGE {
            return true;
        }
        let known = self.samples.iter().position(|(address, _)| *address == at);
        let known = known.and_then(|rank| self.samples.get_mut(rank));
        if known.as_ref().is_some_and(|(_, written)| *written >= size) {
            return true;
        }
        if left() < self.keep_free.saturating_add(size as u64) {
            return false;
        }
        if let Some((_, written)) = known {
            *written = size;
        } else if self.samples.len() < self.samples.capacity() {
            self.samples.push((at, size));
        }
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn large_samples_are_asked_for_once() {
        let mut written = Written::new(None, 0);
        assert!(written.may(4096, LARGE) && written.may(8192, 2 * LARGE));
        // From now on nothing is left.
        written.keep_free = u64::MAX;
        assert!(written.may(4096, LARGE) && written.may(8192, LARGE) && written.may(1, LARGE - 1));
        assert!(!written.may(4096, LARGE + 1) && !written.may(12288, LARGE));
    }
}
