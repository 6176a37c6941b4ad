//! Types and services that masquerade as ROS's own.

use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::sync::{Arc, Mutex, PoisonError, RwLock};

use genom_middleware::{NoForeignName, ServiceKind, ServiceType};
use genom_rosidl::{Library, Manner, MasqueradeError, Ours, TypeName};
use genom_types::DataType;

use crate::names;
use crate::options::Options;
use crate::used::Used;

/// All masquerades, and the definitions against which they are checked.
pub(crate) struct Masquerades {
    /// By full IDL name of a type or service.
    all: RwLock<BTreeMap<String, TypeName>>,
    /// Those from the options, which cannot be removed.
    configured: BTreeSet<String>,
    pub(crate) library: Library,
    /// Those of its types that were used, by name.
    pub(crate) foreign: Mutex<HashMap<TypeName, Arc<Used>>>,
}

impl Masquerades {
    pub(crate) fn new(options: &Options) -> Self {
        let named = options.masquerade.iter();
        let all = named.filter_map(|(ours, name)| Some((ours.clone(), TypeName::parse(name)?)));
        let ament = std::env::var("AMENT_PREFIX_PATH").ok();
        Self {
            all: RwLock::new(all.collect()),
            configured: options.masquerade.keys().cloned().collect(),
            library: Library::with_ament(options.interfaces.clone(), ament.as_deref()),
            foreign: Mutex::default(),
        }
    }

    pub(crate) fn all(&self) -> BTreeMap<String, TypeName> {
        self.all.read().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// Adds a masquerade, unless the options contain another one for the same name.
    pub(crate) fn add(&self, ours: &str, foreign: &str) -> Result<(), NoForeignName> {
        let name = TypeName::parse(foreign).ok_or_else(|| NoForeignName {
            ours: ours.to_owned(),
            foreign: foreign.to_owned(),
            form: "package/msg/Type".into(),
        })?;
        let mut all = self.all.write().unwrap_or_else(PoisonError::into_inner);
        all.entry(ours.to_owned()).or_insert(name);
        Ok(())
    }

    /// Removes a masquerade that was added.
    pub(crate) fn remove(&self, ours: &str) {
        if !self.configured.contains(ours) {
            self.all.write().unwrap_or_else(PoisonError::into_inner).remove(ours);
        }
    }

    /// The message of a port.
    pub(crate) fn message(&self, ty: &DataType) -> Result<TypeName, MasqueradeError> {
        let masquerades = self.all();
        let (table, id) = (ty.table(), ty.id());
        let Some(foreign) = genom_rosidl::masqueraded(table, id, &masquerades) else {
            return Ok(names::message(ty));
        };
        let ours = Ours { masquerades: &masquerades, library: &self.library };
        ours.message((table, id), foreign)?;
        Ok(foreign.clone())
    }

    /// The foreign type of a service, if it masquerades.
    pub(crate) fn service(
        &self,
        ty: &ServiceType,
    ) -> Result<Option<(TypeName, Manner)>, MasqueradeError> {
        let (input, output) = (&ty.input, &ty.output);
        let Some(name) = genom_rosidl::service_of(input.table(), input.id()) else {
            return Ok(None);
        };
        let (masquerades, name) = (self.all(), name.to_string());
        let Some(foreign) = masquerades.get(&name) else { return Ok(None) };
        let ours = Ours { masquerades: &masquerades, library: &self.library };
        let types = ((&**input.table(), input.id()), (&**output.table(), output.id()));
        let manner = match ty.kind {
            ServiceKind::Activity => ours.action(&name, types, foreign)?,
            _ => ours.service(&name, types, foreign)?,
        };
        Ok(Some((foreign.clone(), manner)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_added_is_taken_back_and_what_is_configured_stays() {
        let configured = [("::demo::pose".to_owned(), "geometry_msgs/msg/Pose".to_owned())];
        let masquerade = configured.into();
        let all = Masquerades::new(&Options { masquerade, ..Options::default() });
        all.add("::demo::pose", "geometry_msgs/msg/Twist").unwrap();
        all.add("::demo::speed", "geometry_msgs/msg/Twist").unwrap();
        assert_eq!(all.all().len(), 2);
        all.remove("::demo::speed");
        all.remove("::demo::pose");
        assert_eq!(all.all().keys().collect::<Vec<_>>(), ["::demo::pose"]);
        assert_eq!(all.all()["::demo::pose"].to_string(), "geometry_msgs/msg/Pose");
    }
}
