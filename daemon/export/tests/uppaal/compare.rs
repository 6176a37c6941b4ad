//! What a structured model says of a component, and what we find.

use genom_export::{Format, export};
use genom_formal::{Limits, Property, System, Verdict};

use super::explore::{Explorer, Found};
use super::file::Model;

/// However slow the machine is.
pub(crate) fn limits(states: usize) -> Limits {
    Limits { states, time: std::time::Duration::MAX, ..Limits::default() }
}

/// The model of a component, without times.
pub(crate) fn written(system: &System) -> String {
    export(system, Format::Uppaal, None, &limits(0)).unwrap()
}

/// What is found of a model.
pub(crate) fn found(text: &str, most: usize) -> Option<Found> {
    Explorer::new(&Model::new(text)).explore(most)
}

/// States and verdicts of a component, if it has not more states than that: how many states both have,
/// and how many verdicts are compared.
pub(crate) fn compare(system: &System, most: usize) -> Option<(usize, usize)> {
    let wanted = [Property::Start, Property::Stuck, Property::Reach, Property::Exclude];
    let report = system.check(&wanted, &limits(most));
    let explored = report.explored.unwrap();
    if explored.limit.is_some() {
        return None;
    }
    let found = found(&written(system), most).expect("it has not more states than ours");
    assert_eq!(found.states, explored.states);
    let mut never = Vec::new();
    let mut compared = 0;
    for (property, verdict) in &report.verdicts {
        let holds = match verdict {
            Verdict::Holds => true,
            Verdict::Violated(all) => {
                never.extend(all.iter().map(|one| one.what.clone()));
                false
            }
            Verdict::Undecided(why) => panic!("{property:?}: {why}"),
        };
        if *property != Property::Reach {
            let name = format!("{}:", property.name());
            assert_eq!(found.holds(&name), holds, "{name}");
            compared += 1;
        }
    }
    for (comment, reached) in &found.verdicts {
        let Some(what) = comment.strip_prefix("reach: ") else { continue };
        let ours = match what.strip_suffix(" can run") {
            Some(codel) => format!("{codel} never runs"),
            None => what.replace("a request", "no request").replace("can succeed", "is ever accepted"),
        };
        assert_eq!(*reached, !never.contains(&ours), "{ours}");
        compared += 1;
    }
    Some((found.states, compared))
}
