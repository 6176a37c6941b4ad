//! Whether `before` and `after` leave an order in which a service can run (genom3.md 7.6).

use genom_description::model::{Ix as _, ServiceIx};

use super::verdict::{Finding, Verdict, verdict};
use crate::codels::small;
use crate::system::System;

/// A service runs after those of its `after`, and before those of its `before`. To run it, all that
/// it comes after must have run, and what these come after; there must be an order of them in which
/// each rule is kept.
pub(super) fn order(system: &System) -> Verdict {
    let mut found = Vec::new();
    for service in 0..small(system.services.len()) {
        let needed = needed(system, service);
        if !has_order(system, &needed) {
            let model = &system.plan.component().services[ServiceIx::new(service.into())];
            let names: Vec<String> =
                needed.iter().map(|needed| system.service_name(*needed)).collect();
            let what = format!(
                "{} can never run: there is no order of {} in which `before` and `after` hold",
                model.name,
                names.join(", ")
            );
            found.push(Finding { what, span: Some(model.span), run: Vec::new() });
        }
    }
    verdict(found)
}

/// Whether a service can run: what it needs can, in some order.
pub(super) fn is_possible(system: &System, service: u16) -> bool {
    has_order(system, &needed(system, service))
}

/// A service and all that have to run before it.
pub(crate) fn needed(system: &System, service: u16) -> Vec<u16> {
    let mut needed = vec![service];
    let mut at = 0;
    while let Some(one) = needed.get(at).copied() {
        for other in &system.services[usize::from(one)].after {
            if !needed.contains(other) {
                needed.push(*other);
            }
        }
        at += 1;
    }
    needed
}

/// Takes away services that can run first, until none is left.
fn has_order(system: &System, needed: &[u16]) -> bool {
    let precedes = |a: u16, b: u16| {
        system.services[usize::from(a)].before.contains(&b)
            || system.services[usize::from(b)].after.contains(&a)
    };
    let mut left = needed.to_vec();
    while !left.is_empty() {
        let first = |one: &u16| left.iter().all(|other| !precedes(*other, *one));
        let Some(at) = left.iter().position(first) else { return false };
        left.remove(at);
    }
    true
}
