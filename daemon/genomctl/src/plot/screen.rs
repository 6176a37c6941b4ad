//! Shows a plot on a terminal until the user quits.

use std::time::Duration;

use crossterm::event::{Event, KeyCode};
use genom_drawing::plot::Plot;
use tokio::time::{MissedTickBehavior, interval};

use super::samples::Samples;
use crate::failure::Failure;
use crate::keys::{listen, pressed};

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
    let mut wishes = listen(wish);
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

fn wish(event: &Event) -> Option<Wish> {
    match pressed(event)? {
        KeyCode::Char('q') => Some(Wish::Quit),
        KeyCode::Char('p' | ' ') => Some(Wish::Pause),
        _ => None,
    }
}
