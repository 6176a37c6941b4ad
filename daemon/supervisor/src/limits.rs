//! Limits of the system on this process: raises them as far as allowed, and reports when one is
//! reached.

use rustix::process::{Resource, Rlimit, getrlimit, setrlimit};

/// If fewer than this many files can still be opened, the limit counts as reached: the failed
/// operation may have closed some already.
const CLOSE: usize = 32;

/// Raises the limit of open files to its hard limit. The lower soft limit set by shells and systemd
/// protects programs that use `select`, which this one does not. Programs that codels start inherit
/// the higher limit.
pub fn raise() {
    let Rlimit { current, maximum } = getrlimit(Resource::Nofile);
    let shown = |limit: Option<u64>| limit.map_or("any number".to_owned(), |most| most.to_string());
    if current == maximum {
        tracing::debug!("up to {} open files are allowed", shown(current));
        return;
    }
    match setrlimit(Resource::Nofile, Rlimit { current: maximum, maximum }) {
        Ok(()) => {
            let (before, now) = (shown(current), shown(maximum));
            tracing::debug!("up to {now} open files are allowed, raised from {before}");
        }
        Err(error) => tracing::warn!("the limit of open files stays {}: {error}", shown(current)),
    }
}

/// The limit that is reached, as text to append to an error; empty if none is.
pub fn reached() -> String {
    let most = getrlimit(Resource::Nofile).current.and_then(|most| usize::try_from(most).ok());
    // If this directory cannot be opened, no file can.
    let open = std::fs::read_dir("/proc/self/fd").map(Iterator::count);
    told(most, open.ok())
}

fn told(most: Option<usize>, open: Option<usize>) -> String {
    match (most, open) {
        (Some(most), open) if open.is_none_or(|open| open + CLOSE >= most) => format!(
            "; this process may have {most} files open, and has them: allow more by \
             `LimitNOFILE=` of its systemd unit or `ulimit -Hn` of its shell"
        ),
        _ => String::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_limit_is_named_when_it_is_reached_and_not_before() {
        assert_eq!(told(Some(1024), Some(900)), "");
        assert_eq!(told(None, Some(900)), "");
        for open in [Some(1000), Some(1024), None] {
            let told = told(Some(1024), open);
            assert!(told.contains("1024 files") && told.contains("LimitNOFILE="), "{told}");
        }
    }
}
