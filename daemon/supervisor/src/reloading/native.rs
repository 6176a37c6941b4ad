//! Native data: pointers to what only the codels of one library know.

use std::sync::Arc;

use genom_description::model::Component;
use genom_types::{DataType, TypeTable};

use crate::components::native_in;

/// The first native type in the IDS, or in the local variables of a service, of a component.
pub(super) fn inside(model: &Component, types: &Arc<TypeTable>) -> Option<String> {
    let ids = model.ids.and_then(|ty| native_in(&DataType::new(types, ty).ok()?));
    ids.or_else(|| in_locals(model, types))
}

/// The same of local variables only.
pub(super) fn in_locals(model: &Component, types: &Arc<TypeTable>) -> Option<String> {
    let mut locals = model.services.iter().map(|service| service.local);
    locals.find_map(|ty| native_in(&DataType::new(types, ty).ok()?))
}
