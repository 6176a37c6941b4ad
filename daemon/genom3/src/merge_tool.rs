//! How functions are settled whose parameters differ from the description's.

use std::io::{self, IsTerminal as _, Write as _};
use std::path::Path;
use std::process::Command;

use genom_project::File;
use genom_project::skeleton::{Conflict, Merge, Source};

use crate::stop::{Stop, print};

/// Who settles them.
#[derive(Debug)]
pub(crate) enum Tool {
    /// Both declarations are left in the file, between conflict marks.
    Marks,
    /// The user, on the terminal.
    Ask,
    /// A program that gets the existing file and a proposal.
    Program(String),
}

/// Brings one existing source up to date.
pub(crate) fn settle(
    directory: &Path,
    source: &Source,
    merge: &Merge,
    tool: &Tool,
    description: &Path,
) -> Result<(), Stop> {
    let here: Vec<_> = merge.conflicts.iter().filter(|c| c.path == source.path).collect();
    let gen_file = description.display().to_string();
    let text = match tool {
        Tool::Marks => merge.settled(source, |conflict| conflict.marked(&gen_file)),
        Tool::Program(program) => {
            let proposal = merge.settled(source, |conflict| conflict.wanted.clone());
            return propose(directory, source, &proposal, program);
        }
        Tool::Ask => {
            let mut answers = Vec::new();
            for conflict in &here {
                answers.push((*conflict, ask(conflict)?));
            }
            merge.settled(source, |conflict| {
                let answer = answers.iter().find(|(asked, _)| *asked == conflict);
                match answer.map(|(_, answer)| answer) {
                    Some(Answer::Replace) => conflict.wanted.clone(),
                    Some(Answer::Mark) => conflict.marked(&gen_file),
                    Some(Answer::Keep) | None => conflict.found.clone(),
                }
            })
        }
    };
    for conflict in here {
        let place = directory.join(&conflict.path);
        print(&format!("differs: {}:{}: {}\n", place.display(), conflict.line, conflict.name))?;
    }
    File::new(&source.path, text).write(directory, true)?;
    Ok(())
}

#[derive(Clone, Copy, Debug)]
enum Answer {
    Keep,
    Replace,
    Mark,
}

fn ask(conflict: &Conflict) -> Result<Answer, Stop> {
    if !io::stdin().is_terminal() {
        let message = "to be asked takes a terminal: use -m auto, or -m TOOL".to_owned();
        return Err(Stop::Usage(message));
    }
    loop {
        let place = conflict.path.display();
        let (line, found, wanted) = (conflict.line, &conflict.found, &conflict.wanted);
        print(&format!(
            "{place}:{line}: is\n{found}\nshould be\n{wanted}\n\
             [k]eep it, [r]eplace the declaration, or [m]ark both? "
        ))?;
        io::stdout().flush()?;
        let mut answer = String::new();
        if io::stdin().read_line(&mut answer)? == 0 {
            return Err(Stop::Failed("no answer".to_owned()));
        }
        match answer.trim() {
            "k" | "keep" => return Ok(Answer::Keep),
            "r" | "replace" => return Ok(Answer::Replace),
            "m" | "mark" => return Ok(Answer::Mark),
            _ => {}
        }
    }
}

/// Runs `program EXISTING PROPOSAL`; what it leaves in the existing file counts.
fn propose(directory: &Path, source: &Source, proposal: &str, program: &str) -> Result<(), Stop> {
    if proposal == source.text {
        return Ok(());
    }
    let existing = directory.join(&source.path);
    let mut name = source.path.clone().into_os_string();
    name.push(".proposed");
    let proposed = File::new(name, proposal);
    proposed.write(directory, true)?;
    let path = directory.join(&proposed.path);
    let status = Command::new(program).arg(&existing).arg(&path).status();
    let removed = std::fs::remove_file(&path);
    match status {
        Ok(status) if status.success() => Ok(removed?),
        Ok(status) => Err(Stop::Failed(format!("{program} {}: {status}", existing.display()))),
        Err(error) => Err(Stop::Failed(format!("{program}: {error}"))),
    }
}
