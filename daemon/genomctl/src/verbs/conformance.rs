//! `genomctl conformance`: whether the middleware in a library has the properties that every
//! middleware has to have. No daemon.
//!
//! Each property runs in a process of its own, this program once more: a library that crashes or
//! hangs fails that property alone, and whatever it keeps ends with it.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::Arc;

use genom_conformance::{PROPERTIES, World};
use genom_middleware::Middleware;
use genom_plugin_host::Library;
use serde::Serialize;
use serde_json::{Value, json};

use crate::failure::Failure;
use crate::session::Session;
use crate::table::Table;

/// Check that the middleware in a library has the properties that every middleware has to have:
/// docs/backend.md says how one is written.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// The library, such as ./libgenomd_mine.so.
    library: PathBuf,
    /// Options of the middleware, a JSON object: its section of the configuration. `{place}` in it
    /// becomes a new, empty directory for each property, which has to be empty at the end.
    #[arg(long, value_name = "JSON", default_value = "{}")]
    options: String,
    /// Only properties whose names contain this text.
    #[arg(long, value_name = "TEXT")]
    only: Option<String>,
    /// Runs one property in this process, in that place.
    #[arg(long, hide = true, num_args = 2, value_names = ["NAME", "PLACE"])]
    property: Option<Vec<String>>,
}

/// How one property fared.
#[derive(Serialize)]
struct Verdict {
    property: &'static str,
    holds: bool,
    /// What was said if it does not.
    #[serde(skip_serializing_if = "String::is_empty")]
    why: String,
}

#[derive(Serialize)]
struct Report {
    name: String,
    version: String,
    library: PathBuf,
    properties: Vec<Verdict>,
}

/// Participants of one library with the same options.
struct Here {
    library: &'static Library,
    options: String,
    place: PathBuf,
}

impl World for Here {
    #[allow(clippy::panic, reason = "a property that cannot be looked at does not hold")]
    fn join(&self) -> Arc<dyn Middleware> {
        match self.library.middleware(&self.options) {
            Ok(middleware) => middleware,
            Err(error) => panic!("it does not open: {error}"),
        }
    }

    fn leftovers(&self) -> Vec<String> {
        let files = std::fs::read_dir(&self.place).into_iter().flatten().flatten();
        files.map(|file| file.path().display().to_string()).collect()
    }
}

#[allow(clippy::needless_pass_by_value, reason = "for map_err")]
fn refused(error: impl ToString) -> Failure {
    Failure::refused("conformance", error.to_string())
}

pub(super) fn run(args: &Args, session: &Session) -> Result<(), Failure> {
    let library = Library::open(&args.library).map_err(refused)?;
    if let Some([name, place]) = args.property.as_deref() {
        return one(library, &args.options, name, Path::new(place));
    }
    match serde_json::from_str::<Value>(&args.options) {
        Ok(Value::Object(_)) => {}
        _ => return Err(refused(format!("--options {}: no JSON object", args.options))),
    }
    // Once here: what it does not take is told once, not for each property.
    let place = tempfile::tempdir()?;
    library.middleware(&placed(&args.options, place.path())).map_err(refused)?;
    let wanted = args.only.as_deref().unwrap_or_default();
    let asked: Vec<_> = PROPERTIES.iter().filter(|one| one.name.contains(wanted)).collect();
    if asked.is_empty() {
        return Err(refused(format!("no property has `{wanted}` in its name")));
    }
    let mut properties = Vec::new();
    for (number, property) in asked.iter().enumerate() {
        session.tell(&format!("{}/{} {}", number + 1, asked.len(), property.name))?;
        let why = tried(args, property.name)?;
        properties.push(Verdict { property: property.name, holds: why.is_empty(), why });
    }
    let (name, version) = (library.name().to_owned(), library.version().to_owned());
    let report = Report { name, version, library: library.path().to_owned(), properties };
    if session.json {
        session.print(&format!("{}\n", json!(report)))?;
    } else {
        session.print(&shown(&report, session))?;
    }
    let failed = report.properties.iter().filter(|one| !one.holds).count();
    match failed {
        0 => Ok(()),
        failed => Err(refused(format!("{failed} of {} properties do not hold", asked.len()))),
    }
}

fn placed(options: &str, place: &Path) -> String {
    options.replace("{place}", &place.display().to_string())
}

/// Runs a property in this process, and panics if it does not hold.
fn one(library: &'static Library, options: &str, name: &str, at: &Path) -> Result<(), Failure> {
    let property = PROPERTIES.iter().find(|one| one.name == name);
    let property = property.ok_or_else(|| refused(format!("no property `{name}`")))?;
    let world = Here { library, options: placed(options, at), place: at.to_owned() };
    genom_conformance::run(property.name, Arc::new(world), property.holds);
    Ok(())
}

/// Runs a property in a process of its own. Empty if it holds; else what was said.
fn tried(args: &Args, property: &str) -> Result<String, Failure> {
    let place = tempfile::tempdir()?;
    let ran = Command::new(std::env::current_exe()?)
        .arg("conformance")
        .arg(&args.library)
        .args(["--options", &args.options, "--property", property])
        .arg(place.path())
        .env("RUST_BACKTRACE", "0")
        .stdin(Stdio::null())
        .output()?;
    if ran.status.success() {
        return Ok(String::new());
    }
    let said = String::from_utf8_lossy(&ran.stderr);
    let said = said.lines().filter(|line| !line.starts_with("note: ")).collect::<Vec<_>>();
    Ok(format!("{}\n{}", ran.status, said.join("\n")).trim().to_owned())
}

fn shown(report: &Report, session: &Session) -> String {
    let mut text = format!("{} ({})\n", report.name, report.version);
    let verdict = |one: &Verdict| if one.holds { "holds" } else { "does not hold" };
    let rows = report.properties.iter();
    let rows = rows.map(|one| vec![one.property.to_owned(), verdict(one).to_owned()]).collect();
    let table = Table { header: vec!["PROPERTY", "VERDICT"], rows };
    text.push_str(&table.text(session.terminal));
    for one in report.properties.iter().filter(|one| !one.holds) {
        text.push_str(&format!("\n{}:\n", one.property));
        one.why.lines().for_each(|line| text.push_str(&format!("  {line}\n")));
    }
    text
}
