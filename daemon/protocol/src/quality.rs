//! Quality of service of a component's ports.

use std::collections::BTreeMap;
use std::fmt;

use serde::de::{self, Deserializer, Visitor};
use serde::{Deserialize, Serialize};

use genom_nearest::nearest;

/// Maximum of `depth`.
const MOST: i64 = 65_536;

/// `[component.qos]`: quality of service on middlewares that have such settings (ros2). What is
/// left out is as the middleware is configured.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct QosEntry {
    /// Send lost samples again (reliable); false: best effort.
    #[serde(deserialize_with = "reliable", skip_serializing_if = "Option::is_none")]
    pub reliable: Option<bool>,
    /// Samples of an out port that may wait to be sent.
    #[serde(deserialize_with = "depth", skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "openapi", schema(minimum = 1, maximum = 65536))]
    pub depth: Option<usize>,
    /// Keep the last value for readers that come later (transient local); false: volatile.
    #[serde(deserialize_with = "transient_local", skip_serializing_if = "Option::is_none")]
    pub transient_local: Option<bool>,
    /// Settings of single ports, which take precedence over those of the component.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub ports: BTreeMap<String, PortQos>,
}

/// `[component.qos.ports.NAME]`: quality of service of one port.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct PortQos {
    /// See [`QosEntry::reliable`].
    #[serde(deserialize_with = "reliable", skip_serializing_if = "Option::is_none")]
    pub reliable: Option<bool>,
    /// See [`QosEntry::depth`].
    #[serde(deserialize_with = "depth", skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "openapi", schema(minimum = 1, maximum = 65536))]
    pub depth: Option<usize>,
    /// See [`QosEntry::transient_local`].
    #[serde(deserialize_with = "transient_local", skip_serializing_if = "Option::is_none")]
    pub transient_local: Option<bool>,
}

impl QosEntry {
    /// Whether nothing is set.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        *self == Self::default()
    }

    /// The settings of a port: its own where they are set, else those of the component.
    #[must_use]
    pub fn of(&self, port: &str) -> PortQos {
        let own = self.ports.get(port).cloned().unwrap_or_default();
        PortQos {
            reliable: own.reliable.or(self.reliable),
            depth: own.depth.or(self.depth),
            transient_local: own.transient_local.or(self.transient_local),
        }
    }
}

fn reliable<'de, D: Deserializer<'de>>(from: D) -> Result<Option<bool>, D::Error> {
    let words = ("reliable", "reliable", "best_effort");
    from.deserialize_any(Choice(words)).map(Some)
}

fn transient_local<'de, D: Deserializer<'de>>(from: D) -> Result<Option<bool>, D::Error> {
    let words = ("transient_local", "transient_local", "volatile");
    from.deserialize_any(Choice(words)).map(Some)
}

/// A boolean key, with the words that ROS uses for its two values: these are recognised, and the
/// error suggests the boolean.
struct Choice((&'static str, &'static str, &'static str));

impl Visitor<'_> for Choice {
    type Value = bool;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Choice((key, on, off)) = self;
        write!(f, "`{key}` = true ({on}) or false ({off})")
    }

    fn visit_bool<E: de::Error>(self, value: bool) -> Result<bool, E> {
        Ok(value)
    }

    fn visit_str<E: de::Error>(self, typed: &str) -> Result<bool, E> {
        let Choice((key, on, off)) = &self;
        let meant = match [*on, *off]
            .into_iter()
            .find(|word| *word == typed)
            .or_else(|| nearest(typed, [*on, *off]))
        {
            Some(word) => format!("; did you mean `{key} = {}`?", word == *on),
            None => String::new(),
        };
        Err(E::custom(format!("`{key}` is true or false, not \"{typed}\"{meant}")))
    }
}

fn depth<'de, D: Deserializer<'de>>(from: D) -> Result<Option<usize>, D::Error> {
    let number = i64::deserialize(from)?;
    match usize::try_from(number) {
        Ok(depth) if (1..=MOST).contains(&number) => Ok(Some(depth)),
        _ => Err(de::Error::custom(format!("`depth` is a number from 1 to {MOST}, not {number}"))),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<QosEntry, String> {
        toml::from_str(text).map_err(|error: toml::de::Error| error.message().to_owned())
    }

    #[test]
    fn a_port_has_that_of_its_component_unless_it_has_its_own() {
        let text = "reliable = false\ndepth = 4\n[ports.pose]\nreliable = true\n";
        let entry = read(text).unwrap();
        let (of_pose, other) = (entry.of("pose"), entry.of("scan"));
        assert_eq!((of_pose.reliable, of_pose.depth), (Some(true), Some(4)));
        assert_eq!((other.reliable, other.transient_local), (Some(false), None));
        assert_eq!(read(&toml::to_string(&entry).unwrap()), Ok(entry));
        assert!(QosEntry::default().is_empty());
    }

    #[test]
    fn wrong_values_name_their_key_and_what_was_meant() {
        for (text, told) in [
            ("reliable = \"best_efort\"", "did you mean `reliable = false`?"),
            ("transient_local = \"transient_local\"", "did you mean `transient_local = true`?"),
            ("transient_local = 3", "`transient_local` = true (transient_local) or false"),
            ("depth = 0", "`depth` is a number from 1 to 65536, not 0"),
            ("[ports.pose]\ndept = 3", "unknown field `dept`"),
        ] {
            let error = read(text).unwrap_err();
            assert!(error.contains(told), "{error}");
        }
    }
}
