//! `genomctl fmt`: descriptions in the usual form. No daemon.

use std::path::{Path, PathBuf};

use genom_description::tools::format_text;

use crate::failure::Failure;
use crate::session::Session;

/// Format descriptions in place: indentation and blanks, never a token or comment.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// The .gen files.
    #[arg(required = true)]
    files: Vec<PathBuf>,
    /// Change nothing; fail if something would change.
    #[arg(long)]
    check: bool,
    /// Print the result instead of writing it back.
    #[arg(long, conflicts_with = "check")]
    stdout: bool,
}

pub(super) fn run(args: &Args, session: &Session) -> Result<(), Failure> {
    let mut unformatted = Vec::new();
    for path in &args.files {
        let text = std::fs::read_to_string(path).map_err(|error| unreadable(path, &error))?;
        let formatted = format_text(&text)
            .map_err(|error| Failure::refused("format", format!("{}: {error}", path.display())))?;
        if args.stdout {
            session.print(&formatted)?;
        } else if formatted != text {
            unformatted.push(path.display().to_string());
            if !args.check {
                std::fs::write(path, formatted)?;
            }
        }
    }
    if args.check && !unformatted.is_empty() {
        let message = format!("not in the usual form: {}", unformatted.join(", "));
        return Err(Failure::refused("format", message));
    }
    Ok(())
}

fn unreadable(path: &Path, error: &std::io::Error) -> Failure {
    Failure::usage(format!("{}: {error}", path.display()), "name a .gen file in UTF-8")
}
