//! Native data: pointers to what only the codels of one library know.

use std::sync::Arc;

use genom_description::model::Component;
use genom_types::{DataType, Kind, TypeTable};

/// The first native type in the IDS, or in the local variables of a service, of a component.
pub(super) fn inside(model: &Component, types: &Arc<TypeTable>) -> Option<String> {
    let locals = model.services.iter().map(|service| service.local);
    let mut all = model.ids.into_iter().chain(locals);
    all.find_map(|ty| native(&DataType::new(types, ty).ok()?))
}

fn native(ty: &DataType) -> Option<String> {
    // What holds no pointer at all is not searched.
    if ty.is_fixed_size() {
        return None;
    }
    if let Kind::Native { name } = ty.kind() {
        return Some(name.to_string());
    }
    let element = ty.element().and_then(|element| native(&element));
    element.or_else(|| (0..ty.member_count()).find_map(|rank| native(&ty.member(rank)?)))
}
