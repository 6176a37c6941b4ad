//! Settings by which a session finds nobody.

use std::path::Path;

use genom_middleware::Obstacle;
use zenoh::Config;

use crate::settings::{endpoints, get, locator, text};

/// Where interfaces of this machine are.
const INTERFACES: &str = "/sys/class/net";

/// Flag of an interface that is up (`IFF_UP`).
const UP: u32 = 1;

/// What keeps a session from finding others at all. `meets` says whether it has another way.
pub(crate) fn alone(config: &Config, meets: bool) -> Vec<Obstacle> {
    if get(config, "scouting/multicast/enabled") != true {
        return nobody(config, meets).into_iter().collect();
    }
    // Names or addresses, with commas between them.
    let interfaces = text(config, "scouting/multicast/interface").unwrap_or_default();
    let names = interfaces.split(',').map(str::trim).filter(|name| {
        !name.is_empty() && *name != "auto" && name.parse::<std::net::IpAddr>().is_err()
    });
    names.filter_map(down).collect()
}

/// Without scouting: nobody to connect to, and no endpoint that others could know.
fn nobody(config: &Config, meets: bool) -> Option<Obstacle> {
    let known = |endpoint: &String| !locator(endpoint).ends_with(":0");
    let reached = endpoints(config, "listen").iter().any(known);
    if meets || reached || !endpoints(config, "connect").is_empty() {
        return None;
    }
    Some(Obstacle {
        what: "it finds nobody, and nobody finds it: scouting/multicast/enabled is false, \
               connect/endpoints is empty, and it listens on no endpoint that others could know"
            .to_owned(),
        fix:
            "an endpoint in `connect`, or one in `listen` with a port for others to connect to; or \
              scouting"
                .to_owned(),
    })
}

/// Why scouting does not work on an interface.
fn down(name: &str) -> Option<Obstacle> {
    let place = Path::new(INTERFACES).join(name);
    let flags = std::fs::read_to_string(place.join("flags"));
    let why = match flags {
        Err(_) => "this machine has no such interface",
        Ok(flags) => {
            let flags = u32::from_str_radix(flags.trim().trim_start_matches("0x"), 16);
            if flags.is_ok_and(|flags| flags & UP != 0) {
                return None;
            }
            "it is down"
        }
    };
    Some(Obstacle {
        what: format!("scouting looks for others on {name} (scouting/multicast/interface): {why}"),
        fix: format!("bring {name} up, or name another interface, or `auto`"),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found(settings: &[(&str, &str)], meets: bool) -> Vec<String> {
        let mut config = Config::default();
        for (key, value) in settings {
            config.insert_json5(key, value).unwrap();
        }
        alone(&config, meets).into_iter().map(|one| one.what).collect()
    }

    const OFF: (&str, &str) = ("scouting/multicast/enabled", "false");

    #[test]
    fn a_session_that_finds_nobody_and_that_nobody_finds_is_told() {
        // By default a peer listens on a port that nobody knows.
        let told = found(&[OFF], false);
        assert!(told[0].starts_with("it finds nobody, and nobody finds it"), "{told:?}");
        assert!(found(&[OFF], true).is_empty(), "it meets others elsewhere");
        for (key, value) in [
            ("connect/endpoints", "[\"tcp/10.0.0.1:7447\"]"),
            ("listen/endpoints", "[\"tcp/10.0.0.1:7447\"]"),
            ("mode", "\"router\""),
        ] {
            assert!(found(&[OFF, (key, value)], false).is_empty(), "{key}");
        }
    }

    #[test]
    fn an_interface_that_scouting_cannot_use_is_named() {
        let on = |name| {
            found(
                &[("scouting/multicast/enabled", "true"), ("scouting/multicast/interface", name)],
                false,
            )
        };
        let told = on("\"lo,nosuch0\"");
        assert_eq!(
            told,
            ["scouting looks for others on nosuch0 (scouting/multicast/interface): this machine \
              has no such interface"]
        );
        assert!(on("\"auto\"").is_empty());
        assert!(on("\"127.0.0.1\"").is_empty());
    }
}
