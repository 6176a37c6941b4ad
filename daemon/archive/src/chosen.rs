//! Which in ports take the samples of a recording.

use std::collections::BTreeMap;

use genom_cells::kept::Voice;
use genom_doors::Own;
use genom_protocol::{Address, PortParameters, routes};
use genom_recording::{inport, same_type};

/// The in ports that take samples of a recording, by its channels; and what none takes, with the
/// reason.
pub async fn choose(own: &Own, voices: Vec<Voice>) -> (BTreeMap<u16, String>, Vec<String>) {
    let query = PortParameters { values: Some(false) };
    let known = own.read(&routes::ports().with(&query)).await;
    let (mut chosen, mut left_out) = (BTreeMap::new(), Vec::new());
    for Voice { channel, topic, definition } in voices {
        let topic = topic.trim_matches('/');
        let address = topic.parse::<Address>().ok();
        let port = known.as_ref().zip(address.as_ref());
        let Some((address, port)) =
            address.as_ref().zip(port.and_then(|(all, at)| inport(all, at)))
        else {
            left_out.push(format!("{topic} is no in port here"));
            continue;
        };
        if let Some(other) = port.connected.as_ref().filter(|other| *other != topic) {
            left_out.push(format!("{topic} reads {other}"));
            continue;
        }
        let ty = own.read(&routes::port_type(&address.component, &address.port)).await;
        let now = ty.and_then(|ty| ty.message.definition).unwrap_or_default();
        if same_type(now.as_bytes(), &definition) {
            chosen.insert(channel, topic.to_owned());
        } else {
            left_out.push(format!("{topic} has another type now"));
        }
    }
    (chosen, left_out)
}
