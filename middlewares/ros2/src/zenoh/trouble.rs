//! What keeps the session from others.

use genom_middleware::Obstacle;
use genom_zenoh_doctor::{Examined, Role, examine};
use zenoh::key_expr::OwnedKeyExpr;

use super::core::Core;
use super::keys;
use crate::rmw::Wanted;

pub(crate) fn trouble(core: &Core) -> Vec<Obstacle> {
    let ends = core.graph.all_ours();
    let keys: Vec<_> = ends.iter().filter_map(|end| used(core, end)).collect();
    examine(&Examined { session: core.session(), config: &core.config, meets: false, keys: &keys })
}

fn used(core: &Core, end: &Wanted) -> Option<(OwnedKeyExpr, Role)> {
    Some((keys::of(core.domain, &end.of).ok()?, end.kind.into()))
}
