//! Policies of connections: what a reader gets of the samples it has not read.

use std::fmt;
use std::str::FromStr;

/// What a reader gets of the samples it has not read: `latest`, `queue:N` or `ring:N`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Policy {
    /// The newest value only.
    #[default]
    Latest,
    /// Oldest first, at most so many; new ones are dropped while all places are taken.
    Queue(usize),
    /// Oldest first, at most so many; a new one takes the place of the oldest.
    Ring(usize),
}

/// A text that is no policy.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "a policy is `latest`, `queue:N` (oldest first, new ones dropped when N wait) or `ring:N` \
     (oldest first, oldest overwritten), N from 1 to 65536"
)]
pub struct NoPolicy;

/// Most samples a reader may have waiting.
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
