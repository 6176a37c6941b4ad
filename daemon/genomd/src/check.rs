//! `genomd --check`: performs all steps of loading a component up to its start.
//!
//! The library is opened, which runs its constructors, but no codels are called.

use std::io::Write as _;

use genom_supervisor::loading::{self, LoadError, check_reactions};

use crate::run::{Refusal, told};
use crate::settings::Settings;

/// `--dump-sources`: no library is opened.
pub(crate) fn dump_sources(settings: Settings) -> Result<(), Refusal> {
    for request in &settings.deployment.component {
        let sources = loading::look(&settings.supervisor, request);
        let sources = sources.map_err(|error| Refusal::component(error.to_string()))?;
        // A closed pipe is not a failure.
        let _ = writeln!(std::io::stdout().lock(), "{}", serde_json::json!(sources));
    }
    Ok(())
}

/// Checks every component of the command line and configuration, and reports each that fails.
pub(crate) fn run(settings: Settings) -> Result<(), Refusal> {
    if settings.deployment.component.is_empty() {
        return Err(Refusal::usage("--check goes with the libraries to check"));
    }
    let refused = settings.deployment.component.iter().filter_map(|request| {
        match loading::fit(&settings.supervisor, request) {
            Ok(line) => {
                // A closed pipe is not a failure.
                let _ = writeln!(std::io::stdout().lock(), "{line}");
                None
            }
            Err(error) => Some(error),
        }
    });
    let mut refused: Vec<String> = refused.map(|error: LoadError| error.to_string()).collect();
    let reactions = check_reactions(&settings.supervisor, &settings.deployment, |_| false);
    if let Err((place, error)) = reactions {
        refused.push(told(&settings, &place, &error));
    }
    if refused.is_empty() { Ok(()) } else { Err(Refusal::component(refused.join("\n"))) }
}
