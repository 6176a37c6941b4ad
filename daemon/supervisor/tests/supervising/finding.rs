//! How what a connection asks for is found on a middleware.

use std::sync::Arc;

use genom_configuration::BackendNames;
use genom_middleware::{Address, PortSpec, Ports as _};
use genom_supervisor::LoadRequest;
use genom_supervisor::connections::{ConnectError, Patience, Wanted};

use crate::feeding::{CODELS, TAKER};
use crate::own::Own;
use crate::support::Scratch;

#[test]
fn a_connection_asks_for_its_address_and_lists_all_others_only_to_suggest_one() {
    let scratch = Scratch::new();
    let supervisor = scratch.supervisor();
    let own = Own::far();
    supervisor.backends.add(Arc::clone(&own) as _);
    let request = LoadRequest {
        library: scratch.component("taker", TAKER, CODELS),
        backend: Some(BackendNames::one("own")),
        ..LoadRequest::default()
    };
    let taker = supervisor.load(&request).unwrap_or_else(|error| panic!("{error}"));
    let rank = taker.model().ports.find(|port| port.name == "value").unwrap();
    let ty = taker.port_type(rank).unwrap();
    let giver = Address::new("giver", "level");
    let writer = own.publisher(&PortSpec::new(&giver, ty)).unwrap();
    let connect = |outport: &str| {
        supervisor.connections.connect(&Wanted {
            inport: "taker/value".to_owned(),
            kind: None,
            outport: outport.to_owned(),
            policy: None,
            over: None,
            wait: false,
            patience: Patience::None,
        })
    };
    let before = own.listed();
    connect("giver/level").unwrap();
    assert_eq!(own.listed(), before);
    let refused = connect("giver/leve").unwrap_err();
    let ConnectError::NoSuchOutport { message, help, .. } = refused else {
        panic!("refused for another reason: {refused}")
    };
    assert_eq!(message, "nobody publishes giver/leve on own");
    assert!(help.contains("`giver/level`"), "{help}");
    assert_eq!(own.listed(), before + 1);
    drop((writer, taker));
    assert!(supervisor.unload_all().is_empty());
}
