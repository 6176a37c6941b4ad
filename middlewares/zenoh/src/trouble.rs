//! What keeps the session from others.

use genom_middleware::{Address, Obstacle};
use genom_zenoh_doctor::{Examined, Role, examine};
use zenoh::key_expr::OwnedKeyExpr;

use crate::core::Core;
use crate::keys::Token;

pub(crate) fn trouble(core: &Core) -> Vec<Obstacle> {
    let tokens = core.graph().ours(core.name());
    let keys: Vec<_> = tokens.iter().flat_map(|token| used(core, token)).collect();
    examine(&Examined {
        session: core.session(),
        config: core.config(),
        meets: core.meets(),
        keys: &keys,
    })
}

/// The keys of an end: its own, and the one by which others see it.
fn used(core: &Core, token: &Token) -> Vec<(OwnedKeyExpr, Role)> {
    let own = Address::parse(&token.address).and_then(|at| core.keys().of(&at).ok());
    let shown = OwnedKeyExpr::new(core.keys().of_token(token)).ok();
    own.map(|key| (key, token.kind.into()))
        .into_iter()
        .chain(shown.map(|key| (key, Role::Shows)))
        .collect()
}
