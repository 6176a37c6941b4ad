//! A component that runs: its description, read again from the texts that the daemon has, with the
//! periods, priorities and limits of its configuration.

use std::path::{Path, PathBuf};
use std::rc::Rc;
use std::sync::Arc;
use std::time::Duration;

use genom_description::model::Component;
use genom_description::source::{Memory, tidy};
use genom_description::{Options, preprocess, read_files};
use genom_protocol::{ClockKind, ExecutionKind, Sources, TaskSettings};
use genom_runtime::Plan;

use super::described::Subject;
use crate::failure::Failure;
use crate::units::duration;

/// Why the texts of the daemon do not give the component that it runs.
#[derive(Debug, thiserror::Error)]
pub(in crate::verbs) enum Unread {
    #[error("{name}: the description that genomd runs cannot be read here: is it another version?")]
    Errors { name: String },
    #[error(
        "{name}: its description has digest {theirs} in genomd and {ours} here: use the genomctl \
         of its version"
    )]
    Other { name: String, theirs: String, ours: String },
    #[error("{name}: {why}")]
    Plan { name: String, why: String },
}

impl Unread {
    pub(super) fn failure(self) -> Failure {
        Failure::refused("sources", self.to_string())
    }
}

/// Reads the texts again, and applies the configuration.
pub(in crate::verbs) fn subject(sources: Sources) -> Result<Subject, Unread> {
    let name = || sources.name.clone();
    let mut files = Memory::new();
    for one in &sources.texts {
        let path = Path::new(&one.path);
        // Other spellings of a path lead there, too.
        files.insert(tidy(path), one.text.as_str());
        files.insert(path, one.text.as_str());
    }
    let include_dirs = sources.include.iter().map(PathBuf::from).collect();
    let preprocess = preprocess::Options { include_dirs, ..preprocess::Options::default() };
    let options = Options { preprocess, ..Options::default() };
    let analysis = read_files(&[PathBuf::from(&sources.description)], &options, &files);
    let mut specification = analysis.specification;
    let place = specification.components.iter().position(|one| one.name == sources.component);
    let Some(place) = place.filter(|_| analysis.diagnostics.errors() == 0) else {
        return Err(Unread::Errors { name: name() });
    };
    let model = &mut specification.components[place];
    if model.digest != sources.digest {
        let (theirs, ours) = (sources.digest.clone(), model.digest.clone());
        return Err(Unread::Other { name: name(), theirs, ours });
    }
    configure(model, &sources.tasks);
    let plan = Plan::new(&Arc::new(specification), place);
    let plan = plan.map_err(|error| Unread::Plan { name: name(), why: error.to_string() })?;
    let texts = Rc::new(analysis.sources);
    Ok(Subject {
        plan: Arc::new(plan),
        texts,
        files: vec![PathBuf::from(&sources.description)],
        include: sources.include.iter().map(PathBuf::from).collect(),
        defines: Vec::new(),
        running: Some(sources),
        measured: None,
    })
}

/// Applies what is configured for the tasks.
fn configure(model: &mut Component, settings: &[TaskSettings]) {
    for (task, settings) in (&mut model.tasks).into_iter().zip(settings) {
        task.period = settings.period_ns.map(Duration::from_nanos);
        task.priority = Some(settings.priority);
        task.real_time = settings.real_time;
    }
}

/// Durations on a stepped clock are those of the clock: nothing is measured.
pub(super) fn check_clock(subject: &Subject) -> Result<(), Failure> {
    match &subject.running {
        Some(running) if running.clock == ClockKind::Virtual => Err(Failure::usage(
            format!("{} is on a stepped clock, on which codels take no time", running.name),
            "measure it in a daemon with the machine's clock",
        )),
        _ => Ok(()),
    }
}

/// How it is executed, in a line for each task.
pub(super) fn heading(running: &Sources) -> String {
    let mut text = format!("{} as it runs:\n", running.name);
    for task in &running.tasks {
        let period = task.period_ns.map_or_else(|| "no period".to_owned(), duration);
        let (of, priority) = (if task.real_time { "real-time" } else { "any" }, task.priority);
        let cpus: Vec<String> = task.cpus.iter().map(usize::to_string).collect();
        let cpus = match cpus.is_empty() {
            true => "any processor".to_owned(),
            false => format!("processor {}", cpus.join(", ")),
        };
        text.push_str(&format!(
            "  task {}: {period}, {of} thread, priority {priority}, {cpus}\n",
            task.name
        ));
    }
    text
}

/// Why bounds that give each thread a processor do not hold for it.
pub(in crate::verbs) fn shares_its_thread(subject: &Subject) -> Option<String> {
    let single = |running: &&Sources| running.execution == ExecutionKind::Single;
    let running = subject.running.as_ref().filter(single)?;
    Some(format!("{} shares one thread with other components (execution)", running.name))
}
