//! Shows a plot on a terminal until the user quits.

use std::time::Duration;

use crossterm::event::{self, Event, KeyCode, KeyEvent, KeyEventKind, KeyModifiers};
use genom_drawing::plot::Plot;
use tokio::sync::mpsc;
use tokio::time::{MissedTickBehavior, interval};

use super::samples::Samples;
use crate::failure::Failure;

/// Time between two pictures.
const PICTURE: Duration = Duration::from_millis(50);

/// A command of the user.
enum Wish {
    Quit,
    Pause,
}

/// Shows the plot, with new samples as they come.
pub(crate) async fn run(samples: &mut Samples, plot: &mut Plot) -> Result<(), Failure> {
    let mut terminal = ratatui::try_init()?;
    let mut wishes = listen();
    let mut pictures = interval(PICTURE);
    pictures.set_missed_tick_behavior(MissedTickBehavior::Delay);
    let mut paused = false;
    let outcome = loop {
        tokio::select! {
            // Samples may come faster than they are taken: pictures and the user come first.
            biased;
            wish = wishes.recv() => match wish {
                None | Some(Wish::Quit) => break Ok(()),
                Some(Wish::Pause) => paused = !paused,
            },
            _ = tokio::signal::ctrl_c() => break Ok(()),
            _ = pictures.tick(), if !paused => {
                let drawn = terminal.draw(|frame| plot.draw(frame, "p pauses, q quits"));
                if let Err(error) = drawn {
                    break Err(Failure::Io(error));
                }
            }
            more = samples.next(plot) => match more {
                Ok(true) => {}
                Ok(false) => break Ok(()),
                Err(failure) => break Err(failure),
            },
        }
    };
    ratatui::restore();
    outcome
}

/// Keys are read in a thread of its own, which ends with the process.
fn listen() -> mpsc::UnboundedReceiver<Wish> {
    let (sender, receiver) = mpsc::unbounded_channel();
    std::thread::spawn(move || {
        while let Ok(event) = event::read() {
            if let Some(wish) = wish(&event)
                && sender.send(wish).is_err()
            {
                return;
            }
        }
    });
    receiver
}

fn wish(event: &Event) -> Option<Wish> {
    let Event::Key(KeyEvent { kind: KeyEventKind::Press, code, modifiers, .. }) = event else {
        return None;
    };
    match code {
        KeyCode::Char('c') if modifiers.contains(KeyModifiers::CONTROL) => Some(Wish::Quit),
        KeyCode::Char('q') | KeyCode::Esc => Some(Wish::Quit),
        KeyCode::Char('p' | ' ') => Some(Wish::Pause),
        _ => None,
    }
}
