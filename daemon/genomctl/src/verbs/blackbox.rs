//! `genomctl blackbox`: what happened in the last seconds.

use std::fs::File;
use std::path::{Path, PathBuf};

use clap::Subcommand;
use genom_protocol::frames::Frame;
use genom_protocol::{BlackBox, BlackBoxLeft, BlackBoxPart, routes};
use genom_recording::{Recorder, WriteError};
use serde_json::json;

use crate::failure::Failure;
use crate::frames::Frames;
use crate::session::Session;
use crate::table::Table;
use crate::terminal::Terminal;

/// Show how the black box is, which keeps the last seconds of ports, calls and activities, or save
/// what it keeps.
///
/// Section [blackbox] of the configuration switches it on, and says what it keeps and what makes it
/// write a file by itself. Files are MCAP, as those of `genomctl record`.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    #[command(subcommand)]
    what: Option<What>,
}

#[derive(Debug, Subcommand)]
enum What {
    /// Show what it keeps of each process, and the files that it wrote.
    Status,
    /// Save what it keeps.
    Save {
        /// The file, on this machine [default: one in the daemon's directory].
        file: Option<PathBuf>,
        /// Replace an existing file.
        #[arg(long, requires = "file")]
        force: bool,
    },
}

pub(super) async fn run(args: Args, session: &Session) -> Result<(), Failure> {
    match args.what {
        None | Some(What::Status) => {
            let reply = session.ask(routes::blackbox()).await?;
            session.show(&reply, |told| render(told, session.terminal))
        }
        Some(What::Save { file: None, .. }) => {
            let reply = session.ask(routes::save_blackbox()).await?;
            session.show(&reply, saved)?;
            match reply.content.error {
                Some(error) => Err(Failure::refused("full", error)),
                None => Ok(()),
            }
        }
        Some(What::Save { file: Some(file), force }) => receive(&file, force, session).await,
    }
}

/// Writes what the daemon sends to a file here.
async fn receive(path: &Path, force: bool, session: &Session) -> Result<(), Failure> {
    if path.exists() && !force {
        let message = format!("{} is there already", path.display());
        return Err(Failure::usage(message, "name another file, or replace it with --force"));
    }
    let body = session.client.open(&routes::blackbox_frames(), Vec::new()).await?;
    let mut frames = Frames::new(body);
    let Some(Frame::Start(start)) = frames.next().await? else {
        return Err(session.client.misread("a recording without a start".to_owned()));
    };
    let file = File::create(path).map_err(|error| {
        Failure::usage(format!("{}: {error}", path.display()), "name another file")
    })?;
    let mut recorder = Recorder::new("genomctl", path, file, &start)?;
    let mut full = None;
    let complete = loop {
        let taken = match frames.next().await? {
            Some(Frame::Channel(channel)) => recorder.channel(channel),
            Some(Frame::Sample(sample)) => recorder.sample(&sample),
            Some(Frame::Lost(lost)) => {
                recorder.lost(lost);
                Ok(())
            }
            Some(Frame::Until(_)) => Ok(()),
            Some(Frame::End(_)) => break true,
            Some(Frame::Start(_)) | None => break false,
        };
        match taken {
            Err(error @ WriteError::Full { .. }) => {
                full = Some(error);
                break false;
            }
            taken => taken?,
        }
    };
    let (messages, _) = recorder.counts();
    let channels = recorder.finish(complete)?;
    let told = json!({"file": path, "messages": messages, "complete": complete});
    session.show_own(&told, || Table {
        header: vec!["TOPIC", "MESSAGES"],
        rows: channels
            .iter()
            .map(|one| vec![one.topic.clone(), one.messages.to_string()])
            .collect(),
    })?;
    match full.map(Failure::from) {
        Some(failure) => Err(failure),
        None if complete => Ok(()),
        None => Err(Failure::cut_short(path)),
    }
}

fn saved(left: &BlackBoxLeft) -> String {
    let short = match left.short {
        0 => String::new(),
        count => format!("; {count} topics do not reach back as far as they should"),
    };
    format!("{}: {} messages{short}\n", left.file.display(), left.messages)
}

fn render(told: &BlackBox, terminal: Terminal) -> String {
    if !told.enabled {
        return "off: set blackbox.enabled = true in the configuration\n".to_owned();
    }
    let row = |part: &BlackBoxPart| {
        vec![
            part.cell.clone().unwrap_or_else(|| "-".to_owned()),
            part.tracks.to_string(),
            part.bytes.to_string(),
            part.most_bytes.to_string(),
            part.memory.to_string(),
            part.taken.to_string(),
            part.refused.to_string(),
        ]
    };
    let table = Table {
        header: vec!["CELL", "TRACKS", "BYTES", "MOST", "MEMORY", "TAKEN", "REFUSED"],
        rows: told.processes.iter().map(row).collect(),
    };
    let on = match told.on.is_empty() {
        true => "nothing but this command".to_owned(),
        false => told.on.join(", "),
    };
    let mut text = table.text(terminal);
    text += &format!("files reach back {} s; written on: {on}\n", told.seconds);
    if told.skipped > 0 {
        text += &format!("{} reasons without a file: one was written before\n", told.skipped);
    }
    if let Some(directory) = told.directory.as_ref().filter(|_| !told.files.is_empty()) {
        text += &format!("in {}:\n", directory.display());
    }
    for file in &told.files {
        text += &format!("  {} ({} bytes)\n", file.name, file.bytes);
    }
    told.unmatched.iter().for_each(|line| text += &format!("warning: {line}\n"));
    text
}

#[cfg(test)]
mod tests {
    use genom_protocol::BlackBoxFile;

    use super::*;

    #[test]
    fn people_are_told_what_is_kept_and_what_was_written() {
        let part = BlackBoxPart {
            cell: Some("arm".into()),
            tracks: 7,
            bytes: 4096,
            most_bytes: 8_388_608,
            memory: 8192,
            taken: 100,
            refused: 0,
        };
        let mut told = BlackBox {
            enabled: true,
            seconds: 10.0,
            on: vec!["crash".into()],
            directory: Some("/s".into()),
            processes: vec![part],
            files: vec![BlackBoxFile { name: "blackbox-1-command.mcap".into(), bytes: 12 }],
            skipped: 2,
            unmatched: vec!["blackbox.ports: `x/y` matches nothing that runs".into()],
        };
        let text = render(&told, Terminal::default());
        for line in [
            "files reach back 10 s; written on: crash",
            "2 reasons without a file: one was written before",
            "in /s:",
            "  blackbox-1-command.mcap (12 bytes)",
            "warning: blackbox.ports: `x/y` matches nothing that runs",
        ] {
            assert!(text.lines().any(|found| found == line), "{line} in\n{text}");
        }
        told.enabled = false;
        assert!(render(&told, Terminal::default()).starts_with("off: "));
    }
}
