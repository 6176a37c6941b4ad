//! `genomd --check`: performs all steps of loading a component up to its start.
//!
//! The library is opened, which runs its constructors, but no codels are called.

use std::io::Write as _;
use std::process::Stdio;

use genom_configuration::LoadRequest;
use genom_supervisor::loading::{self, check_reactions};

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
        let script = loading::names_script(request, &settings.supervisor.path);
        if let Some(language) = script.filter(|_| !genom_host::interpreter::is_there()) {
            return refused_by_runner(&settings, request, language);
        }
        match loading::fit(&settings.supervisor, request) {
            Ok(line) => {
                // A closed pipe is not a failure.
                let _ = writeln!(std::io::stdout().lock(), "{line}");
                None
            }
            Err(error) => Some(error.to_string()),
        }
    });
    let mut refused: Vec<String> = refused.collect();
    let reactions = check_reactions(&settings.supervisor, &settings.deployment, |_| false);
    if let Err((place, error)) = reactions {
        refused.push(told(&settings, &place, &error));
    }
    if refused.is_empty() { Ok(()) } else { Err(Refusal::component(refused.join("\n"))) }
}

/// Has the runner of its codels check a component, in a process that prints the result; returns why it
/// is refused.
fn refused_by_runner(settings: &Settings, request: &LoadRequest, language: &str) -> Option<String> {
    let Some((words, key)) = settings.config.runner(language) else {
        let library = request.library.display();
        return Some(format!("{library}: nothing runs codels in {language} (runners.{language})"));
    };
    let mut command = genom_cells::in_runner(&words);
    let longest = settings.supervisor.start_timeout.as_secs();
    command.arg("--check").arg("--set").arg(format!("start_timeout={longest}"));
    if let Some(runner) = settings.config.runner_setting(language) {
        // Otherwise the process would not know which files are of that language.
        command.arg("--set").arg(runner);
    }
    for (option, directories) in
        [("--path", &settings.supervisor.path), ("--include", &settings.supervisor.include)]
    {
        directories.iter().for_each(|directory| _ = command.arg(option).arg(directory));
    }
    if let Some(description) = &request.gen_file {
        command.arg("--gen").arg(description);
    }
    let library = request.library.display();
    match command.arg(&request.library).stderr(Stdio::piped()).output() {
        Ok(done) => {
            let _ = std::io::stdout().lock().write_all(&done.stdout);
            let said = String::from_utf8_lossy(&done.stderr);
            let said = said.trim_end();
            let said = said.strip_prefix("error: ").unwrap_or(said);
            if done.status.success() {
                return None;
            }
            let lacks = genom_cells::lacks_package(&words);
            Some(lacks.map_or_else(|| said.to_owned(), |why| format!("{library}: {why}")))
        }
        Err(error) => Some(format!(
            "{library}: its codels are in {language}, and `{}` does not run: {error}; {key} names \
             the interpreter",
            command.get_program().display()
        )),
    }
}
