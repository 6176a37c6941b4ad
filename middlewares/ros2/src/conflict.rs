//! Ends that cannot be at one address, whatever carries ROS.

use std::sync::{Condvar, MutexGuard};
use std::time::{Duration, Instant};

use genom_middleware::{Address, EndpointKind, OpenError};

use crate::settled::settled;

/// How long the news that an end was closed elsewhere may take to arrive.
const GRACE: Duration = Duration::from_millis(100);

/// Why an end cannot be opened where another one is.
#[derive(Debug, PartialEq, Eq)]
pub(crate) enum Conflict {
    /// The other one has these types.
    Types(String),
    /// The other one is alone there.
    Taken,
}

/// Whether an end is one of a port. Ports and services do not conflict with each other.
pub(crate) fn is_port(kind: EndpointKind) -> bool {
    kind != EndpointKind::Service
}

/// Whether there may be one end of this kind at an address only.
pub(crate) fn is_alone(kind: EndpointKind) -> bool {
    kind != EndpointKind::Subscription
}

impl Conflict {
    /// That of an end of this kind and digest of its types with another one at its address.
    pub(crate) fn between(
        (kind, digest): (EndpointKind, &str),
        (other, others, types): (EndpointKind, &str, &str),
    ) -> Option<Self> {
        if is_port(kind) != is_port(other) {
            return None;
        }
        if is_port(kind) && digest != others {
            return Some(Self::Types(types.to_owned()));
        }
        (is_alone(kind) && kind == other).then_some(Self::Taken)
    }

    /// The error of whoever wanted to open an end of these types at this address.
    fn refusal(self, address: Address, ours: String) -> OpenError {
        match self {
            Self::Types(theirs) => OpenError::TypeMismatch { address, ours, theirs },
            Self::Taken => OpenError::Taken { address },
        }
    }
}

/// The state in which an end of these types at this address has no conflict. `look` finds one, and
/// whether it is with another end of ours: one with somebody else's may be over soon.
pub(crate) fn unopposed<'a, S>(
    changed: &Condvar,
    state: MutexGuard<'a, S>,
    (at, types): (&Address, &str),
    look: impl Fn(&S) -> Option<(Conflict, bool)>,
) -> Result<MutexGuard<'a, S>, OpenError> {
    let is_last = |found: &Option<(Conflict, bool)>| found.as_ref().is_none_or(|(_, ours)| *ours);
    match settled(changed, state, Instant::now() + GRACE, look, is_last) {
        (state, None) => Ok(state),
        (_, Some((conflict, _))) => Err(conflict.refusal(at.clone(), types.to_owned())),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use EndpointKind::{Publisher, Service, Subscription};

    #[test]
    fn writers_and_services_are_alone_and_both_ends_of_a_port_have_one_type() {
        let between = |ours, other| Conflict::between((ours, "a"), other);
        assert_eq!(between(Publisher, (Publisher, "a", "t")), Some(Conflict::Taken));
        assert_eq!(between(Service, (Service, "b", "t")), Some(Conflict::Taken));
        assert_eq!(between(Publisher, (Subscription, "a", "t")), None);
        assert_eq!(between(Subscription, (Subscription, "a", "t")), None);
        let types = || Some(Conflict::Types("t".to_owned()));
        assert_eq!(between(Subscription, (Publisher, "b", "t")), types());
        assert_eq!(between(Publisher, (Publisher, "b", "t")), types());
        assert_eq!(between(Publisher, (Service, "b", "t")), None);
    }
}
