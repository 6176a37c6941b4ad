//! Signs of life that the service manager does not get since a component broke a rule whose reaction
//! is `withhold`, until somebody clears that.

use std::collections::BTreeMap;
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Limit on components of which that is kept.
const MOST: usize = 1024;

/// For which components signs are withheld, and why.
#[derive(Debug, Default)]
pub struct Withheld(Mutex<BTreeMap<String, String>>);

impl Withheld {
    fn lock(&self) -> MutexGuard<'_, BTreeMap<String, String>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// From now on no sign is given; the first reason stays.
    pub fn withhold(&self, component: &str, why: String) {
        let mut all = self.lock();
        if all.len() < MOST {
            all.entry(component.to_owned()).or_insert(why);
        }
    }

    /// The reason for one component is cleared. Returns it, if there was one.
    pub fn clear(&self, component: &str) -> Option<String> {
        self.lock().remove(component)
    }

    /// Why no sign is given now: the first reason.
    pub fn why(&self) -> Option<String> {
        self.lock().values().next().cloned()
    }

    /// The components, and why.
    pub fn all(&self) -> Vec<(String, String)> {
        self.lock().iter().map(|(component, why)| (component.clone(), why.clone())).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn signs_are_withheld_until_all_reasons_are_cleared() {
        let withheld = Withheld::default();
        assert_eq!(withheld.why(), None);
        withheld.withhold("arm", "first".into());
        withheld.withhold("arm", "second".into());
        withheld.withhold("base", "third".into());
        assert_eq!(withheld.clear("arm").as_deref(), Some("first"));
        assert_eq!((withheld.clear("arm"), withheld.why()), (None, Some("third".into())));
        assert_eq!(withheld.all(), [("base".into(), "third".into())]);
        assert_eq!(withheld.clear("base").as_deref(), Some("third"));
        assert_eq!(withheld.why(), None);
    }
}
