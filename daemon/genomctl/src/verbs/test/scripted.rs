//! Scenarios that need no library: a run is played on the runtime, in this process.

use std::sync::Arc;
use std::time::Duration;

use genom_description::{Options, preprocess, read};
use genom_protocol::TaskEntry;
use genom_runtime::{ACTIVITY_LIMIT, Plan, PlanError, TaskOptions};
use genom_scenario::{Outcome, Played, Run, Scenario};
use genom_stage::{Component, NotPlayed};

/// Plays a run; gives it up after this time of the machine.
pub(super) async fn play(scenario: &Scenario, run: &Run, limit: Duration) -> (Outcome, Played) {
    let component = match component(run) {
        Ok(component) => component,
        Err(error) => {
            return (Outcome::not_begun(scenario, &error.to_string()), Played::default());
        }
    };
    let script = run.script.clone();
    // It waits for threads, which nobody else does here.
    let playing = tokio::task::spawn_blocking(move || genom_stage::play(&component, &script));
    let failed = |why: String| Err((None, why));
    let played = match tokio::time::timeout(limit, playing).await {
        Ok(Ok(Ok(_))) => Ok(()),
        Ok(Ok(Err(error))) => Err((error.step(), told(&error))),
        Ok(Err(error)) => failed(error.to_string()),
        Err(_) => {
            failed(format!("it has not after {} s of the machine's time", limit.as_secs_f64()))
        }
    };
    let dates = |steps: usize| {
        let before = steps.checked_sub(1).and_then(|last| run.script.steps.get(last));
        Played { steps, nanoseconds: before.map_or(0, |step| step.at) }
    };
    match played {
        Ok(()) => (Outcome::Passed, dates(run.script.steps.len())),
        Err((step, why)) => {
            (Outcome::not_as_scripted(scenario, step, &why), dates(step.unwrap_or(0)))
        }
    }
}

/// The reason without the number of the step, which is told as a line.
fn told(error: &NotPlayed) -> String {
    match error {
        NotPlayed::Elsewhere { why, .. } => why.clone(),
        NotPlayed::NoSuch { what, .. } => format!("the component has no {what}"),
        other => other.to_string(),
    }
}

/// Why there is no component to play a run on.
#[derive(Debug, thiserror::Error)]
enum ComponentError {
    #[error("{0} has errors: see `genomctl check`")]
    Description(String),
    #[error("{0} do not describe that one component")]
    NotOne(String),
    #[error(transparent)]
    Plan(#[from] PlanError),
}

fn component(run: &Run) -> Result<Component, ComponentError> {
    let preprocess = preprocess::Options {
        include_dirs: run.include.clone(),
        defines: run.define.clone(),
        ..preprocess::Options::default()
    };
    let analysis = read(&run.description, &Options { preprocess, ..Options::default() });
    let files: Vec<String> =
        run.description.iter().map(|file| file.display().to_string()).collect();
    if analysis.has_errors() {
        return Err(ComponentError::Description(files.join(", ")));
    }
    let specification = Arc::new(analysis.specification);
    let mut all = specification.components.iter();
    let place = match &run.component {
        Some(name) => all.position(|component| component.name == *name),
        None => (specification.components.len() == 1).then_some(0),
    };
    let Some(place) = place else {
        return Err(ComponentError::NotOne(files.join(", ")));
    };
    let plan = Plan::new(&specification, place)?;
    let options = |(name, entry): (&String, &TaskEntry)| {
        let period = entry.period_ms.and_then(|ms| Duration::try_from_secs_f64(ms / 1e3).ok());
        (name.clone(), TaskOptions { period, ..TaskOptions::default() })
    };
    Ok(Component {
        plan: Arc::new(plan),
        tasks: run.tasks.iter().map(options).collect(),
        slots: run.max_activities.unwrap_or(ACTIVITY_LIMIT),
    })
}
