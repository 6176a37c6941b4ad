//! Options for opening the middleware.

use std::collections::BTreeMap;
use std::fmt;
use std::net::IpAddr;
use std::path::PathBuf;
use std::time::Duration;

use genom_middleware::Quality;
use genom_rosidl::TypeName;
use genom_rtps_guard::Limits;
use serde::de::{Error as _, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer};

use crate::names;

/// Greatest domain whose UDP ports are below 65536 (RTPS 9.6.1.1).
pub(crate) const LAST_DOMAIN: u16 = 232;

/// Which network interfaces may be used.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum Networks {
    /// This machine only: `"loopback"`.
    #[default]
    Loopback,
    /// All of them: `"all"`.
    All,
    /// Those with the given addresses: `["192.168.1.7"]`.
    Only(Vec<IpAddr>),
}

impl<'de> Deserialize<'de> for Networks {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        struct Ways;

        impl<'de> Visitor<'de> for Ways {
            type Value = Networks;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("\"loopback\", \"all\" or a list of addresses")
            }

            fn visit_str<E: serde::de::Error>(self, word: &str) -> Result<Networks, E> {
                match word {
                    "loopback" => Ok(Networks::Loopback),
                    "all" => Ok(Networks::All),
                    other => Err(E::invalid_value(serde::de::Unexpected::Str(other), &self)),
                }
            }

            fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<Networks, A::Error> {
                let mut addresses = Vec::new();
                while let Some(address) = list.next_element::<String>()? {
                    addresses.push(address.parse().map_err(|_| {
                        A::Error::custom(format!("`{address}` is no address: write 192.168.1.7"))
                    })?);
                }
                Ok(Networks::Only(addresses))
            }
        }

        from.deserialize_any(Ways)
    }
}

/// How a reply is associated with its request.
#[derive(Clone, Copy, Debug, Default, Deserialize, PartialEq, Eq)]
#[serde(rename_all = "lowercase")]
pub enum ServiceMapping {
    /// By metadata outside the message, as `rmw_fastrtps` does, the default of ROS 2.
    #[default]
    Enhanced,
    /// By the first 16 bytes of the message, as `rmw_cyclonedds` does.
    Cyclone,
}

/// Section `[backends.ros2.qos]` of the configuration: quality of service of ports.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Eq)]
#[serde(default, deny_unknown_fields)]
pub struct Qos {
    /// Lost samples are sent again. If false, readers that request reliability do not connect.
    pub reliable: bool,
    /// Number of samples of a port that may wait to be sent; the oldest are dropped.
    pub depth: usize,
    /// Announces out ports as transient local, so that ROS nodes that request it connect.
    ///
    /// Every reader gets the last value anyway. With this, the DDS library keeps all samples of
    /// several seconds, and sends all of them to a new reader that requests transient local.
    pub transient_local: bool,
}

impl Default for Qos {
    fn default() -> Self {
        Self { reliable: true, depth: 16, transient_local: false }
    }
}

impl Qos {
    /// The quality that an out port offers.
    pub(crate) fn offered(&self, of_port: &Quality) -> Self {
        Self {
            reliable: of_port.reliable.unwrap_or(self.reliable),
            depth: of_port.depth.unwrap_or(self.depth),
            transient_local: of_port.transient_local.unwrap_or(self.transient_local),
        }
    }
}

/// What carries ROS.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Eq)]
#[serde(rename_all = "lowercase")]
pub enum Rmw {
    /// DDS, as for `rmw_fastrtps` and `rmw_cyclonedds`.
    Dds,
    /// zenoh, as for `rmw_zenoh`.
    Zenoh,
}

/// Section `[backends.ros2.zenoh]` of the configuration: the session where `rmw` is `zenoh`.
#[derive(Clone, Debug, Deserialize, PartialEq, Eq)]
#[serde(default, deny_unknown_fields)]
pub struct ZenohOptions {
    /// Whether this process is the router of the machine while no other process is. Nodes find
    /// each other through it.
    pub router: bool,
    /// Endpoints to connect to. `None`: those of `ZENOH_SESSION_CONFIG_URI` and
    /// `ZENOH_CONFIG_OVERRIDE`, or the router of this machine, `tcp/localhost:7447`.
    pub connect: Option<Vec<String>>,
    /// Endpoints to listen on. `None`: those of the two variables, or `tcp/localhost:0`.
    pub listen: Option<Vec<String>>,
}

impl Default for ZenohOptions {
    fn default() -> Self {
        Self { router: true, connect: None, listen: None }
    }
}

/// Section `[backends.ros2]` of the configuration; `configs/ros2.toml` explains it. The defaults
/// stay within this machine.
#[derive(Clone, Debug, Deserialize, PartialEq, Eq)]
#[serde(default, deny_unknown_fields)]
pub struct Options {
    /// What carries ROS: `dds` or `zenoh`. `None`: zenoh if `RMW_IMPLEMENTATION` is
    /// `rmw_zenoh_cpp`, otherwise DDS.
    pub rmw: Option<Rmw>,
    /// The ROS domain; participants of other domains are not seen. `None`: `ROS_DOMAIN_ID`, or 0.
    pub domain: Option<u16>,
    /// Which network interfaces may be used; on zenoh, by a router of this process. `None`: what
    /// `ROS_LOCALHOST_ONLY` and `ROS_AUTOMATIC_DISCOVERY_RANGE` say, or only this machine, which
    /// differs from ROS.
    pub networks: Option<Networks>,
    /// Prefix of all names: `lab/arm` makes `/lab/arm/demo/position`.
    pub namespace: String,
    /// How a reply is associated with its request.
    pub services: ServiceMapping,
    /// Quality of service of ports.
    pub qos: Qos,
    /// The session where `rmw` is `zenoh`.
    pub zenoh: ZenohOptions,
    /// Whether attributes with a single plain value are also parameters.
    pub parameters: bool,
    /// Whether nodes of components tell what the types are made of that they use.
    pub type_descriptions: bool,
    /// ROS types of equal structure as which IDL types and services masquerade: `::demo::pose` as
    /// `geometry_msgs/msg/Pose`, service `::demo::reset` as `std_srvs/srv/Trigger`.
    pub masquerade: BTreeMap<String, String>,
    /// Folders with packages that define such types, `FOLDER/geometry_msgs/msg/Pose.msg`, in
    /// addition to those of `AMENT_PREFIX_PATH`. ROS's common types are built in.
    pub interfaces: Vec<PathBuf>,
    /// Size in bytes of the largest sample that is reassembled from fragments; on zenoh, of any
    /// sample.
    pub greatest_sample: u32,
    /// Greatest number of participants at a time; one address may have half of them. On zenoh, of
    /// other sessions with ends.
    pub participants: usize,
    /// Longest lease: a participant that is silent for this long counts as gone, whatever lease it
    /// announces. The default is the lease of this daemon, so that both sides give up at the same
    /// time. Not a key of the configuration.
    #[serde(skip)]
    pub silence: Duration,
}

impl Default for Options {
    fn default() -> Self {
        let Limits { sample, participants, silence } = Limits::default();
        Self {
            rmw: None,
            zenoh: ZenohOptions::default(),
            domain: None,
            networks: None,
            namespace: String::new(),
            services: ServiceMapping::default(),
            qos: Qos::default(),
            parameters: true,
            type_descriptions: true,
            masquerade: BTreeMap::new(),
            interfaces: Vec::new(),
            greatest_sample: sample,
            participants,
            silence,
        }
    }
}

/// An option or an environment variable is wrong.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum OptionsError {
    /// The domain does not exist.
    #[error("{key} = {value}: a domain is a number from 0 to {LAST_DOMAIN}")]
    Domain {
        /// The key of the configuration, or the variable.
        key: &'static str,
        /// The value as given.
        value: String,
    },
    /// A value of `ROS_LOCALHOST_ONLY` that ROS does not know.
    #[error("ROS_LOCALHOST_ONLY is 0 or 1, not {0}")]
    LocalhostOnly(String),
    /// A value that ROS does not know, or that this backend does not support.
    #[error(
        "ROS_AUTOMATIC_DISCOVERY_RANGE is LOCALHOST, SUBNET or SYSTEM_DEFAULT, not {0}; \
         to be found by nobody use another backend"
    )]
    Range(String),
    /// A namespace that is not valid in ROS.
    #[error("namespace = `{0}`: ROS wants names of letters, digits and _ with / between them")]
    Namespace(String),
    /// zenoh does not take a setting.
    #[error("{key}: {why}")]
    Zenoh {
        /// The setting, or the variable with its value.
        key: String,
        /// The library's message.
        why: String,
    },
    /// The name of the foreign type is not valid.
    #[error("masquerade: {ty} cannot go as `{name}`: write package/msg/Type")]
    Masquerade {
        /// The IDL type.
        ty: String,
        /// The foreign name as given.
        name: String,
    },
}

impl Options {
    /// Checks that all options are valid.
    pub(crate) fn check(&self) -> Result<(), OptionsError> {
        if let Some(domain) = self.domain.filter(|domain| *domain > LAST_DOMAIN) {
            return Err(OptionsError::Domain { key: "domain", value: domain.to_string() });
        }
        let parts = self.namespace.trim_matches('/');
        let legal = |part: &str| !part.is_empty() && names::token(part) == part;
        if !parts.is_empty() && !parts.split('/').all(legal) {
            return Err(OptionsError::Namespace(self.namespace.clone()));
        }
        let wrong = self.masquerade.iter().find(|(_, name)| TypeName::parse(name).is_none());
        wrong.map_or(Ok(()), |(ty, name)| {
            Err(OptionsError::Masquerade { ty: ty.clone(), name: name.clone() })
        })
    }

    /// What carries ROS, by the options and the environment.
    pub(crate) fn rmw(&self) -> Rmw {
        self.rmw.unwrap_or_else(|| match std::env::var("RMW_IMPLEMENTATION").as_deref() {
            Ok("rmw_zenoh_cpp") => Rmw::Zenoh,
            _ => Rmw::Dds,
        })
    }

    /// Limits for what peers may cause here.
    pub(crate) fn limits(&self) -> Limits {
        let Self { greatest_sample, participants, silence, .. } = *self;
        Limits { sample: greatest_sample, participants, silence }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn wrong_options_are_named() {
        let options =
            |namespace: &str| Options { namespace: namespace.into(), ..Default::default() };
        assert!(options("lab/arm_2").check().is_ok());
        assert!(options("lab//arm").check().is_err());
        assert!(options("2lab").check().is_err());
        let masquerade = [("::demo::pose".to_owned(), "Pose".to_owned())].into();
        assert!(Options { masquerade, ..Default::default() }.check().is_err());
        let error = Options { domain: Some(233), ..Default::default() }.check().unwrap_err();
        assert_eq!(error.to_string(), "domain = 233: a domain is a number from 0 to 232");
    }

    #[test]
    fn options_are_read_and_unknown_ones_are_named() {
        let given = "domain = 7\nnetworks = [\"192.168.1.7\"]\ngreatest_sample = 4096\n\
                     services = \"cyclone\"\n[qos]\ndepth = 4\n\
                     [masquerade]\n\"::demo::pose\" = \"geometry_msgs/msg/Pose\"\n";
        let options: Options = toml::from_str(given).unwrap();
        assert_eq!(options.domain, Some(7));
        assert_eq!((options.qos.depth, options.qos.reliable), (4, true));
        assert_eq!(options.services, ServiceMapping::Cyclone);
        assert_eq!(options.networks, Some(Networks::Only(vec![[192, 168, 1, 7].into()])));
        assert_eq!(options.limits(), Limits { sample: 4096, ..Limits::default() });
        assert_eq!(options.masquerade["::demo::pose"], "geometry_msgs/msg/Pose");
        assert_eq!(toml::from_str::<Options>("").unwrap(), Options::default());
        let all: Options = toml::from_str("networks = \"all\"").unwrap();
        assert_eq!(all.networks, Some(Networks::All));
        for (given, told) in [
            ("domian = 7", "`domain`"),
            ("[qos]\ndept = 7", "`depth`"),
            ("networks = \"lo\"", "\"loopback\", \"all\" or a list of addresses"),
            ("networks = [\"robot\"]", "`robot` is no address"),
        ] {
            let error = toml::from_str::<Options>(given).unwrap_err().to_string();
            assert!(error.contains(told), "{error}");
        }
    }
}
