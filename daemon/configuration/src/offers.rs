//! Which services of components are offered on which middlewares.

use genom_protocol::STANDARD_SERVICES;
use genom_registry::known;
use serde::{Deserialize, Serialize};

use crate::error::UsageError;
use crate::pattern::matches;

/// Section `[services]`: patterns `BACKEND:COMPONENT/SERVICE`, with `*` for any run of characters;
/// without a backend a pattern applies to all of them. `deny` takes precedence over `allow`.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct Offers {
    /// Patterns of the services that are offered.
    pub allow: Vec<String>,
    /// Patterns of services that are not, even if allowed.
    pub deny: Vec<String>,
}

impl Default for Offers {
    /// By default the supervisor's services (`kill`, `connect_port` ...) are not offered on
    /// middlewares that leave the machine, where no right protects them.
    fn default() -> Self {
        let deny = standard("zenoh").chain(standard("ros2")).collect();
        Self { allow: vec!["*".to_owned()], deny }
    }
}

/// The supervisor's services on a middleware.
fn standard(backend: &str) -> impl Iterator<Item = String> {
    STANDARD_SERVICES.iter().map(move |(service, _)| format!("{backend}:*/{service}"))
}

impl Offers {
    /// Extends the default to middlewares of libraries: who reaches them is not known.
    pub(crate) fn guard(&mut self, plugins: &[&str]) {
        if self.deny == Self::default().deny {
            self.deny.extend(plugins.iter().flat_map(|name| standard(name)));
        }
    }

    /// Checks the form of the patterns.
    pub fn check(&self) -> Result<(), UsageError> {
        for pattern in self.allow.iter().chain(&self.deny) {
            let (backend, rest) = parts(pattern);
            let exists = |name: &str| known().iter().any(|known| known.name == name);
            if backend.is_some_and(|name| !name.contains('*') && !exists(name))
                || rest != "*" && !rest.contains('/')
            {
                return Err(UsageError::Offer(pattern.clone()));
            }
        }
        Ok(())
    }

    /// Whether a service is offered on a middleware.
    pub fn offers(&self, backend: &str, component: &str, service: &str) -> bool {
        let name = format!("{component}/{service}");
        let any = |patterns: &[String]| {
            patterns.iter().any(|pattern| {
                let (on, rest) = parts(pattern);
                on.is_none_or(|on| matches(on, backend)) && matches(rest, &name)
            })
        };
        any(&self.allow) && !any(&self.deny)
    }
}

fn parts(pattern: &str) -> (Option<&str>, &str) {
    pattern.split_once(':').map_or((None, pattern), |(backend, rest)| (Some(backend), rest))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn by_default_what_supervisors_do_stays_on_this_machine() {
        let offers = Offers::default();
        for backend in ["zenoh", "ros2"] {
            assert!(offers.offers(backend, "demo", "goto"));
            for (service, _) in STANDARD_SERVICES {
                assert!(!offers.offers(backend, "demo", service), "{backend} {service}");
                assert!(offers.offers("shm", "demo", service));
            }
        }
    }

    #[test]
    fn a_middleware_of_a_library_is_guarded_unless_the_configuration_says_otherwise() {
        let mut offers = Offers::default();
        offers.guard(&["mine"]);
        assert!(!offers.offers("mine", "demo", "kill") && offers.offers("mine", "demo", "goto"));
        assert!(!offers.offers("zenoh", "demo", "kill"));
        let mut own = Offers { deny: Vec::new(), ..Offers::default() };
        own.guard(&["mine"]);
        assert!(own.offers("mine", "demo", "kill"));
    }

    #[test]
    fn what_is_denied_is_not_allowed_and_wrong_patterns_are_named() {
        let list = |all: &[&str]| all.iter().map(|&one| one.to_owned()).collect::<Vec<_>>();
        let offers = Offers {
            allow: list(&["zenoh:wheels/*", "ros2:*/get_*", "shm:*"]),
            deny: list(&["*/reset"]),
        };
        assert!(offers.offers("zenoh", "wheels", "goto") && !offers.offers("zenoh", "arm", "goto"));
        assert!(offers.offers("ros2", "arm", "get_speed"));
        assert!(!offers.offers("ros2", "arm", "set_speed"));
        assert!(offers.offers("shm", "arm", "x") && !offers.offers("shm", "arm", "reset"));
        assert!(offers.check().is_ok());
        for wrong in ["zenho:*", "demo", "kill"] {
            let offers = Offers { deny: list(&[wrong]), ..Offers::default() };
            assert!(offers.check().unwrap_err().to_string().contains(wrong));
        }
    }
}
