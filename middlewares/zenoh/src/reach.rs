//! Who can connect to a session. Anybody who can may call services and write ports.

use zenoh::Config;

/// What lets anybody connect, as a sentence that names the endpoint or the setting.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Open(pub(crate) String);

/// What in the configuration lets strangers connect: a listener reachable from other machines
/// without authentication, or scouting for anybody on the network.
pub(crate) fn open_to_all(config: &Config) -> Option<Open> {
    let get = |key: &str| {
        let text = config.get_json(key).ok()?;
        serde_json::from_str::<serde_json::Value>(&text).ok()
    };
    let is_true = |key: &str| get(key).is_some_and(|value| value == true);
    // Certificates on both sides, or user name and password over an encrypted link.
    let named = is_true("transport/link/tls/enable_mtls");
    let password = get("transport/auth/usrpwd/dictionary_file").is_some_and(|file| !file.is_null());
    let safe = |endpoint: &str| {
        let (protocol, address) = endpoint.split_once('/').unwrap_or((endpoint, ""));
        match protocol {
            "unixsock-stream" | "unixpipe" => true,
            "tls" | "quic" => is_here(address) || named || password,
            _ => is_here(address),
        }
    };
    let mut endpoints = Vec::new();
    endpoints_of(&get("listen/endpoints").unwrap_or_default(), &mut endpoints);
    if let Some(open) = endpoints.into_iter().find(|endpoint| !safe(endpoint)) {
        return Some(Open(format!("`{open}` lets in whoever reaches it")));
    }
    let searches = is_true("scouting/multicast/enabled")
        && get("scouting/multicast/interface").is_none_or(|interface| interface != "lo");
    searches.then(|| Open("scouting/multicast connects with whoever is on the network".to_owned()))
}

/// Endpoints are a list, or one list per mode.
fn endpoints_of(value: &serde_json::Value, out: &mut Vec<String>) {
    match value {
        serde_json::Value::String(endpoint) => out.push(endpoint.clone()),
        serde_json::Value::Array(all) => all.iter().for_each(|one| endpoints_of(one, out)),
        serde_json::Value::Object(modes) => modes.values().for_each(|one| endpoints_of(one, out)),
        _ => {}
    }
}

/// Whether an address is reachable from this machine only.
fn is_here(address: &str) -> bool {
    let address = address.split(['?', '#']).next().unwrap_or_default();
    let host = address.rsplit_once(':').map_or(address, |(host, _)| host);
    let host = host.trim_start_matches('[').trim_end_matches(']');
    let ip: Option<std::net::IpAddr> = host.parse().ok();
    host == "localhost" || ip.is_some_and(|ip| ip.is_loopback())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn open(settings: &[(&str, &str)]) -> bool {
        let mut config = Config::default();
        for (key, value) in [("listen/endpoints", "[]"), ("scouting/multicast/enabled", "false")]
            .iter()
            .chain(settings)
        {
            config.insert_json5(key, value).unwrap();
        }
        open_to_all(&config).is_some()
    }

    #[test]
    fn only_who_is_known_comes_in_from_other_machines() {
        let listen = |endpoint: &str| format!("[\"{endpoint}\"]");
        for here in [
            "tcp/127.0.0.1:1",
            "tcp/[::1]:1",
            "tcp/localhost:1",
            "unixsock-stream//tmp/x",
            "tls/127.1.2.3:1",
            "udp/127.0.0.1:1?rel=0#iface=lo",
        ] {
            assert!(!open(&[("listen/endpoints", &listen(here))]), "{here}");
        }
        for beyond in [
            "tcp/0.0.0.0:7447",
            "tcp/[::]:7447",
            "tcp/192.168.1.7:1",
            "udp/10.0.0.1:1",
            "tls/0.0.0.0:7447",
            "quic/robot:1",
            "tcp/127.0.0.1.example.org:1",
            "ws/0.0.0.0:1",
        ] {
            assert!(open(&[("listen/endpoints", &listen(beyond))]), "{beyond}");
        }
        let mutual = ("transport/link/tls/enable_mtls", "true");
        assert!(!open(&[("listen/endpoints", &listen("tls/0.0.0.0:7447")), mutual]));
        // A single unencrypted endpoint is enough.
        let both = "[\"tls/0.0.0.0:7447\", \"tcp/0.0.0.0:7448\"]";
        assert!(open(&[("listen/endpoints", both), mutual]));
        let modes = "{ router: [\"tcp/[::]:7447\"], peer: [] }";
        assert!(open(&[("listen/endpoints", modes)]));
    }

    #[test]
    fn whoever_is_on_the_network_is_not_looked_for() {
        assert!(open(&[("scouting/multicast/enabled", "true")]));
        let lo = ("scouting/multicast/interface", "\"lo\"");
        assert!(!open(&[("scouting/multicast/enabled", "true"), lo]));
    }
}
