//! The process, which codels share with the daemon and with each other. Changes that they make to
//! it are logged with the name of the codel, and undone where possible.

mod forked;
mod keys;
mod limits;
mod memory;
mod names;
mod notes;
mod signals;
mod stand_ins;
mod standard;
mod variables;

pub(crate) use forked::is_child;
pub use forked::keep_from_children;
pub(crate) use keys::ends_threads;
use limits::KeptLimits;
pub use memory::without_leftovers;
pub use names::signal_name;
use notes::{Act, Note};
use signals::KeptSignals;
pub use signals::raised_to_stop;
pub(crate) use signals::take_from as take_signals_from;
pub(crate) use standard::error_descriptor;
pub use standard::{StandardError, keep_off};
pub use variables::take_variable;

/// Call this before codels run: from then on, calls that end the thread or the process are
/// intercepted, and there is a copy of standard error.
pub fn guard_process() {
    stand_ins::keep();
    forked::prepare();
    let _ = StandardError::get();
}

/// The state of the process before codels could change it.
#[derive(Debug)]
pub struct KeptProcess {
    signals: KeptSignals,
    limits: KeptLimits,
}

impl KeptProcess {
    /// Records the present state; call it after the daemon has set up the process.
    #[must_use]
    pub fn remember() -> Self {
        Self { signals: KeptSignals::remember(), limits: KeptLimits::remember() }
    }

    /// Undoes changes made since the last call; returns messages on these changes, and on attempts
    /// of codels. To be called periodically, not on a real-time thread.
    pub fn look(&self) -> Vec<String> {
        let mut told: Vec<String> = self
            .signals
            .put_back()
            .into_iter()
            .map(|name| format!("a codel changed what genomd does on {name}: it is put back"))
            .collect();
        told.extend(self.limits.put_back());
        told.extend(standard::put_back());
        told.extend(notes::take(&[Act::Signal, Act::Limit, Act::Close]).iter().map(sentence));
        told
    }
}

fn sentence(note: &Note) -> String {
    let who = if note.words.is_empty() { "code outside codels" } else { note.words.as_str() };
    let often = if note.times > 1 { format!(", {} times", note.times) } else { String::new() };
    match note.act {
        Act::Limit => format!(
            "{who} wanted to lower {} of the whole process{often}: refused",
            limits::name(note.number)
        ),
        Act::Close => format!(
            "{who} wanted to close standard {}{often}: it stays open",
            standard::name(note.number)
        ),
        Act::Signal | Act::Sent | Act::Reopened => {
            let name = names::name(note.number);
            let from = match note.sender {
                0 => " from a timer or the kernel".to_owned(),
                pid if pid.unsigned_abs() == std::process::id() => String::new(),
                pid => format!(" from process {pid}"),
            };
            let during =
                if note.words.is_empty() { String::new() } else { format!(" in {}", note.words) };
            format!("{name}{from}{during}{often}: nobody handles it, it is left without effect")
        }
    }
}
