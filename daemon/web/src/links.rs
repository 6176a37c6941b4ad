//! Links that open the console once.

use std::collections::VecDeque;
use std::io;
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use genom_proof::Bytes;

use crate::secret;
use crate::visitor::Visitor;

/// Links that wait to be opened; with one more, the oldest is forgotten.
const MOST: usize = 32;

/// The links that were not opened yet.
#[derive(Debug)]
pub(crate) struct Links {
    lifetime: Duration,
    made: Mutex<VecDeque<Made>>,
}

#[derive(Debug)]
struct Made {
    digest: Bytes<32>,
    visitor: Visitor,
    until: Instant,
}

impl Links {
    /// Links that have to be opened within this time.
    pub(crate) fn new(lifetime: Duration) -> Self {
        Self { lifetime, made: Mutex::default() }
    }

    /// How long a link can be opened.
    pub(crate) fn lifetime(&self) -> Duration {
        self.lifetime
    }

    /// The secret of a new link.
    pub(crate) fn make(&self, visitor: Visitor, now: Instant) -> io::Result<String> {
        let secret = secret::new()?;
        let digest = secret::digest(&secret);
        let mut made = self.made.lock().unwrap_or_else(PoisonError::into_inner);
        made.retain(|one| one.until > now);
        if made.len() >= MOST {
            made.pop_front();
        }
        made.push_back(Made { digest, visitor, until: now + self.lifetime });
        Ok(secret)
    }

    /// Who may come in with a link; it works once.
    pub(crate) fn open(&self, secret: &str, now: Instant) -> Option<Visitor> {
        let digest = secret::digest(secret);
        let mut made = self.made.lock().unwrap_or_else(PoisonError::into_inner);
        made.retain(|one| one.until > now);
        let at = made.iter().position(|one| one.digest == digest)?;
        made.remove(at).map(|one| one.visitor)
    }
}

#[cfg(test)]
mod tests {
    use genom_doors::{Holder, Tokens};

    use super::*;

    fn owner() -> Visitor {
        Visitor::of(&Holder::own(), None, &Tokens::read(None).unwrap())
    }

    #[test]
    fn a_link_opens_once_and_not_after_its_time() {
        let (links, now) = (Links::new(Duration::from_secs(60)), Instant::now());
        let secret = links.make(owner(), now).unwrap();
        assert_eq!(links.open("0123", now), None);
        assert_eq!(links.open(&secret, now), Some(owner()));
        assert_eq!(links.open(&secret, now), None, "it was used");
        let late = links.make(owner(), now).unwrap();
        assert_eq!(links.open(&late, now + Duration::from_secs(60)), None, "it is too old");
    }

    #[test]
    fn links_that_nobody_opens_are_forgotten() {
        let (links, now) = (Links::new(Duration::from_secs(60)), Instant::now());
        let first = links.make(owner(), now).unwrap();
        let rest: Vec<_> = (0..MOST).map(|_| links.make(owner(), now).unwrap()).collect();
        assert_eq!(links.made.lock().unwrap().len(), MOST);
        assert_eq!(links.open(&first, now), None);
        assert!(rest.iter().all(|secret| links.open(secret, now).is_some()));
    }
}
