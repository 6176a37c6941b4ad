//! What a component is made of, for those who look at its description elsewhere.

use std::path::PathBuf;
use std::time::Duration;

use genom_configuration::LoadRequest;
use genom_description::model::Task;
use genom_description::source::decode;
use genom_protocol::{ClockKind, ExecutionKind, SourceText, Sources, TaskEntry, TaskSettings};
use genom_runtime::nanos;

use super::hosted::Hosted;
use crate::settings::Settings;
use genom_finder::Reading;

impl Hosted {
    /// What it was made of. Its texts are those that were read when it was loaded, whatever their
    /// files hold by now.
    pub fn sources(&self, settings: &Settings) -> Sources {
        let build = self.build();
        Sources { name: self.name.clone(), ..sources(&build.reading, &build.request, settings) }
    }
}

/// What the component of a request is made of.
pub(crate) fn sources(reading: &Reading, request: &LoadRequest, settings: &Settings) -> Sources {
    let model = reading.model();
    let text = |(path, bytes): (PathBuf, Vec<u8>)| SourceText {
        path: path.to_string_lossy().into_owned(),
        text: decode(bytes).0.to_string(),
    };
    let none = TaskEntry::default();
    let task = |task: &Task| settings_of(task, request.tasks.get(&task.name).unwrap_or(&none));
    Sources {
        name: request.instance(),
        component: model.name.clone(),
        digest: model.digest.clone(),
        description: reading.path().to_string_lossy().into_owned(),
        texts: reading.texts().all().map(text).collect(),
        include: reading.include().iter().map(|dir| dir.display().to_string()).collect(),
        tasks: model.tasks.iter().map(task).collect(),
        max_activities: settings.max_activities,
        execution: match settings.clock {
            // It makes no difference there.
            ClockKind::Virtual | ClockKind::Ros => ExecutionKind::Threads,
            ClockKind::Monotonic => settings.execution,
        },
        clock: settings.clock,
    }
}

/// A task with the overrides of the configuration, which were checked when it was loaded.
fn settings_of(task: &Task, entry: &TaskEntry) -> TaskSettings {
    let given = entry.period_ms.and_then(|ms| Duration::try_from_secs_f64(ms / 1e3).ok());
    TaskSettings {
        name: task.name.clone(),
        // An aperiodic task stays one.
        period_ns: task.period.map(|own| nanos(given.unwrap_or(own))),
        priority: entry.priority.map(u32::from).or(task.priority).unwrap_or(255).min(255),
        real_time: entry.real_time.unwrap_or(task.real_time),
        cpus: entry.cpus.clone(),
    }
}
