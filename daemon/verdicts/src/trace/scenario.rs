//! Runs as scenarios: their codels take and yield what the run says, so no library is needed.

use std::path::{Path, PathBuf};

use genom_drawing::units::duration;
use genom_formal::{Event, Happening};
use genom_scenario::duration::short;
use toml::Value;

use super::Traced;

/// The text of a file of scenarios, one for each run.
#[must_use]
pub fn text(file: &Path, runs: &[Traced<'_>]) -> String {
    let directory = std::path::absolute(file).ok();
    let directory = directory.as_deref().and_then(Path::parent).unwrap_or(Path::new(""));
    let mut text = String::from(
        "# Found by `genomctl verify`. `genomctl test` plays it without libraries: codels take the \
         time\n# that stands here, and yield what stands here.\n",
    );
    for run in runs {
        text.push_str(&one(directory, run));
    }
    text
}

fn one(directory: &Path, run: &Traced<'_>) -> String {
    let (subject, task) = (&run.told.subject, &run.task.name);
    let name = subject.name();
    let at = duration(run.end());
    let mut text = format!(
        "\n[[scenario]]\nname = {}\n",
        quoted(&format!("{name}: {task} is at work at its tick at {at}"))
    );
    let texts = |paths: &[PathBuf]| {
        let all = paths.iter().map(|path| quoted(&relative(directory, path)));
        format!("[{}]", all.collect::<Vec<_>>().join(", "))
    };
    text.push_str(&format!("description = {}\n", texts(&subject.files)));
    if !subject.include.is_empty() {
        text.push_str(&format!("include = {}\n", texts(&subject.include)));
    }
    if !subject.defines.is_empty() {
        let all: Vec<String> = subject.defines.iter().map(|one| quoted(one)).collect();
        text.push_str(&format!("define = [{}]\n", all.join(", ")));
    }
    text.push_str(&format!("component = {}\n", quoted(&subject.plan.component().name)));
    if let Some(running) = &subject.running {
        text.push_str(&format!("max_activities = {}\n", running.max_activities));
        let periods = running.tasks.iter().filter_map(|task| {
            #[allow(clippy::cast_precision_loss, reason = "exact below 104 days")]
            let ms = task.period_ns? as f64 / 1e6;
            Some(format!("{} = {{ period_ms = {ms:?} }}", task.name))
        });
        let periods: Vec<String> = periods.collect();
        if !periods.is_empty() {
            text.push_str(&format!("tasks = {{ {} }}\n", periods.join(", ")));
        }
    }
    text.push_str("play = [\n");
    for line in run.happenings.iter().filter_map(step) {
        text.push_str(&format!("  {line},\n"));
    }
    text.push_str("]\n");
    text
}

/// A step of the run, if it is one of the script.
fn step(happening: &Happening) -> Option<String> {
    let what = match &happening.event {
        Event::Pass(task) => format!("pass = {}", quoted(task)),
        Event::Returns(call, yields) => {
            let task = call.task.as_ref().map(|task| format!(", task = {}", quoted(task)));
            let (codel, task) = (quoted(&call.codel), task.unwrap_or_default());
            format!("returns = {codel}{task}, yields = {}", quoted(yields))
        }
        Event::Request(service) => format!("request = {}", quoted(service)),
        Event::Abort(activity) => format!("abort = {activity}"),
        Event::Fire(event) => format!("fire = {}", quoted(event)),
        Event::Control => "control = \"collects\"".to_owned(),
        Event::Late(task) => format!("late = {}", quoted(task)),
        _ => return None,
    };
    Some(format!("{{ at = \"{}\", {what} }}", short(happening.date)))
}

/// As a text of TOML.
fn quoted(text: &str) -> String {
    Value::from(text).to_string()
}

/// A path as it is written in a file of this directory: relative if it is in or below it.
fn relative(directory: &Path, path: &Path) -> String {
    let whole = std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
    let short = whole.strip_prefix(directory).unwrap_or(&whole);
    short.to_string_lossy().into_owned()
}
