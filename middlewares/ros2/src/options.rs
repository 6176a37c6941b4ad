//! What the user may choose.

use std::collections::BTreeMap;
use std::fmt;
use std::net::IpAddr;
use std::path::PathBuf;
use std::time::Duration;

use genom_rosidl::TypeName;
use serde::de::{Error as _, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer};

use crate::guard::Limits;
use crate::names;

/// Greatest domain whose ports fit (RTPS 9.6.1.1).
pub(crate) const LAST_DOMAIN: u16 = 232;

/// Which network interfaces may be used.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum Networks {
    /// This machine only: `"loopback"`.
    #[default]
    Loopback,
    /// All of them: `"all"`.
    All,
    /// Those with these addresses: `["192.168.1.7"]`.
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

/// How requests and replies are told apart on the wire.
#[derive(Clone, Copy, Debug, Default, Deserialize, PartialEq, Eq)]
#[serde(rename_all = "lowercase")]
pub enum ServiceMapping {
    /// As `rmw_fastrtps` does, the default of ROS 2: beside the message.
    #[default]
    Enhanced,
    /// As `rmw_cyclonedds` does: in the first 16 bytes of the message.
    Cyclone,
}

/// `[backends.ros2.qos]`: quality of service of ports.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Eq)]
#[serde(default, deny_unknown_fields)]
pub struct Qos {
    /// Lost packets are sent again. Otherwise readers that ask for this do not connect.
    pub reliable: bool,
    /// Samples of a port that wait to be sent; more than that give way, oldest first.
    pub depth: usize,
    /// Announces out ports as transient local, so that ROS nodes that ask for this connect.
    ///
    /// Every reader gets the last value anyway. The price: the DDS library keeps all samples of
    /// several seconds, and a node that asks for transient local gets them all when it comes.
    pub transient_local: bool,
}

impl Default for Qos {
    fn default() -> Self {
        Self { reliable: true, depth: 16, transient_local: false }
    }
}

/// `[backends.ros2]`; `configs/ros2.toml` explains it. The default stays within this machine.
#[derive(Clone, Debug, Deserialize, PartialEq, Eq)]
#[serde(default, deny_unknown_fields)]
pub struct Options {
    /// Participants of other domains are not seen. None: what `ROS_DOMAIN_ID` says, else 0.
    pub domain: Option<u16>,
    /// Which network interfaces may be used. None: what `ROS_LOCALHOST_ONLY` and
    /// `ROS_AUTOMATIC_DISCOVERY_RANGE` say, else this machine only, unlike ROS.
    pub networks: Option<Networks>,
    /// Put before all names: `lab/arm` makes `/lab/arm/demo/position`.
    pub namespace: String,
    /// How requests and replies are told apart.
    pub services: ServiceMapping,
    /// Quality of service of ports.
    pub qos: Qos,
    /// Attributes of one plain value are parameters, too.
    pub parameters: bool,
    /// ROS types of equal structure to be used for IDL types and services: `::demo::pose` as
    /// `geometry_msgs/msg/Pose`, service `::demo::reset` as `std_srvs/srv/Trigger`.
    pub masquerade: BTreeMap<String, String>,
    /// Folders of packages that define such types, `FOLDER/geometry_msgs/msg/Pose.msg`, besides
    /// those of `AMENT_PREFIX_PATH`; ROS's common types are known without.
    pub interfaces: Vec<PathBuf>,
    /// Bytes of the greatest sample that is put together of fragments.
    pub greatest_sample: u32,
    /// Participants that are known at a time; one address may have half of them.
    pub participants: usize,
    /// A participant that is silent for so long is gone, however long it asks to be waited for:
    /// by default as long as others wait for this daemon, so that both give up. No key.
    #[serde(skip)]
    pub silence: Duration,
}

impl Default for Options {
    fn default() -> Self {
        let Limits { sample, participants, silence } = Limits::default();
        Self {
            domain: None,
            networks: None,
            namespace: String::new(),
            services: ServiceMapping::default(),
            qos: Qos::default(),
            parameters: true,
            masquerade: BTreeMap::new(),
            interfaces: Vec::new(),
            greatest_sample: sample,
            participants,
            silence,
        }
    }
}

/// An option or a variable of the environment is wrong.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum OptionsError {
    /// No such domain.
    #[error("{key} = {value}: a domain is a number from 0 to {LAST_DOMAIN}")]
    Domain {
        /// The key of the configuration, or the variable.
        key: &'static str,
        /// The value as it was given.
        value: String,
    },
    /// A value that ROS does not know.
    #[error("ROS_LOCALHOST_ONLY is 0 or 1, not {0}")]
    LocalhostOnly(String),
    /// A value that ROS does not know, or one that this backend has no equivalent of.
    #[error(
        "ROS_AUTOMATIC_DISCOVERY_RANGE is LOCALHOST, SUBNET or SYSTEM_DEFAULT, not {0}; \
         to be found by nobody use another backend"
    )]
    Range(String),
    /// A namespace that ROS does not allow.
    #[error("namespace = `{0}`: ROS wants names of letters, digits and _ with / between them")]
    Namespace(String),
    /// The type to masquerade as is none.
    #[error("masquerade: {ty} cannot go as `{name}`: write package/msg/Type")]
    Masquerade {
        /// The IDL type.
        ty: String,
        /// The foreign name as it was given.
        name: String,
    },
}

impl Options {
    /// Whether all options make sense.
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

    /// What peers may have this daemon hold.
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
