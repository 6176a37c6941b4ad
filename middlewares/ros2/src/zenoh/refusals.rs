//! What was refused of other sessions: counted by reason, with at most one line per second in the
//! log.

use std::sync::atomic::{AtomicU64, Ordering};

use genom_kit::complaints::Complaints;
use genom_middleware::Refused;

/// Why something was refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Reason {
    /// The key of a liveliness token is none that ROS nodes or daemons use.
    Token,
    /// There are too many sessions with ends.
    Sessions,
    /// A session, or all together, has too many ends.
    Ends,
    /// A daemon tells of too many types that an in port could read.
    Types,
    /// An attachment has another form than that of `rmw_zenoh`.
    Attachment,
    /// A sample is larger than allowed.
    Sample,
    /// Too many requests of a service wait for their replies.
    Requests,
}

impl Reason {
    const ALL: [Self; 7] = [
        Self::Token,
        Self::Sessions,
        Self::Ends,
        Self::Types,
        Self::Attachment,
        Self::Sample,
        Self::Requests,
    ];

    pub(crate) fn text(self) -> &'static str {
        match self {
            Self::Token => "no liveliness token of ROS",
            Self::Sessions => "sessions above [backends.ros2] participants",
            Self::Ends => "too many writers, readers and services",
            Self::Types => "too many names for the type of a topic",
            Self::Attachment => "no attachment of rmw_zenoh",
            Self::Sample => "a sample above [backends.ros2] greatest_sample",
            Self::Requests => "too many requests that are not answered yet",
        }
    }
}

/// Counters, written by zenoh's threads and read by any thread.
#[derive(Debug, Default)]
pub(crate) struct Refusals {
    counts: [AtomicU64; Reason::ALL.len()],
    lines: Complaints,
    /// Size in bytes of the largest sample that an in port takes.
    pub(crate) greatest: usize,
}

impl Refusals {
    pub(crate) fn of_samples_above(greatest: usize) -> Self {
        Self { greatest, ..Self::default() }
    }

    /// `of` is the key in question. It is logged with its control characters escaped.
    pub(crate) fn add(&self, why: Reason, of: &str) {
        if let Some(count) = self.counts.get(why as usize) {
            count.fetch_add(1, Ordering::Relaxed);
        }
        if let Some(refused) = self.lines.add() {
            let of: String = of.chars().take(200).collect();
            tracing::warn!(key = ?of, why = why.text(), refused, "refused: from a zenoh session");
        }
    }

    /// Reasons for which something was refused.
    pub(crate) fn list(&self) -> Vec<Refused> {
        let counts = Reason::ALL.into_iter().zip(&self.counts);
        let refused = counts.map(|(why, count)| Refused {
            why: why.text().into(),
            count: count.load(Ordering::Relaxed),
            peer: None,
        });
        refused.filter(|refused| refused.count > 0).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_refused_is_listed_by_reason() {
        let refusals = Refusals::default();
        assert_eq!(refusals.list(), []);
        for why in [Reason::Requests, Reason::Token, Reason::Requests] {
            refusals.add(why, "0/x");
        }
        let list = refusals.list();
        let told: Vec<_> = list.iter().map(|one| (&*one.why, one.count)).collect();
        assert_eq!(told, [(Reason::Token.text(), 1), (Reason::Requests.text(), 2)]);
        assert!(Reason::ALL.into_iter().enumerate().all(|(at, why)| at == why as usize));
    }
}
