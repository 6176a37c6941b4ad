//! The process, which codels share with the daemon and with each other. What they change of it is
//! logged with the name of the codel, and undone where possible.

mod forked;
mod keys;
mod limits;
mod memory;
mod notes;
mod signals;
mod stand_ins;
mod standard;

pub(crate) use forked::is_child;
pub use forked::keep_from_children;
pub(crate) use keys::ends_threads;
use limits::KeptLimits;
pub use memory::without_leftovers;
use notes::{Act, Note};
use signals::KeptSignals;
pub use signals::raised_to_stop;
pub(crate) use signals::take_from as take_signals_from;
pub(crate) use standard::error_descriptor;
pub use standard::{StandardError, keep_off};

/// To be called before codels run: from then on functions that end the thread or the process come
/// to the host, and standard error has a copy.
pub fn guard_process() {
    stand_ins::keep();
    forked::prepare();
    let _ = StandardError::get();
}

/// What the process was like before codels could change it.
#[derive(Debug)]
pub struct KeptProcess {
    signals: KeptSignals,
    limits: KeptLimits,
}

impl KeptProcess {
    /// As it is now, which is to be after the daemon has set it up.
    #[must_use]
    pub fn remember() -> Self {
        Self { signals: KeptSignals::remember(), limits: KeptLimits::remember() }
    }

    /// Puts back what was changed since the last look: a sentence on each change, and on what
    /// codels tried. To be called from time to time, by no real-time thread.
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
            let name = signals::name(note.number);
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
