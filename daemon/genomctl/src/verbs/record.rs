//! `genomctl record`: records ports and calls of services in a file.

use std::fs::File;
use std::io::{IsTerminal as _, Write as _};
use std::path::PathBuf;
use std::time::Duration;

use genom_protocol::frames::Frame;
use genom_protocol::{RecordingRequest, routes};
use genom_recording::{ChannelSummary, Recorder, WriteError};
use serde_json::{Value, json};
use tokio::signal::unix::{SignalKind, signal};

use crate::failure::Failure;
use crate::frames::Frames;
use crate::session::Session;
use crate::table::Table;
use crate::times::seconds;

/// How often the file is saved and the terminal updated.
const SAVE: Duration = Duration::from_secs(1);

/// Record ports, service calls, activities and exceptions in an MCAP file, until Ctrl-C.
///
/// Every sample that codels write or read is recorded, with the date of that moment. If the
/// machine's clock is set meanwhile, dates do not jump. Foxglove, PlotJuggler and the MCAP
/// libraries read the file. Samples that could not be recorded in time are counted, and shown at
/// the end. The file is saved every second: if the recorder is killed, `genomctl replay` can read
/// what was saved, and `genomctl recover` turns it into a complete file.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// What to record: COMPONENT, COMPONENT/PORT or COMPONENT/PORT/ELEMENT [default: everything].
    ports: Vec<String>,
    /// The file.
    #[arg(long, short, value_name = "FILE")]
    output: PathBuf,
    /// Replace an existing file.
    #[arg(long)]
    force: bool,
    /// Stop after this many seconds.
    #[arg(long, short, value_name = "SECONDS", value_parser = seconds)]
    duration: Option<Duration>,
}

pub(super) async fn run(args: Args, session: &Session) -> Result<(), Failure> {
    let mut interrupt = signal(SignalKind::interrupt())?;
    let mut terminate = signal(SignalKind::terminate())?;
    if args.output.exists() && !args.force {
        let message = format!("{} is there already", args.output.display());
        return Err(Failure::usage(message, "name another file, or replace it with --force"));
    }
    let request =
        json!(RecordingRequest { ports: args.ports.clone(), times: false, ordered: true });
    let body = session.client.open(&routes::record(), request.to_string().into_bytes()).await?;
    let mut frames = Frames::new(body);
    let start = match frames.next().await? {
        Some(Frame::Start(start)) => start,
        Some(_) => return Err(session.client.misread("a recording without a start".to_owned())),
        None => return Err(session.client.lost()),
    };
    let file = File::create(&args.output).map_err(|error| {
        Failure::usage(format!("{}: {error}", args.output.display()), "name another file")
    })?;
    let mut recorder = Recorder::new("genomctl", &args.output, file, &start)?;
    tell(&format!("recording to {}; Ctrl-C ends it\n", args.output.display()));

    let mut over = std::pin::pin!(tokio::time::sleep(args.duration.unwrap_or(Duration::MAX)));
    let mut tick = tokio::time::interval(SAVE);
    let mut ending = false;
    let lives = std::io::stderr().is_terminal();
    let (mut full, mut silent) = (None, None);
    let complete = loop {
        let enough = tokio::select! {
            frame = frames.next() => {
                let taken = match frame {
                    Ok(Some(Frame::Channel(channel))) => recorder.channel(channel),
                    Ok(Some(Frame::Sample(sample))) => recorder.sample(&sample),
                    Ok(Some(Frame::Lost(lost))) => {
                        recorder.lost(lost);
                        Ok(())
                    }
                    Ok(Some(Frame::Until(_))) => Ok(()),
                    Ok(Some(Frame::End(_))) => break true,
                    Ok(Some(Frame::Start(_)) | None) => break false,
                    Err(failure) => {
                        silent = Some(failure);
                        break false;
                    }
                };
                match taken {
                    Err(error @ WriteError::Full { .. }) => {
                        full = Some(error);
                        break false;
                    }
                    taken => taken?,
                }
                false
            }
            _ = tick.tick() => {
                recorder.save()?;
                if lives {
                    let (messages, lost) = recorder.counts();
                    tell(&format!("\r{messages} messages, {lost} lost "));
                }
                false
            }
            _ = interrupt.recv() => true,
            _ = terminate.recv() => true,
            () = &mut over, if !ending => true,
        };
        if enough && ending {
            // Interrupted a second time: samples that have not arrived are given up.
            break false;
        }
        if enough {
            ending = true;
            // The daemon sends all samples taken until now, then ends the recording.
            let number = start.recording.to_string();
            if session.ask(routes::end_recording(&number)).await.is_err() {
                break false;
            }
        }
    };
    if lives {
        tell("\n");
    }
    let channels = recorder.finish(complete)?;
    session.show_own(&reply(&args, &channels, complete), || render(&channels))?;
    match full.map(Failure::from).or(silent) {
        Some(failure) => Err(failure),
        None if complete => Ok(()),
        None => Err(Failure::cut_short(&args.output)),
    }
}

fn tell(text: &str) {
    let _ = std::io::stderr().lock().write_all(text.as_bytes());
}

fn reply(args: &Args, channels: &[ChannelSummary], complete: bool) -> Value {
    let channels: Vec<Value> = channels
        .iter()
        .map(|told| json!({"topic": told.topic, "messages": told.messages, "lost": told.lost}))
        .collect();
    json!({"file": args.output, "complete": complete, "channels": channels})
}

fn render(channels: &[ChannelSummary]) -> Table {
    let rows: Vec<Vec<String>> = channels
        .iter()
        .map(|told| vec![told.topic.clone(), told.messages.to_string(), told.lost.to_string()])
        .collect();
    Table { header: vec!["TOPIC", "MESSAGES", "LOST"], rows }
}
