//! What a service manager leaves in the environment of a process that it starts.

use std::ffi::OsString;
use std::time::Duration;

use genom_host::take_variable;

/// What a service manager left in the environment.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Invitation {
    /// `NOTIFY_SOCKET`: where it listens.
    pub(crate) socket: Option<OsString>,
    /// `WATCHDOG_USEC`: how long it waits for a sign of life.
    pub(crate) watchdog: Option<Duration>,
}

impl Invitation {
    /// Takes it out of the environment. To be called before there are other threads.
    #[must_use]
    pub fn take() -> Self {
        let text = |name| take_variable(name).and_then(|value| value.into_string().ok());
        Self {
            socket: take_variable("NOTIFY_SOCKET"),
            watchdog: watchdog(
                text("WATCHDOG_USEC").as_deref(),
                text("WATCHDOG_PID").as_deref(),
                std::process::id(),
            ),
        }
    }
}

/// The time of the watchdog, unless it is meant for another process.
fn watchdog(time: Option<&str>, pid: Option<&str>, own: u32) -> Option<Duration> {
    let meant = pid.is_none_or(|pid| pid.parse() == Ok(own));
    let time = time?.parse().ok().filter(|time| *time > 0 && meant)?;
    Some(Duration::from_micros(time))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_watchdog_for_another_process_or_without_a_time_is_none() {
        let second = Some(Duration::from_secs(1));
        assert_eq!(watchdog(Some("1000000"), None, 7), second);
        assert_eq!(watchdog(Some("1000000"), Some("7"), 7), second);
        for (time, pid) in [
            (None, None),
            (Some("1000000"), Some("8")),
            (Some("1000000"), Some("")),
            (Some("0"), None),
            (Some("soon"), None),
            (Some("-1"), None),
        ] {
            assert_eq!(watchdog(time, pid, 7), None, "{time:?} {pid:?}");
        }
    }
}
