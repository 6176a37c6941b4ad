//! A run of a component without its library: `play = [...]`.

use std::collections::BTreeMap;
use std::path::Path;

use genom_protocol::TaskEntry;
use genom_stage::{Move, Script, Step};

use super::fields::{Fields, Spot, typed};
use super::setup::absolute;
use crate::model::Run;
use crate::source::Place;

/// The keys that say what happens in a step.
const MOVES: [&str; 7] = ["pass", "returns", "request", "abort", "fire", "control", "late"];

/// Reads the keys of such a scenario; `None` if it has mistakes, which are told.
pub(super) fn read(fields: &Fields<'_, '_, '_>, text: &str, directory: &Path) -> Option<Run> {
    let paths = |key: &'static str| {
        fields.texts(key).into_iter().map(|path| absolute(directory, path.as_ref())).collect()
    };
    let description: Vec<_> = paths("description");
    if description.is_empty() {
        fields.missing("description", "name the files: description = [\"demo.gen\"]");
    }
    let tasks = fields.get("tasks");
    let tasks = tasks
        .and_then(|tasks| typed::<BTreeMap<String, TaskEntry>>(tasks, "`tasks`", fields.found));
    let most = fields.count("max_activities", 1);
    let mut before = 0;
    let steps = fields.list("play").map(|value| step(value, &mut before, fields));
    // All mistakes are told.
    let steps: Vec<Option<(Step, usize)>> = steps.collect();
    let steps: Option<Vec<(Step, usize)>> = steps.into_iter().collect();
    let (steps, starts): (Vec<Step>, Vec<usize>) = steps?.into_iter().unzip();
    Some(Run {
        description,
        include: paths("include"),
        define: fields.texts("define").into_iter().map(str::to_owned).collect(),
        component: fields.text("component").map(str::to_owned),
        tasks: tasks.unwrap_or_default(),
        max_activities: most.map(|most| usize::try_from(most).unwrap_or(usize::MAX)),
        script: Script { steps },
        places: starts.into_iter().map(|start| Place::of(text, start)).collect(),
    })
}

fn step(value: Spot<'_, '_>, before: &mut u64, all: &Fields<'_, '_, '_>) -> Option<(Step, usize)> {
    let fields = Fields::of(value, "a step", all.found)?;
    let at = fields.time("at");
    if !fields.has("at") {
        fields.missing("at", "say when: at = \"10ms\"");
    }
    let late = at.is_some_and(|at| at < *before);
    if late {
        let message = "it is before the step before".to_owned();
        all.found.add(value.span(), message, Some("steps are in the order of dates".to_owned()));
    }
    *before = (*before).max(at.unwrap_or(0));
    fields.offer(MOVES.iter());
    let named: Vec<&str> = MOVES.iter().copied().filter(|key| fields.has(key)).collect();
    let what = match named[..] {
        ["pass"] => fields.text("pass").map(|task| Move::Pass(task.to_owned())),
        ["returns"] => returns(&fields),
        ["request"] => fields.text("request").map(|name| Move::Request(name.to_owned())),
        ["abort"] => {
            let number = fields.count("abort", 1).and_then(|number| u32::try_from(number).ok());
            number.map(Move::Abort)
        }
        ["fire"] => fields.text("fire").map(|event| Move::Fire(event.to_owned())),
        ["control"] => fields.text("control").map(|_| Move::Control),
        ["late"] => fields.text("late").map(|task| Move::Late(task.to_owned())),
        _ => {
            let message = "a step has one of the keys that say what happens".to_owned();
            all.found.add(value.span(), message, Some(MOVES.join(", ")));
            None
        }
    };
    fields.finish("a step of a run");
    let step = Step { at: at?, what: what? };
    (!late).then_some((step, value.span().start))
}

fn returns(fields: &Fields<'_, '_, '_>) -> Option<Move> {
    let codel = fields.text("returns")?.to_owned();
    let task = fields.text("task").map(str::to_owned);
    if !fields.has("yields") {
        fields.missing("yields", "say what it returns: yields = \"pause::main\"");
    }
    let yields = fields.text("yields")?.to_owned();
    Some(Move::Returns { codel, task, yields })
}
