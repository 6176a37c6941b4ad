//! Which accesses to the IDS get in each other's way (genom3.md 4.5).
//!
//! The description computes the exclusion of one sequential control task. This runtime serves
//! requests side by side, so it also needs the conflicts among what the control task would run.

use genom_description::model::{Codel, Direction, PathStep, Service, Source};

/// One access to the IDS.
struct Access<'a> {
    path: &'a [PathStep],
    writes: bool,
}

fn of_codel(codel: &Codel) -> Vec<Access<'_>> {
    let access = |parameter: &'_ genom_description::model::CodelParameter| match &parameter.source {
        Source::Ids { .. } => Some(parameter.direction != Direction::In),
        _ => None,
    };
    let path = |source| match source {
        &Source::Ids { ref path } => path.as_slice(),
        _ => &[],
    };
    let parameters = codel.parameters.iter();
    parameters
        .filter_map(|p| access(p).map(|writes| Access { path: path(&p.source), writes }))
        .collect()
}

/// An attribute `in x` writes `ids.x`, an `out x` reads it.
fn of_transfer(service: &Service) -> Vec<Access<'_>> {
    let parameters = service.parameters.iter();
    parameters
        .filter_map(|parameter| {
            let target = parameter.target.as_ref()?;
            Some(Access { path: &target.path, writes: parameter.direction != Direction::Out })
        })
        .collect()
}

fn conflict(first: &[Access<'_>], second: &[Access<'_>]) -> bool {
    let pair = |a: &Access<'_>, b: &Access<'_>| {
        (a.writes || b.writes) && a.path.iter().zip(b.path).all(|(x, y)| x == y)
    };
    first.iter().any(|a| second.iter().any(|b| pair(a, b)))
}

/// What an exclusion node touches.
pub(super) enum Touching<'a> {
    Codel(&'a Codel),
    Transfer(&'a Service),
}

impl Touching<'_> {
    fn accesses(&self) -> Vec<Access<'_>> {
        match self {
            Touching::Codel(codel) => of_codel(codel),
            Touching::Transfer(service) => of_transfer(service),
        }
    }

    /// Whether the two must not run at the same time because of the IDS.
    pub(super) fn conflicts(&self, other: &Touching<'_>) -> bool {
        conflict(&self.accesses(), &other.accesses())
    }
}
