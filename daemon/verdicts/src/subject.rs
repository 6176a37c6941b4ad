//! A component that is asked about: one that files describe; or one that runs, whose description is
//! read again from the texts that the daemon has, with the periods, priorities and limits of its
//! configuration.

use std::path::{Path, PathBuf};
use std::rc::Rc;
use std::sync::Arc;
use std::time::Duration;

use genom_description::model::Component;
use genom_description::source::{Memory, SourceMap, tidy};
use genom_description::{Options, preprocess, read_files};
use genom_drawing::units::duration;
use genom_formal::Bounds;
use genom_protocol::{ExecutionKind, Sources, Statistics, TaskSettings};
use genom_runtime::Plan;

/// Why the texts of the daemon do not give the component that it runs.
#[derive(Debug, thiserror::Error)]
pub enum Unread {
    /// They have errors here.
    #[error("{name}: the description that genomd runs cannot be read here: is it another version?")]
    Errors {
        /// Of the component, in the daemon.
        name: String,
    },
    /// They give another description.
    #[error(
        "{name}: its description has digest {theirs} in genomd and {ours} here: use the genomctl \
         of its version"
    )]
    Other {
        /// Of the component, in the daemon.
        name: String,
        /// The digest in genomd.
        theirs: String,
        /// The digest here.
        ours: String,
    },
    /// The runtime cannot execute it.
    #[error("{name}: {why}")]
    Plan {
        /// Of the component, in the daemon.
        name: String,
        /// The runtime's reason.
        why: String,
    },
}

/// A component that is asked about.
#[derive(Clone, Debug)]
pub struct Subject {
    /// What the runtime executes.
    pub plan: Arc<Plan>,
    /// The texts that it was read from.
    pub texts: Rc<SourceMap>,
    /// The files of its description.
    pub files: Vec<PathBuf>,
    /// Directories of included files.
    pub include: Vec<PathBuf>,
    /// Definitions for the preprocessor.
    pub defines: Vec<String>,
    /// How it is executed, if it runs or is configured.
    pub running: Option<Sources>,
    /// What was measured of it.
    pub measured: Option<Statistics>,
}

impl Subject {
    /// One that runs: reads the texts again, and applies the configuration.
    ///
    /// # Errors
    /// The texts do not give the component that runs.
    pub fn of_running(sources: Sources) -> Result<Self, Unread> {
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
        Ok(Self {
            plan: Arc::new(plan),
            texts,
            files: vec![PathBuf::from(&sources.description)],
            include: sources.include.iter().map(PathBuf::from).collect(),
            defines: Vec::new(),
            running: Some(sources),
            measured: None,
        })
    }

    /// Its instance name, or that of the component.
    #[must_use]
    pub fn name(&self) -> &str {
        let own = &self.plan.component().name;
        self.running.as_ref().map_or(own, |running| &running.name)
    }

    /// A line about how it is executed, if that is known.
    #[must_use]
    pub fn heading(&self) -> String {
        self.running.as_ref().map_or_else(String::new, heading)
    }

    /// What clients may do of it: that many requests at the same time, that many activities of one
    /// service.
    #[must_use]
    pub fn bounds(&self, requests: usize, instances: usize) -> Bounds {
        let mut bounds = Bounds { requests, instances, ..Bounds::default() };
        if let Some(running) = &self.running {
            bounds.slots = running.max_activities;
        }
        bounds
    }

    /// Its name in the daemon, if it is on a stepped clock, on which codels take no time.
    #[must_use]
    pub fn on_stepped_clock(&self) -> Option<&str> {
        let running = self.running.as_ref().filter(|one| one.clock.is_stepped())?;
        Some(&running.name)
    }

    /// Why bounds that give each thread a processor do not hold for it.
    #[must_use]
    pub fn shares_its_thread(&self) -> Option<String> {
        let single = |running: &&Sources| running.execution == ExecutionKind::Single;
        let running = self.running.as_ref().filter(single)?;
        Some(format!("{} shares one thread with other components (execution)", running.name))
    }
}

/// Applies what is configured for the tasks.
fn configure(model: &mut Component, settings: &[TaskSettings]) {
    for (task, settings) in (&mut model.tasks).into_iter().zip(settings) {
        task.period = settings.period_ns.map(Duration::from_nanos);
        task.priority = Some(settings.priority);
        task.real_time = settings.real_time;
    }
}

/// How it is executed, in a line for each task.
fn heading(running: &Sources) -> String {
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
