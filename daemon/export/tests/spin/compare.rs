//! Compares what Spin finds of a model with what we find.

use genom_description::model::Owner;
use genom_formal::{Limits, Property, System, Verdict};

use super::run::Checked;
use super::tally::{STATES, Tally};

/// What was compared of a component.
#[derive(Clone, Debug)]
pub(crate) struct Compared {
    pub(crate) tally: Tally,
    #[allow(dead_code, reason = "the bench has no use for it")]
    pub(crate) states: usize,
}

/// However slow the machine is.
pub(crate) fn limits(states: usize) -> Limits {
    Limits { states, time: std::time::Duration::MAX, ..Limits::default() }
}

/// States and verdicts of a component, if it has not more states than that; the first `claims` codels
/// and services are asked for.
pub(crate) fn compare(system: &System, most: usize, claims: usize) -> Option<Compared> {
    let wanted = [Property::Start, Property::Stuck, Property::Reach, Property::Exclude];
    let report = system.check(&wanted, &limits(most));
    let explored = report.explored.unwrap();
    if explored.limit.is_some() {
        return None;
    }
    let verdict = |property: Property| {
        let found = report.verdicts.iter().find(|(known, _)| *known == property);
        &found.unwrap().1
    };
    let holds = |property: Property| match verdict(property) {
        Verdict::Holds => Some(true),
        Verdict::Violated(_) => Some(false),
        Verdict::Undecided(_) => None,
    };
    let spin = Checked::new(system, None);
    let all = spin.all();
    let mut tally = Tally::default();
    let both = holds(Property::Stuck).zip(holds(Property::Exclude));
    let (ours, spins) = (both.map(|(a, b)| a && b), all.map(|all| all.errors == 0));
    tally.note("stuck and exclude", "", ours, spins);
    if let Some(all) = all.filter(|all| all.errors == 0) {
        // Before its first step, the model has its processes to start.
        let same = all.states == explored.states as u64 + 1;
        let what = format!("{} and {}", explored.states, all.states);
        tally.note(STATES, what, Some(true), Some(same));
    }
    if claims == 0 {
        return Some(Compared { tally, states: explored.states });
    }
    tally.note("start", "", holds(Property::Start), spin.claim("start"));
    let never: Option<Vec<&str>> = match verdict(Property::Reach) {
        Verdict::Violated(found) => Some(found.iter().map(|found| found.what.as_str()).collect()),
        Verdict::Holds => Some(Vec::new()),
        Verdict::Undecided(_) => None,
    };
    let component = system.plan().component();
    let own = component.codels.iter().filter(|codel| match codel.owner {
        Owner::Service(service) => !component.services[service].standard,
        Owner::Task(_) => true,
    });
    let codels = own
        .map(|codel| (format!("never_{}", codel.name), format!("codel {} never runs", codel.name)));
    let services = component
        .services
        .pairs()
        .filter(|(ix, _)| system.plan().services()[*ix].builtin.is_none());
    let services = services.map(|(_, service)| {
        let name = &service.name;
        (format!("never_ok_{name}"), format!("no request of {name} is ever accepted"))
    });
    for (claim, finding) in codels.chain(services).take(claims) {
        let ours = never.as_ref().map(|never| !never.contains(&finding.as_str()));
        // The claim says that it never is.
        tally.note("reach", &claim, ours, spin.claim(&claim));
    }
    Some(Compared { tally, states: explored.states })
}
