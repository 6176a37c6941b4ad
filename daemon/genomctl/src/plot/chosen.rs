//! Which numbers are plotted: `COMPONENT/PORT` for all of a port, `COMPONENT/PORT.MEMBER` for one.

use genom_protocol::{Address, Port, PortParameters, routes};
use genom_types::DataType;

use super::types;
use crate::failure::Failure;
use crate::session::Session;

/// A port of which numbers are plotted.
pub(crate) struct Chosen {
    pub(super) address: Address,
    /// Its documentation, which has the units.
    pub(super) doc: Option<String>,
    pub(super) ty: DataType,
    /// Members as they were named; all numbers if none was.
    pub(super) members: Vec<String>,
}

/// Finds the ports that are named.
pub(crate) async fn choose(session: &Session, given: &[String]) -> Result<Vec<Chosen>, Failure> {
    let query = PortParameters { values: Some(false) };
    let ports = session.ask(routes::ports().with(&query)).await?.content.ports;
    let mut chosen: Vec<Chosen> = Vec::new();
    for text in given {
        let (address, member, doc) = split(text, &ports)?;
        if let Some(known) = chosen.iter_mut().find(|one| one.address == address) {
            known.members.extend(member);
            continue;
        }
        let route = routes::port_type(&address.component, &address.port);
        let described = session.ask(route).await?.content;
        let Some(ty) = types::read(&described) else {
            let message =
                format!("{address}: values of its type {} are not recorded", described.ty);
            return Err(Failure::refused("plot", message));
        };
        chosen.push(Chosen { address, doc, ty, members: member.into_iter().collect() });
    }
    Ok(chosen)
}

/// A port and its member. Names of elements may have dots: the longest address of a port counts.
fn split(text: &str, ports: &[Port]) -> Result<(Address, Option<String>, Option<String>), Failure> {
    let rest = |port: &Port| {
        let rest = text.strip_prefix(port.address.as_str())?;
        match rest.strip_prefix('.') {
            Some(member) => Some(Some(member.to_owned())),
            None => rest.is_empty().then_some(None),
        }
    };
    let found = ports.iter().filter_map(|port| Some((port, rest(port)?)));
    let found = found.max_by_key(|(port, _)| port.address.len());
    if let Some((port, member)) = found
        && let Ok(address) = port.address.parse()
    {
        return Ok((address, member, port.doc.clone()));
    }
    // The daemon says what is wrong with the name.
    let name = text.split_once('/').map_or(text, |(component, rest)| {
        let end = rest.find('.').map_or(text.len(), |dot| component.len() + 1 + dot);
        &text[..end]
    });
    let address: Address = name
        .parse()
        .map_err(|_| Failure::usage(format!("`{text}` is no COMPONENT/PORT[.MEMBER]"), HELP))?;
    let member = text.strip_prefix(name).and_then(|rest| rest.strip_prefix('.'));
    Ok((address, member.map(str::to_owned), None))
}

const HELP: &str = "for instance demo/position.velocity; `genomctl ports` lists the ports";

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    fn port(address: &str) -> Port {
        let port = json!({
            "address": address, "name": "x", "direction": "out", "multiple": false,
            "type": "double", "backend": "shm", "doc": "m",
        });
        serde_json::from_value(port).unwrap()
    }

    #[test]
    fn a_member_follows_the_longest_address_of_a_port() {
        let ports = [port("demo/position"), port("cam/images/left"), port("cam/images/left.raw")];
        for (text, address, member) in [
            ("demo/position", "demo/position", None),
            ("demo/position.pose.x", "demo/position", Some("pose.x")),
            ("cam/images/left.width", "cam/images/left", Some("width")),
            ("cam/images/left.raw.width", "cam/images/left.raw", Some("width")),
            ("cam/images/left.raw", "cam/images/left.raw", None),
            ("demo/other.x", "demo/other", Some("x")),
        ] {
            let (found, chosen, _) = split(text, &ports).unwrap();
            assert_eq!(
                (found.to_string().as_str(), chosen.as_deref()),
                (address, member),
                "{text}"
            );
        }
        for text in ["demo", "", "demo/", "/x.y"] {
            assert!(split(text, &ports).is_err(), "{text}");
        }
    }
}
