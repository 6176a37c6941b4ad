//! Locks the memory of the process in RAM, so that no task waits for a page.

use rustix::io::Result;
use rustix::mm::{MlockAllFlags, mlockall};

/// Locks present and future memory. Returns why not, if that is not permitted.
#[must_use]
pub fn lock_memory() -> Option<String> {
    refusal(mlockall(MlockAllFlags::CURRENT | MlockAllFlags::FUTURE))
}

fn refusal(locked: Result<()>) -> Option<String> {
    locked.err().map(|error| {
        format!(
            "memory is not locked: {error} (RLIMIT_MEMLOCK: `LimitMEMLOCK=infinity` of its systemd \
             unit, `ulimit -l unlimited`, or CAP_IPC_LOCK); pages may be swapped out"
        )
    })
}

#[cfg(test)]
mod tests {
    use rustix::io::Errno;

    use super::*;

    #[test]
    fn a_refusal_says_what_would_be_needed() {
        assert_eq!(refusal(Ok(())), None);
        for why in [Errno::PERM, Errno::NOMEM] {
            let told = refusal(Err(why)).unwrap();
            assert!(told.contains(&why.to_string()) && told.contains("RLIMIT_MEMLOCK"), "{told}");
        }
    }
}
