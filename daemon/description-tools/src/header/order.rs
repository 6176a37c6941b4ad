//! The order in which types are written: contained types first, as C requires.
//!
//! A struct is contained in itself only through unbounded sequences; there a forward
//! declaration is enough.

use std::collections::HashSet;

use genom_description::c_names::contained;
use genom_types::{Kind, TypeId, TypeTable};

/// A piece of the header.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Step {
    Forward(TypeId),
    Define(TypeId),
}

/// All types but `without`, each after the types it contains, otherwise in order of declaration.
pub(super) fn order(types: &TypeTable, without: &HashSet<TypeId>) -> Vec<Step> {
    let mut steps = Vec::new();
    let mut begun = vec![false; types.len()];
    let mut announced = vec![false; types.len()];
    for (root, _) in types.iter() {
        if without.contains(&root) || !is_written(types, root) {
            continue;
        }
        // An explicit stack: a description may nest deeper than the thread's stack allows.
        let mut stack = vec![(root, false)];
        while let Some((id, ready)) = stack.pop() {
            if ready {
                // Arrays are spelled where they are used; C++ still needs the types of their
                // elements.
                if is_written(types, id) || matches!(types.kind(id), Kind::Array { .. }) {
                    steps.push(Step::Define(id));
                }
                continue;
            }
            if std::mem::replace(&mut begun[id.index()], true) {
                continue;
            }
            stack.push((id, true));
            if let Kind::Sequence { element, bound: None } = types.kind(id)
                && matches!(types.kind(*element), Kind::Struct { .. } | Kind::Union { .. })
            {
                if !std::mem::replace(&mut announced[element.index()], true) {
                    steps.push(Step::Forward(*element));
                }
                continue;
            }
            let parts = contained(types, id);
            stack.extend(parts.into_iter().rev().map(|part| (part, false)));
        }
    }
    steps
}

/// Whether the type has a definition in the header; others are spelled where they are used.
fn is_written(types: &TypeTable, id: TypeId) -> bool {
    let kind = types.kind(id);
    let template = matches!(kind, Kind::Sequence { .. } | Kind::Optional { .. });
    template || kind.name().is_some() && !matches!(kind, Kind::Forward { .. })
}
