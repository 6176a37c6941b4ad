//! Types and services shown under foreign names, for as long as a component needs them to be.

use std::sync::{Arc, PoisonError};

use crate::backends::{Backends, Disguise};
use crate::known::{BackendError, known};

/// The middleware that has rules of renaming.
const RENAMING: &str = "ros2";

/// Keeps a type or service shown under a foreign name. The name lasts until the last `Masquerade`
/// for it is dropped.
pub struct Masquerade {
    backends: Arc<Backends>,
    disguise: Disguise,
}

impl Backends {
    /// Shows a type or service under a foreign name on the middleware `on`; returns `None` if this
    /// daemon has no such middleware. If two foreign names are given to one type, the first
    /// applies.
    ///
    /// # Errors
    /// The middleware does not accept the foreign name.
    pub fn masquerade(
        self: &Arc<Self>,
        on: &str,
        ours: &str,
        foreign: &str,
    ) -> Result<Option<Masquerade>, BackendError> {
        // GenoM3's own templates use other names, such as `#pragma masquerade ros ...`; these are
        // ignored.
        let Some(on) = known().iter().find(|known| known.name == on) else { return Ok(None) };
        let (ours, foreign) = (ours.to_owned(), foreign.to_owned());
        let disguise = Disguise { on: on.name, ours, foreign };
        // Locked throughout, so that a middleware that opens meanwhile is given the name exactly
        // once.
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

    /// Shows an instance, its ports or services under other names on ROS 2: pairs of our name and
    /// the other one, as [`Middleware::masquerade`](genom_middleware::Middleware::masquerade) takes
    /// them.
    ///
    /// # Errors
    /// The middleware does not accept a name.
    pub fn rename(
        self: &Arc<Self>,
        names: Vec<(String, String)>,
    ) -> Result<Vec<Masquerade>, BackendError> {
        let one =
            |(ours, other): (String, String)| self.masquerade(RENAMING, &ours, &other).transpose();
        names.into_iter().filter_map(one).collect()
    }

    /// The names in use: middleware, full IDL name, foreign name.
    #[must_use]
    pub fn disguised(&self) -> Vec<(&'static str, String, String)> {
        let all = self.masquerades();
        all.iter().map(|(one, _)| (one.on, one.ours.clone(), one.foreign.clone())).collect()
    }

    /// Releases one holder; after the last, the next foreign name requested for this type applies.
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
