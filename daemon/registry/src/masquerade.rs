//! Types and services that go under foreign names, for as long as a component needs them to.

use std::sync::{Arc, PoisonError};

use crate::backends::{Backends, Disguise};
use crate::known::{BackendError, known};

/// A type or service is shown as a foreign one as long as this, or another of the same, is held.
pub struct Masquerade {
    backends: Arc<Backends>,
    disguise: Disguise,
}

impl Backends {
    /// Shows a type or service as a foreign one on a middleware; `None` when that is none of this
    /// daemon's. Of two that differ the first holds.
    ///
    /// # Errors
    /// The middleware has no such foreign names.
    pub fn masquerade(
        self: &Arc<Self>,
        on: &str,
        ours: &str,
        foreign: &str,
    ) -> Result<Option<Masquerade>, BackendError> {
        // `#pragma masquerade ros ...` is for GenoM3's own templates.
        let Some(on) = known().iter().find(|known| known.name == on) else { return Ok(None) };
        let (ours, foreign) = (ours.to_owned(), foreign.to_owned());
        let disguise = Disguise { on: on.name, ours, foreign };
        // Locked for all of it: a middleware that opens meanwhile is told once.
        let open = self.open.lock().unwrap_or_else(PoisonError::into_inner);
        let mut all = self.masquerades();
        if let Some((_, holders)) = all.iter_mut().find(|(one, _)| *one == disguise) {
            *holders += 1;
        } else {
            if let Some((middleware, _)) = open.get(disguise.on) {
                middleware.masquerade(&disguise.ours, &disguise.foreign)?;
            }
            all.push((disguise.clone(), 1));
        }
        drop((all, open));
        Ok(Some(Masquerade { backends: Arc::clone(self), disguise }))
    }

    /// What is shown as what: middleware, IDL name, foreign name.
    #[must_use]
    pub fn disguised(&self) -> Vec<(&'static str, String, String)> {
        let all = self.masquerades();
        all.iter().map(|(one, _)| (one.on, one.ours.clone(), one.foreign.clone())).collect()
    }

    /// Somebody does not need it any more.
    fn unmask(&self, disguise: &Disguise) {
        let open = self.open.lock().unwrap_or_else(PoisonError::into_inner);
        let mut all = self.masquerades();
        let Some(place) = all.iter().position(|(one, _)| one == disguise) else { return };
        all[place].1 -= 1;
        if all[place].1 > 0 {
            return;
        }
        let same = |one: &Disguise| one.on == disguise.on && one.ours == disguise.ours;
        let held = all.iter().position(|(one, _)| same(one)) == Some(place);
        all.remove(place);
        let Some((middleware, _)) = open.get(disguise.on).filter(|_| held) else { return };
        middleware.unmask(&disguise.ours);
        let next = all.iter().find(|(one, _)| same(one));
        if let Some(Err(why)) = next.map(|(one, _)| middleware.masquerade(&one.ours, &one.foreign))
        {
            tracing::warn!("#pragma masquerade: {why}");
        }
    }
}

impl Drop for Masquerade {
    fn drop(&mut self) {
        self.backends.unmask(&self.disguise);
    }
}

impl std::fmt::Debug for Masquerade {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Disguise { on, ours, foreign } = &self.disguise;
        write!(f, "Masquerade({ours} as {foreign} on {on})")
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use super::*;

    #[test]
    fn a_masquerade_lasts_as_long_as_somebody_holds_it() {
        let backends = Arc::new(Backends::new(BTreeMap::new()));
        let shown = |foreign| backends.masquerade("ros2", "::demo::pose", foreign).unwrap();
        let (first, second) = (shown("geometry_msgs/msg/Pose"), shown("geometry_msgs/msg/Pose"));
        let other = shown("geometry_msgs/msg/Twist");
        assert_eq!(backends.disguised().len(), 2);
        drop(first);
        assert_eq!(backends.disguised().len(), 2);
        drop(second);
        let left = backends.disguised();
        assert_eq!(left.len(), 1);
        assert_eq!(left[0].2, "geometry_msgs/msg/Twist");
        drop(other);
        assert!(backends.disguised().is_empty());
        assert!(backends.masquerade("ros", "::demo::pose", "any").unwrap().is_none());
    }
}
