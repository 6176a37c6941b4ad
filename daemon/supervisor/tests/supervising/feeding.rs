//! Values that the supervisor publishes to in ports.

use std::sync::Arc;

use genom_configuration::BackendNames;
use genom_ports::PortKey;
use genom_supervisor::LoadRequest;
use genom_supervisor::connections::feed::FeedError;
use serde_json::json;

use crate::own::Own;
use crate::support::Scratch;

pub(crate) const TAKER: &str = "
typedef double level;
component taker { version \"1\"; lang \"c\"; task main;
  port in level value;
  activity take() { task main; codel<start> taker_take(in value) yield ether; };
};
";

pub(crate) const CODELS: &str = "
genom_event
taker_take(const taker_value *value, const genom_context self)
{
  (void)value;
  (void)self;
  return taker_ether;
}
";

#[test]
fn both_ends_of_a_port_that_is_fed_have_the_quality_that_is_asked_of_it() {
    let scratch = Scratch::new();
    let supervisor = scratch.supervisor();
    let own = Own::new();
    supervisor.backends.add(Arc::clone(&own) as _);
    let request = LoadRequest {
        library: scratch.component("taker", TAKER, CODELS),
        backend: Some(BackendNames::one("own")),
        qos: serde_json::from_value(json!({ "ports": { "value": { "reliable": false } } }))
            .unwrap(),
        ..LoadRequest::default()
    };
    let taker = supervisor.load(&request).unwrap_or_else(|error| panic!("{error}"));
    let rank = taker.model().ports.find(|port| port.name == "value").unwrap();
    let fill = |value: &mut genom_types::Record| Ok::<_, FeedError>(value.merge_json(&0.5.into())?);
    supervisor.connections.feed(&taker, &PortKey::new(rank, None), fill, |_| ()).unwrap();
    let opened = own.opened("taker/value");
    let ends: Vec<_> = opened.iter().map(|(end, _, quality)| (*end, quality.reliable)).collect();
    assert_eq!(ends, [("publisher", Some(false)), ("subscription", Some(false))]);
    drop(taker);
    assert!(supervisor.unload_all().is_empty());
}
