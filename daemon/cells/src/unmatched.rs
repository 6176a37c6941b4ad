//! Patterns of the configuration that match nothing that runs: a mistake, most likely.

use std::sync::Arc;

use genom_configuration::is_one_of;
use genom_nearest::suggest;
use genom_protocol::routes;
use genom_supervisor::Supervisor;

use crate::blackbox::BlackBoxes;
use crate::cell::Cell;

/// What components have, as `COMPONENT/NAME`.
#[derive(Default)]
struct There {
    ports: Vec<String>,
    services: Vec<String>,
}

impl BlackBoxes {
    /// The patterns that match nothing of this process and these cells, each with what may have
    /// been meant; none as long as nothing is loaded.
    pub async fn unmatched(
        &self,
        supervisor: &Arc<Supervisor>,
        cells: Vec<Arc<Cell>>,
    ) -> Vec<String> {
        let mut there = There::default();
        for hosted in supervisor.components.all() {
            let (name, model) = (&hosted.name, hosted.model());
            let of = |one: &str| format!("{name}/{one}");
            there.ports.extend(model.ports.iter().map(|port| of(&port.name)));
            there.services.extend(model.services.iter().map(|service| of(&service.name)));
        }
        for cell in cells {
            for name in cell.told().components {
                // One that is down says nothing of what it has.
                let Ok(found) = cell.client().ask(&routes::component(&name)).await else {
                    return Vec::new();
                };
                let of = |one: &str| format!("{name}/{one}");
                there.ports.extend(found.ports.iter().map(|port| of(&port.name)));
                there.services.extend(found.services.iter().map(|service| of(&service.name)));
            }
        }
        there.unmatched_of(self)
    }

    /// Logs them, once what the daemon was started with runs.
    pub async fn tell_unmatched(&self, supervisor: &Arc<Supervisor>, cells: Vec<Arc<Cell>>) {
        if self.section().enabled {
            for told in self.unmatched(supervisor, cells).await {
                tracing::warn!("{told}");
            }
        }
    }
}

impl There {
    fn unmatched_of(&self, boxes: &BlackBoxes) -> Vec<String> {
        let section = boxes.section();
        let mut told = Vec::new();
        for (key, patterns, there) in [
            ("ports", &section.ports, &self.ports),
            ("services", &section.services, &self.services),
            ("exceptions", &section.exceptions, &self.services),
        ] {
            let is_matched =
                |one: &String| there.iter().any(|name| is_one_of(std::slice::from_ref(one), name));
            for one in patterns.iter().filter(|one| !is_matched(one)) {
                if self.services.is_empty() || *one == "*" {
                    continue;
                }
                let meant = suggest(one, there.iter().map(String::as_str));
                told.push(format!("blackbox.{key}: `{one}` matches nothing that runs; {meant}"));
            }
        }
        told
    }
}

#[cfg(test)]
mod tests {
    use genom_configuration::BlackBoxSection;

    use super::*;

    #[test]
    fn a_pattern_that_matches_nothing_is_told_with_what_may_be_meant() {
        let patterns = |all: &[&str]| all.iter().map(|&one| one.to_owned()).collect();
        let section = BlackBoxSection {
            ports: patterns(&["demo/positon", "demo/*", "*"]),
            exceptions: patterns(&["demo/goto"]),
            ..BlackBoxSection::default()
        };
        let (ports, services) = (patterns(&["demo/position"]), patterns(&["demo/goto"]));
        let told = There { ports, services }.unmatched_of(&BlackBoxes::new(&section));
        let wanted = "blackbox.ports: `demo/positon` matches nothing that runs; \
                      did you mean `demo/position`?";
        assert_eq!(told, [wanted]);
        assert!(There::default().unmatched_of(&BlackBoxes::new(&section)).is_empty());
    }
}
