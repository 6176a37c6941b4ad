//! Publishers of out ports: opened at load, and by codels for elements of multiple ports.

use std::sync::Arc;

use genom_description::model::PortDirection;
use genom_middleware::{Address, Middleware, OpenError, Publisher};
use genom_runtime::body::{Body, Opener};
use genom_runtime::plan::Plan;

use super::Wires;

/// Opens every out port of an instance that does not run yet.
pub(crate) fn bind(
    body: &dyn Body,
    plan: &Arc<Plan>,
    instance: &str,
    middleware: &Arc<dyn Middleware>,
    wires: &Arc<Wires>,
) -> Result<(), OpenError> {
    for (index, port) in plan.component().ports.iter().enumerate() {
        if port.direction == PortDirection::Out
            && !port.multiple
            && let Some(ty) = plan.port_type(index)
        {
            let address = Address::new(instance, port.name.as_str());
            body.bind_out(index, None, Some(middleware.publisher(&address, ty)?));
        }
    }
    body.set_opener(Box::new(ElementOpener {
        instance: instance.to_owned(),
        plan: Arc::clone(plan),
        middleware: Arc::clone(middleware),
        wires: Arc::clone(wires),
    }));
    Ok(())
}

/// Opens elements of multiple out ports under `<instance>/<port>/<element>` (genom3.md 7.8).
struct ElementOpener {
    instance: String,
    plan: Arc<Plan>,
    middleware: Arc<dyn Middleware>,
    wires: Arc<Wires>,
}

impl Opener for ElementOpener {
    fn open(&self, port: usize, element: &str) -> Result<Box<dyn Publisher>, String> {
        let known = self.plan.component().ports.get(port).zip(self.plan.port_type(port));
        let Some((model, ty)) = known else {
            return Err(format!("{} has no port number {port}", self.instance));
        };
        let name = &model.name;
        if element.is_empty() || element.contains('/') {
            return Err(format!("`{element}` cannot name an element of {name}"));
        }
        let address = Address::new(self.instance.as_str(), format!("{name}/{element}"));
        let publisher =
            self.middleware.publisher(&address, ty).map_err(|error| error.to_string())?;
        self.wires.opened(port, element);
        Ok(publisher)
    }
}
