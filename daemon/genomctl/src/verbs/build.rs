//! `genomctl build`: builds a component, however it is to be built. No daemon.

use std::path::{Path, PathBuf};
use std::process::Command;

use genom_project::build::{Bare, BuildError, Kind, kind};
use serde_json::json;

use crate::failure::Failure;
use crate::reading::Reading;
use crate::session::Session;

/// Build a component: with its CMake, Meson, autotools or cargo files, or, where there are none,
/// every source beside the .gen file or in its folder codels.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// The directory, or the .gen file of a component without build files.
    #[arg(default_value = ".", value_name = "DIRECTORY|FILE.gen")]
    place: PathBuf,
    /// Where to write what is built [default: build, in that directory].
    #[arg(long, short, value_name = "DIRECTORY")]
    output: Option<PathBuf>,
    #[command(flatten)]
    reading: Reading,
}

pub(super) fn run(args: &Args, session: &Session) -> Result<(), Failure> {
    let kind = kind(&args.place).map_err(refused)?;
    let directory = if args.place.is_dir() {
        args.place.clone()
    } else {
        args.place.parent().unwrap_or(Path::new("")).to_owned()
    };
    let output = args.output.clone().unwrap_or_else(|| directory.join("build"));
    match kind {
        Kind::Bare(description) => bare(args, &description, &output, session),
        Kind::Cargo => each(&[&["cargo", "build"]], &directory),
        Kind::CMake => {
            let (from, to) = (directory.to_string_lossy(), output.to_string_lossy());
            each(&[&["cmake", "-S", &from, "-B", &to], &["cmake", "--build", &to]], Path::new("."))
        }
        Kind::Meson => {
            let (from, to) = (directory.to_string_lossy(), output.to_string_lossy());
            let set_up: &[&[&str]] = if output.join("build.ninja").is_file() {
                &[]
            } else {
                &[&["meson", "setup", &to, &from]]
            };
            each(&[set_up, &[&["meson", "compile", "-C", &to]]].concat(), Path::new("."))
        }
        Kind::Autotools => {
            std::fs::create_dir_all(&output)?;
            if !directory.join("configure").is_file() {
                each(&[&["autoreconf", "-i"]], &directory)?;
            }
            if !output.join("config.status").is_file() {
                let script = std::path::absolute(directory.join("configure"))?;
                each(&[&[&script.to_string_lossy()]], &output)?;
            }
            each(&[&["make"]], &output)
        }
    }
}

fn bare(args: &Args, description: &Path, output: &Path, session: &Session) -> Result<(), Failure> {
    let analysis = args.reading.read_sound(&[description.to_owned()])?;
    let bare = Bare { description, analysis: &analysis, output };
    let built = bare.build(&mut |line| eprintln(line)).map_err(refused)?;
    if session.json {
        let reply = json!({ "library": built.library, "description": built.description });
        return session.print(&format!("{reply}\n"));
    }
    session.print(&format!("{}\n", built.library.display()))
}

/// Tells what a compiler said.
fn eprintln(line: &str) {
    // Nothing can be done about a closed standard error.
    let _ = std::io::Write::write_all(&mut std::io::stderr(), format!("{line}\n").as_bytes());
}

fn refused(error: BuildError) -> Failure {
    Failure::refused("build", error.to_string())
}

/// Runs commands, one after the other, until one fails.
fn each(commands: &[&[&str]], directory: &Path) -> Result<(), Failure> {
    for words in commands {
        let Some((program, arguments)) = words.split_first() else { continue };
        eprintln(&words.join(" "));
        let mut command = Command::new(program);
        command.args(arguments);
        if !directory.as_os_str().is_empty() {
            command.current_dir(directory);
        }
        let status = command.status().map_err(|error| {
            let help = format!("install {program}, or build by hand");
            Failure::refused_with("build", format!("{program}: {error}"), help)
        })?;
        if !status.success() {
            return Err(Failure::refused("build", format!("{program}: {status}")));
        }
    }
    Ok(())
}
