//! Compares what Spin finds of a model with what we find.

use genom_description::model::Owner;
use genom_formal::{Limits, Property, System, Verdict};

use super::run::Checked;

/// Verdicts that were compared.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Compared {
    pub(crate) verdicts: usize,
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
    let holds = |property: Property| *verdict(property) == Verdict::Holds;
    let spin = Checked::new(system, None);
    let all = spin.all();
    let mut compared = Compared { verdicts: 2, states: explored.states };
    let fine = holds(Property::Stuck) && holds(Property::Exclude);
    assert_eq!(all.errors == 0, fine, "{all:?} {:?}", verdict(Property::Stuck));
    if all.errors == 0 {
        // Before its first step, the model has its processes to start.
        assert_eq!(all.states, explored.states as u64 + 1, "states");
    }
    if claims == 0 {
        return Some(compared);
    }
    assert_eq!(spin.claim("start"), holds(Property::Start), "start");
    compared.verdicts += 1;
    let never: Vec<&str> = match verdict(Property::Reach) {
        Verdict::Violated(found) => found.iter().map(|found| found.what.as_str()).collect(),
        _ => Vec::new(),
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
        assert_eq!(!spin.claim(&claim), never.contains(&finding.as_str()), "{claim}");
        compared.verdicts += 1;
    }
    Some(compared)
}
