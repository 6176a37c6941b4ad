//! What a user types while a screen is shown.

use crossterm::event::{self, Event, KeyCode, KeyEvent, KeyEventKind, KeyModifiers};
use tokio::sync::mpsc;

/// The wishes that events mean. They are read in a thread of its own, which ends with the process.
pub(crate) fn listen<W: Send + 'static>(
    wish: fn(&Event) -> Option<W>,
) -> mpsc::UnboundedReceiver<W> {
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

/// The key that was pressed: `q` also for Ctrl-C and Esc.
pub(crate) fn pressed(event: &Event) -> Option<KeyCode> {
    match event {
        Event::Key(KeyEvent { kind: KeyEventKind::Press, code, modifiers, .. }) => match code {
            KeyCode::Char('c') if modifiers.contains(KeyModifiers::CONTROL) => {
                Some(KeyCode::Char('q'))
            }
            KeyCode::Esc => Some(KeyCode::Char('q')),
            code => Some(*code),
        },
        _ => None,
    }
}
