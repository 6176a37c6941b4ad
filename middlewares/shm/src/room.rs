//! Checks that shared memory is not full. Linux allocates its pages when they are first written,
//! and kills the process (SIGBUS) if there are none; a container has 64 MB by default.
//!
//! So ports are opened only while memory is left, and before a large sample is written for the
//! first time its memory is checked. Small samples use the reserve that is kept free.

use genom_middleware::{Address, OpenError};

use crate::error::failed;

/// Size in bytes from which a sample counts as large.
const LARGE: usize = 64 << 10;

/// Number of samples per port that are remembered; others are checked each time.
const REMEMBERED: usize = 256;

/// Free bytes; the maximum if the system does not say.
fn left() -> u64 {
    let told = rustix::fs::statvfs("/dev/shm");
    told.map_or(u64::MAX, |memory| memory.f_bavail.saturating_mul(memory.f_frsize))
}

/// Refuses to open a port if not more than `keep_free` bytes are left.
pub(crate) fn check(at: &Address, keep_free: u64) -> Result<(), OpenError> {
    let left = left();
    if left >= keep_free {
        return Ok(());
    }
    Err(failed(at, &format!("only {} KiB of shared memory are left: {WAY_OUT}", left >> 10)))
}

/// What the user can do about it.
pub(crate) const WAY_OUT: &str = "enlarge /dev/shm (`mount -o remount,size=1G /dev/shm`, `docker \
                                  run --shm-size=1g`), or remove what fills it";

/// Samples of a port that were written before, whose pages are therefore allocated.
#[derive(Debug)]
pub(crate) struct Written {
    /// Addresses and sizes. Never grows beyond its initial capacity, so that writing allocates
    /// nothing.
    samples: Vec<(usize, usize)>,
    keep_free: u64,
}

impl Written {
    /// Nothing written yet, for samples of this size or of any size.
    pub(crate) fn new(size: Option<usize>, keep_free: u64) -> Self {
        let remembered = if size.is_some_and(|size| size < LARGE) { 0 } else { REMEMBERED };
        Self { samples: Vec::with_capacity(remembered), keep_free }
    }

    /// Whether a sample may be written at this address.
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
        // From now on, act as if nothing were left.
        written.keep_free = u64::MAX;
        assert!(written.may(4096, LARGE) && written.may(8192, LARGE) && written.may(1, LARGE - 1));
        assert!(!written.may(4096, LARGE + 1) && !written.may(12288, LARGE));
    }
}
