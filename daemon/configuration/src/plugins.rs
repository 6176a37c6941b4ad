//! Middlewares in libraries of their own: which one `--backend` and the configuration mean.

use std::collections::BTreeMap;
use std::path::Path;

use genom_registry::{BackendError, LIBRARY, known};
use toml::{Table, Value};

use crate::gateways::GatewaysSection;
use crate::offers::Offers;

/// A section `[backends.NAME]` with the path of its library relative to the file that it is in.
pub(crate) fn anchored(section: &Table, file: &Path) -> Table {
    let mut section = section.clone();
    if let Some(Value::String(library)) = section.get_mut(LIBRARY)
        && let Some(base) = file.parent()
    {
        *library = base.join(&*library).to_string_lossy().into_owned();
    }
    section
}

/// Finds the libraries of middlewares that a configuration uses. Writes their paths into its
/// sections, for the processes that run by it, too, gives them gateways, and keeps the services of
/// supervisors off them, unless the configuration says otherwise.
pub(crate) fn find(
    used: &[String],
    sections: &mut BTreeMap<String, Table>,
    gateways: &mut GatewaysSection,
    services: &mut Offers,
) -> Result<(), BackendError> {
    for name in used {
        genom_registry::named(name, sections.get(name))?;
    }
    let by_default = gateways.of == GatewaysSection::default().of;
    let mut names = Vec::new();
    for (known, path) in known().iter().filter_map(|known| Some((known, known.library()?))) {
        let section = sections.entry(known.name.to_owned()).or_default();
        let path = Value::String(path.to_string_lossy().into_owned());
        section.insert(LIBRARY.to_owned(), path);
        names.push(known.name);
        if by_default && known.gateway {
            gateways.of.push(known.name.to_owned());
        }
    }
    services.guard(&names);
    Ok(())
}
