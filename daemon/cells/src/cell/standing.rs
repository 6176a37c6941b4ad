//! How its process stands, for those who watch the components in it.

use std::collections::BTreeSet;

use genom_configuration::Deployment;
use genom_middleware::Health;
use genom_protocol::CellState;

use super::Cell;
use super::fall::Fall;

/// How the process of a cell stands.
pub(crate) struct Standing {
    /// Good, or ended.
    pub(crate) health: Health,
    /// That in words.
    pub(crate) message: String,
    /// Figures, by their names.
    pub(crate) values: Vec<(String, String)>,
    /// What is in it, or was when it ended.
    pub(crate) held: Vec<Held>,
}

/// A component in a cell.
#[derive(Debug, PartialEq, Eq)]
pub(crate) struct Held {
    /// Its instance.
    pub(crate) name: String,
    /// The middlewares of its services and ports.
    pub(crate) on: BTreeSet<String>,
}

impl Cell {
    /// Nothing while its first process begins, or another one because somebody asked for that.
    /// That it fell is told once at least, also where the next process runs already.
    pub(crate) fn standing(&self) -> Option<Standing> {
        let phase = *self.phase.borrow();
        let usual = self.setup.config.backend.as_str();
        let (pid, starts, ended, lost) = self.with(|state| {
            let lost = (state.fall != Fall::None).then(|| held(&state.held, usual));
            state.fall = state.fall.and_told();
            (state.pid, state.starts, state.last_end.clone(), lost)
        });
        let values = [
            ("process", pid.map(|pid| pid.to_string())),
            ("starts", Some(starts.to_string())),
            ("last end", ended.clone()),
        ];
        let told = |(name, value): (&str, Option<String>)| Some((name.to_owned(), value?));
        let values = values.into_iter().filter_map(told).collect();
        if let Some(held) = lost {
            let then = match phase {
                CellState::Failed => {
                    format!("`genomctl cells --restart {}` starts another one", self.name)
                }
                CellState::Running => "another one runs".to_owned(),
                _ => "another one is started".to_owned(),
            };
            let message = format!("its process ended: {}; {then}", ended.unwrap_or_default());
            return Some(Standing { health: Health::Ended, message, values, held });
        }
        (phase == CellState::Running).then(|| Standing {
            health: Health::Good,
            message: "its process runs".to_owned(),
            values,
            held: held(&self.written(), usual),
        })
    }
}

/// The components of a deployment; those that name no middleware are on the usual one.
fn held(deployment: &Deployment, usual: &str) -> Vec<Held> {
    let of = deployment.component.iter().map(|one| {
        let own = one.backend.as_ref().map_or(&[][..], |names| names.names());
        let ports = one.ports.values().flat_map(|names| names.names());
        let mut on: BTreeSet<String> = own.iter().chain(ports).cloned().collect();
        if own.is_empty() {
            on.insert(usual.to_owned());
        }
        Held { name: one.instance(), on }
    });
    of.collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_component_is_on_the_middlewares_of_its_services_and_of_its_ports() {
        let text = r#"
            [[component]]
            library = "demo.so"

            [[component]]
            library = "demo.so"
            name = "arm"
            backend = "zenoh"
            ports.position = "ros2+shm"
        "#;
        let config = genom_configuration::Config::of_text("robot.toml".as_ref(), text).unwrap();
        let deployment = Deployment { component: config.component, ..Deployment::default() };
        let of = |name: &str, on: &[&str]| Held {
            name: name.to_owned(),
            on: on.iter().map(|&name| name.to_owned()).collect(),
        };
        let wanted = [of("demo", &["local"]), of("arm", &["ros2", "shm", "zenoh"])];
        assert_eq!(held(&deployment, "local"), wanted);
    }
}
