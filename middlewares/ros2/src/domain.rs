//! The DDS domain of this daemon, from its options or the environment variables of ROS.

use std::net::{IpAddr, Ipv4Addr};

use crate::options::{LAST_DOMAIN, Networks, Options, OptionsError};

/// A domain, and the network interfaces that are used for it.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Domain {
    pub(crate) number: u16,
    pub(crate) networks: Networks,
}

impl Domain {
    /// From the options; what they leave open comes from the environment.
    pub(crate) fn of(options: &Options) -> Result<Self, OptionsError> {
        let Self { number, networks } = Self::by(|name| std::env::var(name).ok())?;
        Ok(Self {
            number: options.domain.unwrap_or(number),
            networks: options.networks.clone().unwrap_or(networks),
        })
    }

    /// From ROS's variables `ROS_DOMAIN_ID`, `ROS_LOCALHOST_ONLY` and
    /// `ROS_AUTOMATIC_DISCOVERY_RANGE`. Without the latter two only this machine is used, which
    /// differs from ROS.
    fn by(variable: impl Fn(&str) -> Option<String>) -> Result<Self, OptionsError> {
        let set = |name: &str| variable(name).filter(|value| !value.is_empty());
        let mut domain = Self::default();
        if let Some(value) = set("ROS_DOMAIN_ID") {
            domain.number = value
                .parse()
                .ok()
                .filter(|&number| number <= LAST_DOMAIN)
                .ok_or(OptionsError::Domain { key: "ROS_DOMAIN_ID", value })?;
        }
        let range = set("ROS_AUTOMATIC_DISCOVERY_RANGE");
        match range.as_deref() {
            None | Some("LOCALHOST") => {}
            Some("SUBNET" | "SYSTEM_DEFAULT") => domain.networks = Networks::All,
            Some(_) => return Err(OptionsError::Range(range.unwrap_or_default())),
        }
        // If both are set, the older variable takes precedence, as in ROS.
        match set("ROS_LOCALHOST_ONLY").as_deref() {
            None | Some("0") => {}
            Some("1") => domain.networks = Networks::Loopback,
            Some(other) => return Err(OptionsError::LocalhostOnly(other.to_owned())),
        }
        Ok(domain)
    }

    /// Addresses of the interfaces to use; `None` for all.
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

    fn by(variables: &[(&str, &str)]) -> Result<Domain, OptionsError> {
        Domain::by(|name| {
            variables.iter().find(|(other, _)| *other == name).map(|(_, value)| (*value).to_owned())
        })
    }

    #[test]
    fn the_environment_of_ros_is_honoured() {
        let networks = |variables: &[(&str, &str)]| by(variables).unwrap().networks;
        assert_eq!(by(&[]).unwrap(), Domain::default());
        assert_eq!(by(&[("ROS_DOMAIN_ID", "42")]).unwrap().number, 42);
        assert_eq!(networks(&[("ROS_AUTOMATIC_DISCOVERY_RANGE", "SUBNET")]), Networks::All);
        assert_eq!(networks(&[("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")]), Networks::Loopback);
        let both = [("ROS_AUTOMATIC_DISCOVERY_RANGE", "SUBNET"), ("ROS_LOCALHOST_ONLY", "1")];
        assert_eq!(networks(&both), Networks::Loopback);
    }

    #[test]
    fn wrong_variables_are_named() {
        for (name, value) in [
            ("ROS_DOMAIN_ID", "233"),
            ("ROS_DOMAIN_ID", "x"),
            ("ROS_LOCALHOST_ONLY", "yes"),
            ("ROS_AUTOMATIC_DISCOVERY_RANGE", "OFF"),
        ] {
            let error = by(&[(name, value)]).unwrap_err().to_string();
            assert!(error.contains(name) && error.contains(value), "{error}");
        }
    }
}
