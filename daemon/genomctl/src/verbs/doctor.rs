//! `genomctl doctor`: finds what keeps components from running well on this machine.

use std::path::{Path, PathBuf};

use genom_doctor::{Machine, of_files};
use genom_protocol::{Diagnosis, Severity};
use serde_json::json;

use crate::doctor::live;
use crate::escape;
use crate::failure::Failure;
use crate::session::Session;
use crate::terminal::{Terminal, Tone};

/// Examine this machine and the daemon, and print each finding with advice.
///
/// Examines shared memory, the network for ROS 2, real-time rights, timing, remains of killed
/// programs, and versions. The exit status is 1 if there is a problem; notes do not count as
/// problems.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// Also examine a configuration of genomd.
    #[arg(long, value_name = "FILE")]
    config: Option<PathBuf>,
    /// Examine the files of another machine (/proc, /sys, /dev, /tmp), copied into a directory. No
    /// tests are made then, and no daemon is asked.
    #[arg(long, value_name = "DIRECTORY", conflicts_with = "config")]
    root: Option<PathBuf>,
}

pub(super) async fn run(args: Args, session: &Session) -> Result<(), Failure> {
    let machine = Machine::at(args.root.as_deref().unwrap_or(Path::new("/")));
    let mut findings = of_files(&machine);
    if args.root.is_none() {
        findings.extend(live(session, args.config.as_deref()).await);
    }
    let text = if session.json {
        format!("{}\n", json!({ "findings": findings }))
    } else {
        findings.iter().map(|finding| render(finding, session.terminal)).collect()
    };
    session.print(&text)?;
    match findings.iter().filter(|finding| finding.level == Severity::Problem).count() {
        0 => Ok(()),
        1 => Err(Failure::refused("problems", "1 problem".to_owned())),
        count => Err(Failure::refused("problems", format!("{count} problems"))),
    }
}

fn render(finding: &Diagnosis, terminal: Terminal) -> String {
    let level = match finding.level {
        Severity::Ok => "ok",
        Severity::Note => "note",
        Severity::Problem => "problem",
    };
    let padded = format!("{level:<8}");
    let tone = Tone::of(level).filter(|_| terminal.colour);
    let level = tone.map_or(padded.clone(), |tone| tone.paint(&padded));
    let mut text = format!("{level} {}: {}\n", finding.about, escape::lines(&finding.what));
    if let Some(fix) = &finding.fix {
        text.push_str(&format!("         fix: {}\n", escape::lines(fix)));
    }
    text
}
