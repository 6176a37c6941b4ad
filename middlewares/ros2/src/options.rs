//! What the user may choose, and what the environment of ROS says.

use std::collections::BTreeMap;
use std::net::{IpAddr, Ipv4Addr};
use std::path::PathBuf;

use genom_rosidl::TypeName;

use crate::guard::Limits;

/// Greatest domain whose ports fit (RTPS 9.6.1.1).
const LAST_DOMAIN: u16 = 232;

/// Which network interfaces may be used.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum Networks {
    /// This machine only.
    #[default]
    Loopback,
    /// All of them.
    All,
    /// Those with these addresses.
    Only(Vec<IpAddr>),
}

/// How requests and replies are told apart on the wire.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ServiceMapping {
    /// As `rmw_fastrtps` does, the default of ROS 2: beside the message.
    #[default]
    Enhanced,
    /// As `rmw_cyclonedds` does: in the first 16 bytes of the message.
    Cyclone,
}

/// Quality of service of ports.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
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

/// How to open the middleware. The default stays within this machine.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Options {
    /// Participants of other domains are not seen.
    pub domain: u16,
    /// Which network interfaces may be used.
    pub networks: Networks,
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
    /// What peers may have this daemon hold.
    pub limits: Limits,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            domain: 0,
            networks: Networks::default(),
            namespace: String::new(),
            services: ServiceMapping::default(),
            qos: Qos::default(),
            parameters: true,
            masquerade: BTreeMap::new(),
            interfaces: Vec::new(),
            limits: Limits::default(),
        }
    }
}

/// An option or a variable of the environment is wrong.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum OptionsError {
    /// No such domain.
    #[error("{0} is no domain: ROS_DOMAIN_ID is a number from 0 to {LAST_DOMAIN}")]
    Domain(String),
    /// Not one of the values.
    #[error("ROS_LOCALHOST_ONLY is 0 or 1, not {0}")]
    LocalhostOnly(String),
    /// Not one of the values, or one that cannot be had.
    #[error(
        "ROS_AUTOMATIC_DISCOVERY_RANGE is LOCALHOST, SUBNET or SYSTEM_DEFAULT, not {0}; \
         to be found by nobody use another backend"
    )]
    Range(String),
    /// A namespace that ROS does not allow.
    #[error("`{0}` is no namespace: write names of letters, digits and _ with / between them")]
    Namespace(String),
    /// The type to masquerade as is none.
    #[error("{ty} cannot masquerade as `{name}`: write package/msg/Type")]
    Masquerade {
        /// The IDL type.
        ty: String,
        /// What is wrong.
        name: String,
    },
}

impl Options {
    /// The defaults, with what ROS's variables say: `ROS_DOMAIN_ID`, `ROS_LOCALHOST_ONLY` and
    /// `ROS_AUTOMATIC_DISCOVERY_RANGE`. Without the latter two this machine only: unlike ROS.
    ///
    /// # Errors
    /// A variable has a value that ROS does not know.
    pub fn from_env() -> Result<Self, OptionsError> {
        Self::from_variables(|name| std::env::var(name).ok())
    }

    /// As [`from_env`](Options::from_env), of an environment of the caller's.
    ///
    /// # Errors
    /// A variable has a value that ROS does not know.
    pub fn from_variables(variable: impl Fn(&str) -> Option<String>) -> Result<Self, OptionsError> {
        let set = |name: &str| variable(name).filter(|value| !value.is_empty());
        let mut options = Self::default();
        if let Some(domain) = set("ROS_DOMAIN_ID") {
            options.domain = domain
                .parse()
                .ok()
                .filter(|&domain| domain <= LAST_DOMAIN)
                .ok_or(OptionsError::Domain(domain))?;
        }
        let range = set("ROS_AUTOMATIC_DISCOVERY_RANGE");
        match range.as_deref() {
            None | Some("LOCALHOST") => {}
            Some("SUBNET" | "SYSTEM_DEFAULT") => options.networks = Networks::All,
            Some(_) => return Err(OptionsError::Range(range.unwrap_or_default())),
        }
        // The older variable wins where both are set, as in ROS.
        match set("ROS_LOCALHOST_ONLY").as_deref() {
            None | Some("0") => {}
            Some("1") => options.networks = Networks::Loopback,
            Some(other) => return Err(OptionsError::LocalhostOnly(other.to_owned())),
        }
        Ok(options)
    }

    /// Whether all options make sense.
    pub(crate) fn check(&self) -> Result<(), OptionsError> {
        if self.domain > LAST_DOMAIN {
            return Err(OptionsError::Domain(self.domain.to_string()));
        }
        let parts = self.namespace.trim_matches('/');
        let legal = |part: &str| !part.is_empty() && crate::names::token(part) == part;
        if !parts.is_empty() && !parts.split('/').all(legal) {
            return Err(OptionsError::Namespace(self.namespace.clone()));
        }
        let wrong = self.masquerade.iter().find(|(_, name)| TypeName::parse(name).is_none());
        wrong.map_or(Ok(()), |(ty, name)| {
            Err(OptionsError::Masquerade { ty: ty.clone(), name: name.clone() })
        })
    }

    /// Addresses of the interfaces that may be used; none: all.
    pub(crate) fn addresses(&self) -> Option<Vec<IpAddr>> {
        match &self.networks {
            Networks::Loopback => Some(vec![Ipv4Addr::LOCALHOST.into()]),
            Networks::Only(addresses) => Some(addresses.clone()),
            Networks::All => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn from(variables: &[(&str, &str)]) -> Result<Options, OptionsError> {
        Options::from_variables(|name| {
            variables.iter().find(|(other, _)| *other == name).map(|(_, value)| (*value).to_owned())
        })
    }

    #[test]
    fn the_environment_of_ros_is_honoured() {
        let networks = |variables: &[(&str, &str)]| from(variables).unwrap().networks;
        assert_eq!(from(&[]).unwrap(), Options::default());
        assert_eq!(from(&[("ROS_DOMAIN_ID", "42")]).unwrap().domain, 42);
        assert_eq!(networks(&[("ROS_AUTOMATIC_DISCOVERY_RANGE", "SUBNET")]), Networks::All);
        assert_eq!(networks(&[("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")]), Networks::Loopback);
        let both = [("ROS_AUTOMATIC_DISCOVERY_RANGE", "SUBNET"), ("ROS_LOCALHOST_ONLY", "1")];
        assert_eq!(networks(&both), Networks::Loopback);
    }

    #[test]
    fn wrong_values_are_named() {
        for (name, value) in [
            ("ROS_DOMAIN_ID", "233"),
            ("ROS_DOMAIN_ID", "x"),
            ("ROS_LOCALHOST_ONLY", "yes"),
            ("ROS_AUTOMATIC_DISCOVERY_RANGE", "OFF"),
        ] {
            let error = from(&[(name, value)]).unwrap_err().to_string();
            assert!(error.contains(name) && error.contains(value), "{error}");
        }
        let options =
            |namespace: &str| Options { namespace: namespace.into(), ..Default::default() };
        assert!(options("lab/arm_2").check().is_ok());
        assert!(options("lab//arm").check().is_err());
        assert!(options("2lab").check().is_err());
        let masquerade = [("::demo::pose".to_owned(), "Pose".to_owned())].into();
        assert!(Options { masquerade, ..Default::default() }.check().is_err());
    }
}
