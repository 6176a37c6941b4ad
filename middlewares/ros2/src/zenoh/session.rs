//! The session's configuration: what `rmw_zenoh_cpp` uses, with the variables by which ROS users
//! change it.

use std::net::IpAddr;
use std::path::Path;

use genom_zenoh_doctor::plain;
use serde_json::json;
use zenoh::Config;

use crate::error::ParticipantError;
use crate::options::{Networks, Options, OptionsError};

/// Where the router of a machine is.
const ROUTER: &str = "tcp/localhost:7447";

/// Port of routers.
const PORT: u16 = 7447;

/// Time in milliseconds after which a session that is silent counts as gone.
const LEASE: u32 = 60_000;

/// How much longer than the largest sample a message may be, in bytes.
const MARGIN: u64 = 1 << 20;

/// Configurations of the two sessions.
#[derive(Debug)]
pub(crate) struct Settings {
    pub(crate) session: Config,
    /// Of the router, if this process may run one.
    pub(crate) router: Option<Config>,
}

fn set(config: &mut Config, key: &str, value: &serde_json::Value) -> Result<(), OptionsError> {
    config
        .insert_json5(key, &value.to_string())
        .map_err(|why| OptionsError::Zenoh { key: key.to_owned(), why: why.to_string() })
}

/// What is the same in both, and is not zenoh's default.
fn common(config: &mut Config, greatest_sample: u32) -> Result<(), OptionsError> {
    // Longer ones are left out while they arrive, without a word: those a little too long arrive,
    // and are refused with one.
    let longest = u64::from(greatest_sample) + MARGIN;
    for (key, value) in [
        ("scouting/multicast/enabled", json!(false)),
        ("timestamping/enabled", json!({ "router": true, "peer": true, "client": true })),
        ("transport/link/tx/lease", json!(LEASE)),
        ("queries_default_timeout", json!(600_000)),
        ("transport/link/rx/max_message_size", json!(longest)),
    ] {
        set(config, key, &value)?;
    }
    Ok(())
}

fn read(variable: &'static str, file: &str) -> Result<Config, OptionsError> {
    Config::from_file(Path::new(file)).map_err(|why| OptionsError::Zenoh {
        key: format!("{variable}={file}"),
        why: genom_zenoh_doctor::mistake(&why.to_string()),
    })
}

impl Settings {
    /// From the options; what they leave open comes from the environment.
    pub(crate) fn of(options: &Options, networks: &Networks) -> Result<Self, OptionsError> {
        Self::by(options, networks, |name| std::env::var(name).ok())
    }

    fn by(
        options: &Options,
        networks: &Networks,
        variable: impl Fn(&str) -> Option<String>,
    ) -> Result<Self, OptionsError> {
        let (greatest, options) = (options.greatest_sample, &options.zenoh);
        let variable = |name: &str| variable(name).filter(|value| !value.is_empty());
        let mut session = match variable("ZENOH_SESSION_CONFIG_URI") {
            Some(file) => read("ZENOH_SESSION_CONFIG_URI", &file)?,
            None => {
                let mut config = Config::default();
                common(&mut config, greatest)?;
                set(&mut config, "mode", &json!("peer"))?;
                set(&mut config, "connect/endpoints", &json!([ROUTER]))?;
                set(&mut config, "listen/endpoints", &json!(["tcp/localhost:0"]))?;
                let target = json!({ "router": ["router", "peer"], "peer": ["router"] });
                set(&mut config, "scouting/gossip/target", &target)?;
                config
            }
        };
        for one in variable("ZENOH_CONFIG_OVERRIDE").iter().flat_map(|all| all.split(';')) {
            if one.trim().is_empty() {
                continue;
            }
            let wrong = |why: String| OptionsError::Zenoh {
                key: format!("ZENOH_CONFIG_OVERRIDE: {one}"),
                why,
            };
            let (key, value) = one
                .split_once('=')
                .ok_or_else(|| wrong("write key/path=value, with ; between several".to_owned()))?;
            let set = session.insert_json5(key.trim(), value.trim());
            set.map_err(|why| wrong(why.to_string()))?;
        }
        if let Some(connect) = &options.connect {
            set(&mut session, "connect/endpoints", &json!(connect))?;
        }
        if let Some(listen) = &options.listen {
            set(&mut session, "listen/endpoints", &json!(listen))?;
        }
        // What late readers get has times.
        let timestamping = json!({ "router": true, "peer": true, "client": true });
        set(&mut session, "timestamping/enabled", &timestamping)?;
        let router = match variable("ZENOH_ROUTER_CONFIG_URI") {
            _ if !options.router => None,
            Some(file) => Some(read("ZENOH_ROUTER_CONFIG_URI", &file)?),
            None => match &options.connect {
                Some(connect) => {
                    connect.first().filter(|to| is_here(to)).cloned().map(|to| vec![to])
                }
                None => Some(listened(networks)),
            }
            .map(|listen| {
                let mut config = Config::default();
                common(&mut config, greatest)?;
                set(&mut config, "listen/endpoints", &json!(listen))?;
                Ok(config)
            })
            .transpose()?,
        };
        let router = router
            .map(|mut config| {
                set(&mut config, "mode", &json!("router"))?;
                // It is for another process to be the router where that fails.
                set(&mut config, "listen/timeout_ms", &json!(0))?;
                set(&mut config, "listen/exit_on_failure", &json!(true))?;
                Ok(config)
            })
            .transpose()?;
        Ok(Self { session, router })
    }
}

/// Where a router of ours listens, by the networks that may be used.
fn listened(networks: &Networks) -> Vec<String> {
    let at = |address: &IpAddr| match address {
        IpAddr::V4(address) => format!("tcp/{address}:{PORT}"),
        IpAddr::V6(address) => format!("tcp/[{address}]:{PORT}"),
    };
    let here = IpAddr::from([127, 0, 0, 1]);
    match networks {
        Networks::All => vec![format!("tcp/[::]:{PORT}")],
        Networks::Loopback => vec![at(&here)],
        Networks::Only(addresses) => {
            let others = addresses.iter().filter(|address| **address != here);
            [here].iter().chain(others).map(at).collect()
        }
    }
}

/// Whether an endpoint is on this machine.
fn is_here(endpoint: &str) -> bool {
    let (protocol, address) = endpoint.split_once('/').unwrap_or((endpoint, ""));
    let address = address.split(['?', '#']).next().unwrap_or_default();
    let host = address.rsplit_once(':').map_or(address, |(host, _)| host);
    let host = host.trim_start_matches('[').trim_end_matches(']');
    let loopback = || host.parse().is_ok_and(|ip: IpAddr| ip.is_loopback());
    protocol == "unixsock-stream" || host == "localhost" || loopback()
}

/// Opens a session on a thread of its own, since zenoh refuses some calls within a single-threaded
/// tokio runtime.
pub(crate) fn open(config: Config) -> Result<zenoh::Session, ParticipantError> {
    use zenoh::Wait as _;
    let opened = apart(|| zenoh::open(config).wait().map_err(|error| plain(&error.to_string())));
    let opened = opened.unwrap_or_else(|| Err("it panicked; see standard error".to_owned()));
    opened.map_err(ParticipantError::Zenoh)
}

/// Runs `run` on a separate thread.
pub(crate) fn apart<R: Send>(run: impl FnOnce() -> R + Send) -> Option<R> {
    std::thread::scope(|scope| scope.spawn(run).join().ok())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::options::ZenohOptions;

    fn by(zenoh: &ZenohOptions, variables: &[(&str, &str)]) -> Result<Settings, OptionsError> {
        let options = Options { zenoh: zenoh.clone(), ..Options::default() };
        Settings::by(&options, &Networks::Loopback, |name| {
            variables.iter().find(|(other, _)| *other == name).map(|(_, value)| (*value).to_owned())
        })
    }

    fn get(config: &Config, key: &str) -> serde_json::Value {
        serde_json::from_str(&config.get_json(key).unwrap()).unwrap()
    }

    #[test]
    fn a_session_is_that_of_rmw_zenoh_and_stays_on_this_machine() {
        let settings = by(&ZenohOptions::default(), &[]).unwrap();
        assert_eq!(get(&settings.session, "mode"), "peer");
        assert_eq!(get(&settings.session, "connect/endpoints"), json!([ROUTER]));
        assert_eq!(get(&settings.session, "listen/endpoints"), json!(["tcp/localhost:0"]));
        assert_eq!(get(&settings.session, "scouting/multicast/enabled"), false);
        let router = settings.router.unwrap();
        assert_eq!(get(&router, "mode"), "router");
        assert_eq!(get(&router, "listen/endpoints"), json!(["tcp/127.0.0.1:7447"]));
        for config in [&settings.session, &router] {
            assert_eq!(get(config, "transport/link/rx/max_message_size"), 65 << 20);
        }
        assert_eq!(listened(&Networks::All), ["tcp/[::]:7447"]);
        let only = Networks::Only(vec![[192, 168, 1, 7].into()]);
        assert_eq!(listened(&only), ["tcp/127.0.0.1:7447", "tcp/192.168.1.7:7447"]);
    }

    #[test]
    fn the_variables_of_rmw_zenoh_are_honoured_and_options_come_first() {
        let over = "connect/endpoints=[\"tcp/10.0.0.1:7447\"]; listen/endpoints=[]";
        let settings = by(&ZenohOptions::default(), &[("ZENOH_CONFIG_OVERRIDE", over)]).unwrap();
        assert_eq!(get(&settings.session, "connect/endpoints"), json!(["tcp/10.0.0.1:7447"]));
        assert_eq!(get(&settings.session, "listen/endpoints"), json!([]));
        let connect = Some(vec!["tcp/10.0.0.2:7447".to_owned()]);
        let options = ZenohOptions { connect, ..ZenohOptions::default() };
        let settings = by(&options, &[("ZENOH_CONFIG_OVERRIDE", over)]).unwrap();
        assert_eq!(get(&settings.session, "connect/endpoints"), json!(["tcp/10.0.0.2:7447"]));
        assert!(settings.router.is_none(), "the router is on another machine");
        let none = ZenohOptions { router: false, ..ZenohOptions::default() };
        assert!(by(&none, &[]).unwrap().router.is_none());
    }

    #[test]
    fn files_are_those_of_rmw_zenoh() {
        let folder = tempfile::tempdir().unwrap();
        let file = |name: &str, text: &str| {
            let path = folder.path().join(name);
            std::fs::write(&path, text).unwrap();
            path.display().to_string()
        };
        let session =
            file("s.json5", "{ mode: \"client\", connect: { endpoints: [\"tcp/h:1\"] } }");
        let router = file("r.json5", "{ listen: { endpoints: [\"tcp/127.0.0.1:9\"] } }");
        let variables =
            [("ZENOH_SESSION_CONFIG_URI", &*session), ("ZENOH_ROUTER_CONFIG_URI", &*router)];
        let settings = by(&ZenohOptions::default(), &variables).unwrap();
        assert_eq!(get(&settings.session, "mode"), "client");
        assert_eq!(get(&settings.session, "timestamping/enabled")["peer"], true);
        let router = settings.router.unwrap();
        assert_eq!(get(&router, "listen/endpoints"), json!(["tcp/127.0.0.1:9"]));
        assert_eq!(get(&router, "mode"), "router");
    }

    #[test]
    fn wrong_variables_are_named() {
        for (name, value) in [
            ("ZENOH_CONFIG_OVERRIDE", "connect/endpoints"),
            ("ZENOH_CONFIG_OVERRIDE", "conect/endpoints=[]"),
            ("ZENOH_SESSION_CONFIG_URI", "/nowhere/x.json5"),
            ("ZENOH_ROUTER_CONFIG_URI", "/nowhere/x.json5"),
        ] {
            let error = by(&ZenohOptions::default(), &[(name, value)]).unwrap_err().to_string();
            assert!(error.contains(name) && error.contains(value), "{error}");
        }
    }
}
