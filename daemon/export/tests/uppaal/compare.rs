//! What a structured model says of a component, and what we find.

use genom_export::{Format, export};
use genom_formal::{Limits, Phase, Property, State, System, Verdict};

use super::explore::{Explorer, Found};
use super::file::Model;
use super::graph::{Graph, reached};

/// However slow the machine is.
pub(crate) fn limits(states: usize) -> Limits {
    Limits { states, time: std::time::Duration::MAX, ..Limits::default() }
}

/// The model of a component, without times.
pub(crate) fn written(system: &System) -> String {
    export(system, Format::Uppaal, None, &limits(0)).unwrap()
}

/// What is found of a model of a component, of which the phase is seen, and what each context executes.
pub(crate) fn found(system: &System, text: &str, most: usize) -> Option<Found> {
    let mut model = Model::new(text);
    let held = (0..contexts(system)).map(|context| format!("held[{context}]"));
    let seen: Vec<String> = held.chain(["phase".to_owned()]).collect();
    let seen = seen.iter().map(|text| model.expression(text)).collect();
    Explorer::new(&model).seeing(seen).explore(most)
}

fn contexts(system: &System) -> u16 {
    u16::try_from(system.periods().len() + system.services().len()).unwrap()
}

/// The states of a component, by the rules as they are programmed, with the same that is seen.
fn ours(system: &System, most: usize) -> Option<Graph> {
    let mut told = Vec::new();
    reached(system.initial(false), most, |state: &State, next| {
        for action in system.enabled(state) {
            next.push(system.after(state, action, &mut told));
            told.clear();
        }
        let held = |context| state.lock.held_by(context).map_or(0, |node| i32::from(node) + 1);
        let phase = match state.phase {
            Phase::Starting(_) => 0,
            Phase::Running => 1,
            Phase::Stopping(_) => 2,
            Phase::Stopped => 3,
        };
        (0..contexts(system)).map(held).chain([phase]).collect()
    })
}

/// How much was compared of a component, and is the same.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Compared {
    pub(crate) states: usize,
    pub(crate) steps: usize,
    pub(crate) verdicts: usize,
}

/// Compares states, steps and verdicts of a component, if it has not more states than that.
///
/// # Panics
/// If they differ.
pub(crate) fn compare(system: &System, most: usize) -> Option<Compared> {
    let wanted = [Property::Start, Property::Stuck, Property::Reach, Property::Exclude];
    let report = system.check(&wanted, &limits(most));
    let explored = report.explored.unwrap();
    if explored.limit.is_some() {
        return None;
    }
    let found = found(system, &written(system), most).expect("it has not more states than ours");
    let shape = found.graph.shape();
    assert_eq!(shape, ours(system, most).unwrap().shape());
    assert_eq!(shape.0, explored.states);
    let mut never = Vec::new();
    let mut verdicts = 0;
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
            verdicts += 1;
        }
    }
    for (comment, reached) in &found.verdicts {
        let Some(what) = comment.strip_prefix("reach: ") else { continue };
        let ours = match what.strip_suffix(" can run") {
            Some(codel) => format!("{codel} never runs"),
            None => {
                what.replace("a request", "no request").replace("can succeed", "is ever accepted")
            }
        };
        assert_eq!(*reached, !never.contains(&ours), "{ours}");
        verdicts += 1;
    }
    Some(Compared { states: shape.0, steps: shape.1, verdicts })
}
