//! What formulas and orders are about: things that happen in a component.

use std::fmt;

/// Something that happens, by name.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Atom {
    /// What of it; `None` for what is natural: a codel is called, a service starts, a port is
    /// written, an event is fired, a cycle of a task begins.
    pub what: Option<What>,
    /// The name of a codel, service, port, event or task.
    pub name: String,
    /// Where the name stands in its text, from 1.
    pub column: usize,
}

/// What of a name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum What {
    /// A codel is called.
    Codel,
    /// A codel has returned.
    Return,
    /// An activity is accepted.
    Accept,
    /// A service starts: a function or attribute is executed, an activity begins to run.
    Start,
    /// An activity is asked to stop.
    Stop,
    /// A service that had started has ended.
    End,
    /// A service has started and not ended. The only one that lasts.
    Run,
    /// A codel wrote a port.
    Write,
    /// An event was fired.
    Fire,
    /// A cycle of a task begins.
    Cycle,
}

impl What {
    /// All, as they are written.
    pub const ALL: [(&'static str, Self); 10] = [
        ("codel", Self::Codel),
        ("return", Self::Return),
        ("accept", Self::Accept),
        ("start", Self::Start),
        ("stop", Self::Stop),
        ("end", Self::End),
        ("run", Self::Run),
        ("write", Self::Write),
        ("fire", Self::Fire),
        ("cycle", Self::Cycle),
    ];

    /// As it is written.
    #[must_use]
    pub fn name(self) -> &'static str {
        Self::ALL.iter().find(|(_, one)| *one == self).map_or("", |(name, _)| name)
    }
}

impl fmt::Display for Atom {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.what {
            None => f.write_str(&self.name),
            Some(what) => write!(f, "{}({})", what.name(), self.name),
        }
    }
}
