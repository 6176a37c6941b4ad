//! Formulas of users: checked here if they are of one of the forms that are built in, and by Spin
//! otherwise.

use std::io::{self, Read as _};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::thread;
use std::time::{Duration, Instant};

use genom_formal::{Formula, Limits, System, Times, Verdict};

use crate::failure::Failure;

/// The formulas that texts say about a component.
pub(in crate::verbs) fn read(texts: &[String], system: &System) -> Result<Vec<Formula>, Failure> {
    let one = |text: &String| {
        Formula::new(system, text).map_err(|error| {
            Failure::usage(format!("--ltl: {error}"), "docs/verify.md has the operators")
        })
    };
    texts.iter().map(one).collect()
}

/// Whether each formula holds.
pub(super) fn check(
    formulas: Vec<Formula>,
    system: &System,
    times: Option<&Times>,
    limits: &Limits,
) -> Result<Vec<(Formula, Verdict)>, Failure> {
    let one = |formula: Formula| {
        let own = system.check_past(&formula, limits);
        let own = own.or_else(|| system.check_comes(&formula, limits));
        let verdict = match own {
            Some(verdict) => verdict,
            None => spin(&formula, system, times, limits)?,
        };
        Ok((formula, verdict))
    };
    formulas.into_iter().map(one).collect()
}

/// What Spin says.
fn spin(
    formula: &Formula,
    system: &System,
    times: Option<&Times>,
    limits: &Limits,
) -> Result<Verdict, Failure> {
    // Without need, clocks make the model larger.
    let times = times.filter(|_| formula.has_late());
    let model = genom_export::export_claim(system, formula, times)
        .map_err(|error| Failure::refused("formula", error.to_string()))?;
    let (Some(spin), Some(cc)) = (found("spin"), found("cc")) else {
        let why = "Spin checks this formula, and it takes `spin` and `cc` on the PATH (Debian: spin, gcc)";
        return Ok(Verdict::Undecided(why.into()));
    };
    let folder =
        tempfile::tempdir().map_err(|error| Failure::refused("spin", error.to_string()))?;
    let path = folder.path().join("model.pml");
    let fair = format!("-DNFAIR={}", genom_export::fairness(&model));
    std::fs::write(&path, model).map_err(|error| Failure::file(&path, error))?;
    let deadline = Instant::now().checked_add(limits.time);
    let run = |program: &Path, arguments: &[&str]| run(program, arguments, folder.path(), deadline);
    let timed: &[&str] = if times.is_some() { &["-DTIME"] } else { &[] };
    let memory = format!("-DMEMLIM={}", (limits.memory >> 20).max(1));
    let compile = ["-O1", "-w", &fair, "-DVECTORSZ=4096", &memory, "-o", "pan", "pan.c"];
    let search = ["-a", "-f", "-m2000000", "-N", "user"];
    let pan = folder.path().join("pan");
    let mut text = String::new();
    for (program, arguments) in [
        (spin.as_path(), [timed, &["-a", "model.pml"]].concat()),
        (cc.as_path(), compile.to_vec()),
        (pan.as_path(), search.to_vec()),
    ] {
        match run(program, &arguments)? {
            Some(output) => text = output,
            None => {
                let why = format!("more than {} s", limits.time.as_secs_f64());
                return Ok(Verdict::Undecided(why));
            }
        }
    }
    Ok(verdict(formula, &text))
}

/// What the output of the search means.
fn verdict(formula: &Formula, text: &str) -> Verdict {
    let errors = text.split("errors:").nth(1).and_then(|rest| rest.split_whitespace().next());
    let cut = ["search depth too small", "out of memory", "Search not completed"];
    match errors {
        Some("0") if !cut.iter().any(|cut| text.contains(cut)) => Verdict::Holds,
        Some(errors) if errors != "0" => {
            let what = format!(
                "Spin has a run in which `{formula}` does not hold; `genomctl model --format promela \
                 --ltl` writes what it checks"
            );
            Verdict::Violated(vec![genom_formal::Finding { what, span: None, run: Vec::new() }])
        }
        _ => Verdict::Undecided("Spin did not see all states: raise the limits".into()),
    }
}

/// The output of a program; `None` if it took too long.
fn run(
    program: &Path,
    arguments: &[&str],
    folder: &Path,
    deadline: Option<Instant>,
) -> Result<Option<String>, Failure> {
    let failed = |why: String| Failure::refused("spin", format!("{}: {why}", program.display()));
    let broken = |error: io::Error| failed(error.to_string());
    let (mut output, ours) = io::pipe().map_err(broken)?;
    let mut command = Command::new(program);
    command.args(arguments).current_dir(folder).stdin(Stdio::null());
    command.stdout(ours.try_clone().map_err(broken)?).stderr(ours);
    let mut child = command.spawn().map_err(broken)?;
    // With our ends of the pipe: then its end is the end of the program.
    drop(command);
    let (ended, end) = channel();
    thread::spawn(move || {
        let mut text = Vec::new();
        let read = output.read_to_end(&mut text).map(|_| text);
        // Nobody waits any more if it took too long.
        let _ = ended.send(read);
    });
    let left = deadline.map_or(Duration::MAX, |at| at.saturating_duration_since(Instant::now()));
    let text = match end.recv_timeout(left) {
        Ok(text) => text.map_err(broken)?,
        Err(RecvTimeoutError::Timeout) => {
            child.kill().and_then(|()| child.wait()).map_err(broken)?;
            return Ok(None);
        }
        Err(RecvTimeoutError::Disconnected) => return Err(failed("its output is lost".into())),
    };
    let status = child.wait().map_err(broken)?;
    let text = String::from_utf8_lossy(&text).into_owned();
    if status.success() || text.contains("errors:") {
        return Ok(Some(text));
    }
    Err(failed(format!("{status}\n{text}")))
}

/// A program on the PATH.
fn found(program: &str) -> Option<PathBuf> {
    let path = std::env::var_os("PATH")?;
    std::env::split_paths(&path).map(|folder| folder.join(program)).find(|path| path.is_file())
}
