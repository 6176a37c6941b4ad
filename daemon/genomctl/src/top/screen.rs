//! Shows the live table on a terminal until the user quits.

use std::time::Duration;

use crossterm::event::{Event, KeyCode};
use genom_drawing::top::{Trends, draw};
use genom_protocol::routes;

use super::snapshot::take;
use crate::failure::Failure;
use crate::keys::{listen, pressed};
use crate::session::Session;

/// A command of the user.
enum Wish {
    Quit,
    Up,
    Down,
    /// Stop or continue updating.
    Pause,
    /// Stop all activities.
    Stop,
    /// The size of the terminal changed.
    Redraw,
}

/// Shows the table, updated every `period`.
pub(crate) async fn run(session: &Session, period: Duration) -> Result<(), Failure> {
    // Before the screen is switched: if there is no daemon, the error appears on the normal screen.
    let mut now = take(session).await?;
    let mut before = None;
    let mut terminal = ratatui::try_init()?;
    let mut wishes = listen(wish);
    let (mut scroll, mut paused, mut trends) = (0_usize, false, Trends::default());
    let mut ticks = tokio::time::interval(period);
    ticks.tick().await;
    // Result of the last command to stop.
    let mut told = String::new();
    let outcome = loop {
        let keys = match paused {
            true => "paused: p goes on; s stops all activities, q quits, arrows",
            false => "s stops all activities, p pauses, q quits, arrows",
        };
        let help = format!("{told}{keys}");
        let drawn =
            terminal.draw(|frame| draw(frame, &now, before.as_ref(), &trends, scroll, &help));
        if let Err(error) = drawn {
            break Err(Failure::Io(error));
        }
        tokio::select! {
            _ = ticks.tick(), if !paused => match take(session).await {
                Ok(next) => {
                    let last = std::mem::replace(&mut now, next);
                    trends.add(&now, &last);
                    before = Some(last);
                }
                Err(failure) => break Err(failure),
            },
            wish = wishes.recv() => match wish {
                None | Some(Wish::Quit) => break Ok(()),
                Some(Wish::Up) => scroll = scroll.saturating_sub(1),
                Some(Wish::Down) => scroll = (scroll + 1).min(now.ports.len().saturating_sub(1)),
                Some(Wish::Pause) => paused = !paused,
                Some(Wish::Stop) => told = format!("{}; ", stop(session).await),
                Some(Wish::Redraw) => {}
            },
            _ = tokio::signal::ctrl_c() => break Ok(()),
        }
    };
    ratatui::restore();
    outcome
}

/// Asks all activities to stop without waiting; returns the result in a few words.
async fn stop(session: &Session) -> String {
    let told = match session.ask(routes::stop()).await {
        Ok(reply) => reply.content.aborted.len(),
        Err(failure) => return format!("NOT STOPPED: {failure}"),
    };
    match told {
        0 => "no activity runs".to_owned(),
        1 => "1 activity told to stop".to_owned(),
        told => format!("{told} activities told to stop"),
    }
}

fn wish(event: &Event) -> Option<Wish> {
    if let Event::Resize(..) = event {
        return Some(Wish::Redraw);
    }
    match pressed(event)? {
        KeyCode::Char('q') => Some(Wish::Quit),
        KeyCode::Char('p' | ' ') => Some(Wish::Pause),
        KeyCode::Char('s') => Some(Wish::Stop),
        KeyCode::Up | KeyCode::Char('k') => Some(Wish::Up),
        KeyCode::Down | KeyCode::Char('j') => Some(Wish::Down),
        _ => None,
    }
}
