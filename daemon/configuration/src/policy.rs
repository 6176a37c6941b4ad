//! Policies of connections as text: `latest`, `queue:N`, `ring:N`.

use genom_middleware::Policy;

/// What is accepted.
pub const HELP: &str = "a policy is `latest`, `queue:N` (oldest first, new ones dropped when N wait) or `ring:N` \
     (oldest first, oldest overwritten), N from 1 to 65536";

/// Most samples a reader may have waiting.
const MOST: usize = 65_536;

/// Reads a policy.
pub fn parse(text: &str) -> Option<Policy> {
    if text == "latest" {
        return Some(Policy::Latest);
    }
    let (kind, number) = text.split_once(':')?;
    let number = number.parse().ok().filter(|number| (1..=MOST).contains(number))?;
    match kind {
        "queue" => Some(Policy::Queue(number)),
        "ring" => Some(Policy::Ring(number)),
        _ => None,
    }
}

/// Writes a policy.
pub fn text(policy: Policy) -> String {
    match policy {
        Policy::Latest => "latest".to_owned(),
        Policy::Queue(number) => format!("queue:{number}"),
        Policy::Ring(number) => format!("ring:{number}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn policies_read_back_as_written() {
        for policy in [Policy::Latest, Policy::Queue(1), Policy::Ring(65_536)] {
            assert_eq!(parse(&text(policy)), Some(policy));
        }
        for wrong in ["", "last", "queue", "queue:", "queue:0", "ring:-1", "ring:65537", "x:3"] {
            assert_eq!(parse(wrong), None, "{wrong}");
        }
    }
}
