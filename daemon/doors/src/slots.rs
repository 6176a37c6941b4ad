//! Slots for what clients hold open, such as streams. Each client has a share, and the owner of the
//! process has slots that nobody else can use.

use std::collections::HashMap;
use std::fmt;
use std::sync::{Arc, Mutex, PoisonError};

/// Who takes a slot.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub enum Share {
    /// The client at the Unix socket.
    Own,
    /// The clients with this token or certificate.
    Of(String),
}

/// A number of slots for the owner of the process, and the same number for all others together.
#[derive(Debug)]
pub struct Slots {
    /// Slots for the owner of the process, and for all others together.
    most: usize,
    /// Slots for each of the others.
    each: usize,
    taken: Mutex<HashMap<Share, usize>>,
}

/// No slot is free.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Full {
    /// All `.0` slots are taken.
    All(usize),
    /// This client has taken its share of `.0` slots.
    Share(usize),
}

/// The limit that was reached, for messages: `64`, or `16 of this token`.
impl fmt::Display for Full {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::All(most) => write!(f, "{most}"),
            Self::Share(most) => write!(f, "{most} of this token"),
        }
    }
}

/// A slot; freed when dropped.
#[derive(Debug)]
pub struct Slot {
    of: Share,
    slots: Arc<Slots>,
}

impl Slots {
    /// `most` slots for the owner and as many for all others together, of which each can have
    /// `each`.
    pub fn new(most: usize, each: usize) -> Arc<Self> {
        Arc::new(Self { most, each, taken: Mutex::default() })
    }

    /// Takes a slot.
    ///
    /// # Errors
    /// No slot is free, or the holder has taken its share.
    pub fn take(self: &Arc<Self>, of: Share) -> Result<Slot, Full> {
        let mut taken = self.taken.lock().unwrap_or_else(PoisonError::into_inner);
        let own = taken.get(&of).copied().unwrap_or_default();
        let together: usize = match of {
            Share::Own => own,
            Share::Of(_) => {
                taken.iter().filter(|(of, _)| **of != Share::Own).map(|(_, count)| count).sum()
            }
        };
        if together >= self.most {
            return Err(Full::All(self.most));
        }
        if of != Share::Own && own >= self.each {
            return Err(Full::Share(self.each));
        }
        taken.insert(of.clone(), own + 1);
        Ok(Slot { of, slots: Arc::clone(self) })
    }
}

impl Drop for Slot {
    fn drop(&mut self) {
        let mut taken = self.slots.taken.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(count) = taken.get_mut(&self.of) {
            *count -= 1;
            if *count == 0 {
                taken.remove(&self.of);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nobody_takes_anothers_share() {
        let slots = Slots::new(3, 2);
        let of = |name: &str| Share::Of(name.to_owned());
        let held = [slots.take(of("a")).unwrap(), slots.take(of("a")).unwrap()];
        assert_eq!(slots.take(of("a")).unwrap_err(), Full::Share(2));
        let other = slots.take(of("b")).unwrap();
        assert_eq!(slots.take(of("b")).unwrap_err(), Full::All(3));
        // The owner still has all of its slots.
        let own: Vec<_> = (0..3).map(|_| slots.take(Share::Own).unwrap()).collect();
        assert_eq!(slots.take(Share::Own).unwrap_err(), Full::All(3));
        drop((held, other));
        assert!(slots.take(of("b")).is_ok());
        drop(own);
        assert!(slots.taken.lock().unwrap().is_empty(), "what is free is forgotten");
    }
}
