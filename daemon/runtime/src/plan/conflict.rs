//! Conflicting accesses to the IDS (genom3.md 4.5).
//!
//! The description computes the exclusion for a single, sequential control task. This runtime
//! serves requests in parallel, so it also needs the conflicts among nodes of the control task.

use genom_description::model::{Codel, Direction, PathStep, Service, Source};

/// One access to the IDS.
struct Access<'a> {
    path: &'a [PathStep],
    writes: bool,
}

/// The parts of the model from which the accesses of an exclusion node follow.
pub(super) enum Touching<'a> {
    Codel(&'a Codel),
    Transfer(&'a Service),
}

impl<'a> Touching<'a> {
    fn accesses(&self) -> Vec<Access<'a>> {
        match *self {
            Touching::Codel(codel) => {
                let parameters = codel.parameters.iter();
                let accesses = parameters.filter_map(|parameter| match &parameter.source {
                    Source::Ids { path } => {
                        Some(Access { path, writes: parameter.direction != Direction::In })
                    }
                    _ => None,
                });
                accesses.collect()
            }
            // An attribute `in x` writes `ids.x`, an `out x` reads it.
            Touching::Transfer(service) => {
                let parameters = service.parameters.iter();
                let accesses = parameters.filter_map(|parameter| {
                    let path = &parameter.target.as_ref()?.path;
                    Some(Access { path, writes: parameter.direction != Direction::Out })
                });
                accesses.collect()
            }
        }
    }

    /// Whether two nodes must not run at the same time because of the IDS.
    pub(super) fn conflicts(&self, other: &Touching<'_>) -> bool {
        let theirs = other.accesses();
        self.accesses().iter().any(|a| {
            theirs
                .iter()
                .any(|b| (a.writes || b.writes) && a.path.iter().zip(b.path).all(|(x, y)| x == y))
        })
    }
}
