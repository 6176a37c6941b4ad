//! The components that are asked about, as plans: those that files describe, or one that runs.

use std::path::{Path, PathBuf};
use std::rc::Rc;
use std::sync::Arc;

use genom_protocol::{Sources, routes};
use genom_runtime::Plan;
use genom_verdicts::{Subject, Unread};

use crate::failure::Failure;
use crate::reading::Reading;
use crate::session::Session;

/// Files with descriptions, and which of their components are meant; or a component that runs.
#[derive(Debug, clap::Args)]
pub(in crate::verbs) struct Described {
    /// The .gen files, read in order as one specification; or the name of a component that runs,
    /// which is looked at with its configuration.
    #[arg(value_name = "FILE|COMPONENT")]
    files: Vec<PathBuf>,
    /// One component of the files [default: all].
    #[arg(long, value_name = "NAME")]
    component: Option<String>,
    #[command(flatten)]
    reading: Reading,
}

impl Described {
    /// What was named, for a verb that takes other files as well.
    pub(in crate::verbs) fn named(&self) -> &[PathBuf] {
        &self.files
    }

    /// The name of the component that runs, if one is meant: a file is named by a path, by `.gen`,
    /// or is there.
    fn running(&self) -> Option<&str> {
        let [one] = &self.files[..] else { return None };
        is_name(one).then(|| one.to_str()).flatten()
    }

    /// Reads the files, which must have no errors, or asks the daemon; `measured` times are asked
    /// for as well.
    pub(in crate::verbs) async fn subjects(
        &self,
        measured: bool,
        session: &Session,
    ) -> Result<Vec<Subject>, Failure> {
        if self.files.is_empty() {
            return Err(Failure::usage(
                "nothing is named",
                "name a .gen file, or a component that runs",
            ));
        }
        let Some(name) = self.running() else {
            if measured {
                return Err(Failure::usage(
                    "nothing was measured of a file",
                    "name a component that runs",
                ));
            }
            return self.read();
        };
        let reading = &self.reading;
        if self.component.is_some() || !reading.include.is_empty() || !reading.defines.is_empty() {
            return Err(Failure::usage(
                format!("{name} runs: it has been read already"),
                "--component, -I and -D go with files",
            ));
        }
        Ok(vec![ask(name, measured, session).await?])
    }

    fn read(&self) -> Result<Vec<Subject>, Failure> {
        let analysis = self.reading.read_sound(&self.files)?;
        let specification = Arc::new(analysis.specification);
        let names = specification.components.iter().map(|component| component.name.as_str());
        let wanted = |name: &str| self.component.as_deref().is_none_or(|wanted| wanted == name);
        let places: Vec<usize> =
            names.clone().enumerate().filter(|(_, name)| wanted(name)).map(|(at, _)| at).collect();
        if places.is_empty() {
            let known: Vec<_> = names.map(|name| format!("`{name}`")).collect();
            let message = self.component.as_ref().map_or_else(
                || "these files describe no component".to_owned(),
                |name| format!("there is no component `{name}`"),
            );
            return Err(Failure::usage(message, format!("they describe: {}", known.join(", "))));
        }
        let texts = Rc::new(analysis.sources);
        let subject = |place: usize| match Plan::new(&specification, place) {
            Ok(plan) => Ok(Subject {
                plan: Arc::new(plan),
                texts: Rc::clone(&texts),
                files: self.files.clone(),
                include: self.reading.include.clone(),
                defines: self.reading.defines.clone(),
                running: None,
                measured: None,
            }),
            Err(error) => Err(Failure::refused("plan", error.to_string())),
        };
        places.into_iter().map(subject).collect()
    }
}

/// Whether this is the name of a component, and no file.
fn is_name(argument: &Path) -> bool {
    let text = argument.to_string_lossy();
    let named = text.chars().all(|letter| letter.is_alphanumeric() || "_-".contains(letter));
    named && !argument.exists()
}

/// A component that runs.
pub(in crate::verbs) async fn ask(
    name: &str,
    measured: bool,
    session: &Session,
) -> Result<Subject, Failure> {
    // As sent: the texts have control characters, which replies are shown without.
    let sent = session.client.request(&routes::sources(name), Vec::new()).await?;
    let sources: Sources =
        serde_json::from_value(sent).map_err(|why| session.client.misread(why.to_string()))?;
    let mut subject = Subject::of_running(sources).map_err(refused)?;
    if measured {
        check_clock(&subject)?;
        subject.measured = Some(session.ask(routes::statistics(name)).await?.content);
    }
    Ok(subject)
}

pub(in crate::verbs) fn refused(why: Unread) -> Failure {
    Failure::refused("sources", why.to_string())
}

/// Durations on a stepped clock are those of the clock: nothing is measured.
fn check_clock(subject: &Subject) -> Result<(), Failure> {
    subject.on_stepped_clock().map_or(Ok(()), |name| {
        Err(Failure::usage(
            format!("{name} is on a stepped clock, on which codels take no time"),
            "measure it in a daemon with the machine's clock",
        ))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_is_named_by_a_path_by_its_ending_or_is_there() {
        let made = tempfile::tempdir().unwrap();
        std::fs::write(made.path().join("demo"), "").unwrap();
        for (argument, name) in [
            ("demo", true),
            ("arm_2", true),
            ("demo.gen", false),
            ("./demo", false),
            ("models/demo", false),
        ] {
            assert_eq!(is_name(Path::new(argument)), name, "{argument}");
        }
        assert!(!is_name(&made.path().join("demo")));
    }
}
