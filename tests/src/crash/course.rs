//! What a daemon does while it is traced.

use std::path::Path;

use super::watched::Watched;
use crate::http::attempt;

/// A part of a daemon's life.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Phase {
    /// Starts and loads a component.
    Load,
    /// The component moves away from shared memory and back.
    Move,
    /// Its in port is connected to a port of a peer, then fed with a published value again.
    Connect,
    /// The component is unloaded.
    Unload,
    /// The daemon stops while the component is loaded.
    Stop,
}

impl Phase {
    /// All phases, in order.
    pub const ALL: [Self; 5] = [Self::Load, Self::Move, Self::Connect, Self::Unload, Self::Stop];

    /// Index in [`Phase::ALL`].
    #[must_use]
    pub fn number(self) -> usize {
        Self::ALL.iter().position(|phase| *phase == self).unwrap_or_default()
    }

    /// Name in a table.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Load => "load",
            Self::Move => "move",
            Self::Connect => "connect",
            Self::Unload => "unload",
            Self::Stop => "stop",
        }
    }

    /// The phases up to and including this one.
    pub(super) fn way(self) -> &'static [Self] {
        match self {
            Self::Load => &[Self::Load],
            Self::Move => &[Self::Load, Self::Move],
            Self::Connect => &[Self::Load, Self::Connect],
            Self::Unload => &[Self::Load, Self::Connect, Self::Unload],
            Self::Stop => &[Self::Load, Self::Connect, Self::Stop],
        }
    }

    /// Makes a daemon go through this phase. Returns false if the daemon ended meanwhile.
    pub(super) fn drive(self, watched: &Watched, socket: &Path) -> bool {
        let asked =
            |method: &str, path: &str, body: &str| attempt(socket, method, path, body).is_ok();
        watched.enter(self.number());
        match self {
            Self::Load => watched.is_ready(),
            Self::Move => ["local", "shm"].iter().all(|backend| {
                let body = format!("{{\"backend\":\"{backend}\"}}");
                asked("PUT", "/components/demo/backend", &body)
            }),
            Self::Connect => {
                let body = r#"{"in":"demo/parameter","out":"sensor/x"}"#;
                asked("POST", "/connections", body)
                    && asked("DELETE", "/connections/demo/parameter", "")
                    && asked("POST", "/components/demo/ports/parameter", "0.5")
                    && asked("GET", "/middlewares?visible=true", "")
            }
            Self::Unload => asked("DELETE", "/components/demo", ""),
            Self::Stop => {
                watched.stop();
                true
            }
        }
    }
}
