//! How a process ended, in words.

use std::fmt;

use genom_host::signal_name;

/// How the process of a cell ended.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum End {
    /// It returned from `main`, or called `exit`.
    Exited(i32),
    /// A signal ended it.
    Signal(i32),
    /// It was not this daemon's child: nobody knows.
    Unknown,
    /// It did not answer, and was killed for it.
    Silent(std::time::Duration),
    /// It was not ready in time, and was killed for it.
    NotReady(std::time::Duration),
    /// It ended itself, for a rule of supervision that was broken.
    Supervised(String),
    /// It could not be started.
    NotStarted(String),
    /// It refused to run as it is configured.
    Refused(String),
}

impl End {
    /// Whether a restart policy of `on-failure` restarts after it.
    pub(crate) fn is_failure(&self) -> bool {
        *self != Self::Exited(0)
    }
}

impl fmt::Display for End {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Exited(status) => write!(f, "exit status {status}"),
            Self::Signal(signal) => match signal_name(*signal) {
                Some(name) => write!(f, "signal {signal} ({name})"),
                None => write!(f, "signal {signal}"),
            },
            Self::Unknown => f.write_str("ended; its status went to the daemon that started it"),
            Self::Silent(limit) => {
                write!(f, "killed: it answered nothing for {} s", limit.as_secs_f64())
            }
            Self::NotReady(limit) => {
                write!(f, "killed: it was not ready within {} s", limit.as_secs_f64())
            }
            Self::Supervised(why) => write!(f, "ended by its supervision: {why}"),
            Self::NotStarted(why) => write!(f, "not started: {why}"),
            Self::Refused(why) => write!(f, "refused: {why}"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_end_is_told_in_words() {
        assert_eq!(End::Signal(11).to_string(), "signal 11 (SIGSEGV)");
        assert_eq!(End::Signal(40).to_string(), "signal 40");
        assert_eq!(End::Exited(3).to_string(), "exit status 3");
        assert!(End::Exited(3).is_failure() && !End::Exited(0).is_failure());
    }
}
