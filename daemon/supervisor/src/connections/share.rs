//! Puts what other processes of the daemon are to read or call on shared memory.

use genom_configuration::BackendNames;
use genom_configuration::place::Place;
use genom_description::model::PortDirection;

use super::core::Connections;
use super::elsewhere::SHARED;
use super::find::split;
use super::opening::BindError;

impl Connections {
    /// From now on, what this says is held by another process is looked for on shared memory.
    pub fn look_elsewhere(&self, holds: impl Fn(&str) -> bool + Send + Sync + 'static) {
        self.elsewhere.ask(Box::new(holds));
    }

    /// Puts an out port or a service of this process on shared memory, too, so that another
    /// process of the daemon finds it. One that names a middleware, or is not here, stays as it is.
    ///
    /// # Errors
    /// It cannot be opened there, or a codel does not return; nothing is changed then.
    pub fn share(&self, outlet: &str) -> Result<(), BindError> {
        let Ok(Place { backend: None, address }) = Place::parse(outlet) else { return Ok(()) };
        let Some(hosted) = self.components.get(&address.instance) else { return Ok(()) };
        let ports = &hosted.model().ports;
        let name = split(&address).0;
        let port = ports.find(|one| one.name == name && one.direction == PortDirection::Out);
        let bindings = &hosted.ties.bindings;
        let on = port.map_or_else(|| bindings.component(), |_| bindings.port(name));
        if on.has(SHARED) {
            return Ok(());
        }
        let also: Vec<&str> = on.names().iter().map(String::as_str).chain([SHARED]).collect();
        self.move_to(&hosted, port, &BackendNames::from(also.join("+").as_str()))
    }
}
