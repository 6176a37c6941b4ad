//! Policies of connections: which unread samples are kept for the reader.

use std::fmt;
use std::str::FromStr;

/// Which unread samples are kept for the reader: `latest`, `queue:N` or `ring:N`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Policy {
    /// Only the newest sample.
    #[default]
    Latest,
    /// A queue of at most N samples, oldest first; when it is full, new samples are dropped.
    Queue(usize),
    /// A queue of at most N samples, oldest first; when it is full, a new sample replaces the
    /// oldest.
    Ring(usize),
}

/// The text is not a policy.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "a policy is `latest`, `queue:N` (oldest first, new ones dropped when N wait) or `ring:N` \
     (oldest first, oldest overwritten), N from 1 to 65536"
)]
pub struct NoPolicy;

/// Maximum number of samples kept for a reader.
const MOST: usize = 65_536;

impl FromStr for Policy {
    type Err = NoPolicy;

    fn from_str(text: &str) -> Result<Self, NoPolicy> {
        if text == "latest" {
            return Ok(Self::Latest);
        }
        let (kind, number) = text.split_once(':').ok_or(NoPolicy)?;
        let number = number.parse().ok().filter(|number| (1..=MOST).contains(number));
        match (kind, number) {
            ("queue", Some(number)) => Ok(Self::Queue(number)),
            ("ring", Some(number)) => Ok(Self::Ring(number)),
            _ => Err(NoPolicy),
        }
    }
}

impl fmt::Display for Policy {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Latest => f.write_str("latest"),
            Self::Queue(number) => write!(f, "queue:{number}"),
            Self::Ring(number) => write!(f, "ring:{number}"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn policies_read_back_as_written() {
        for policy in [Policy::Latest, Policy::Queue(1), Policy::Ring(65_536)] {
            assert_eq!(policy.to_string().parse(), Ok(policy));
        }
        for wrong in ["", "last", "queue", "queue:", "queue:0", "ring:-1", "ring:65537", "x:3"] {
            assert_eq!(wrong.parse::<Policy>(), Err(NoPolicy), "{wrong}");
        }
    }
}
