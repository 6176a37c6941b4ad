//! What a broken rule of supervision asks for beyond its own component: who does it is up to the
//! program, which knows processes and other components.

use std::sync::OnceLock;
use std::time::Instant;

use genom_configuration::Reaction;

use genom_bus::Change;

/// Things to do of other components.
#[derive(Clone, Debug)]
pub struct Asked {
    /// Instance name of the component that broke the rule.
    pub component: String,
    /// What is to be done, side by side.
    pub reactions: Vec<Reaction>,
    /// When the violation was seen.
    pub seen: Instant,
}

/// Does what broken rules ask for. Called by threads of components, which it must not hold up.
pub trait Reactor: Send + Sync {
    /// Does things of other components.
    fn react(&self, asked: Asked);
    /// Ends this process by a fault, so that it is started again, and has the violation told: this
    /// process may end before it could. `thread` is in a codel that has not returned.
    fn restart(&self, violation: &Change, why: &str, thread: Option<u32>);
}

/// The reactor of a program, once it is there.
#[derive(Default)]
pub struct Reactions(OnceLock<Box<dyn Reactor>>);

impl Reactions {
    /// Sets who does it; further calls have no effect.
    pub fn set(&self, reactor: impl Reactor + 'static) {
        let _ = self.0.set(Box::new(reactor));
    }

    pub(crate) fn get(&self) -> Option<&dyn Reactor> {
        let reactor = self.0.get();
        if reactor.is_none() {
            tracing::error!("supervision: nobody does what a broken rule asks for");
        }
        reactor.map(Box::as_ref)
    }
}
