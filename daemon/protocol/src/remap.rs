//! Rules that give a component, its ports and services other names on ROS 2, as ROS's own
//! (`from:=to`, ROS 2 design, "Remapping Names").

use std::fmt;
use std::str::FromStr;

use serde::de::Error as _;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

/// What a rule renames.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Renamed {
    /// The namespace of the node: `__ns`.
    Namespace,
    /// The node: `__node`.
    Node,
    /// An out port, or a service, by its name: `position`, or `~/position` as ROS writes it.
    Name(String),
}

/// A rule: `position:=/odom`, `__ns:=/lab`, `__node:=arm`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Remap {
    /// What has another name.
    pub what: Renamed,
    /// That name: `/odom`, `odom` below the namespace of the node, or `~/odom` below the node.
    pub to: String,
}

/// A rule that cannot be read.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum BadRemap {
    /// It has no `:=`, or nothing on one side.
    #[error("`{0}` is no rule: write `position:=/odom`, `__ns:=/lab` or `__node:=arm`")]
    Form(String),
    /// It begins with two underscores, and is neither a namespace nor a node.
    #[error("`{0}`: `__ns` and `__node` are known")]
    Keyword(String),
    /// What it renames is no name of a port or a service.
    #[error(
        "`{0}`: on the left is a name of the component, `position` or `~/position`, without the \
         node"
    )]
    From(String),
    /// What it becomes is no name in ROS.
    #[error(
        "`{rule}`: `{to}` is no name in ROS: letters, digits and _ with / between them, which do \
         not begin with a digit"
    )]
    To {
        /// The rule.
        rule: String,
        /// Its right side.
        to: String,
    },
    /// It gives a namespace that is not absolute, or a node a name with a `/`.
    #[error("`{0}`: a namespace begins with /, a node has none in its name")]
    Whole(String),
}

/// Whether this may stand between the slashes of a name in ROS: letters, digits and `_`, the first of
/// which is no digit (design.ros2.org, "Topic and Service name mapping to DDS").
#[must_use]
pub fn is_ros_part(part: &str) -> bool {
    let mut letters = part.chars();
    letters.next().is_some_and(|c| c.is_ascii_alphabetic() || c == '_')
        && letters.all(|c| c.is_ascii_alphanumeric() || c == '_')
}

/// Whether ROS takes this as a name, with slashes between its parts.
fn is_ros_name(name: &str) -> bool {
    name.split('/').all(|part| is_ros_part(part) && !part.contains("__"))
}

impl FromStr for Remap {
    type Err = BadRemap;

    fn from_str(rule: &str) -> Result<Self, BadRemap> {
        let form = || BadRemap::Form(rule.to_owned());
        let (from, to) = rule.split_once(":=").ok_or_else(form)?;
        if from.is_empty() || to.is_empty() {
            return Err(form());
        }
        let what = match from {
            "__ns" => Renamed::Namespace,
            "__node" | "__name" => Renamed::Node,
            _ if from.starts_with("__") => return Err(BadRemap::Keyword(rule.to_owned())),
            _ => {
                let name = from.strip_prefix("~/").unwrap_or(from);
                if name.is_empty() || name.starts_with('/') || name.contains([':', '*', ' ']) {
                    return Err(BadRemap::From(rule.to_owned()));
                }
                Renamed::Name(name.to_owned())
            }
        };
        let plain = match what {
            Renamed::Namespace => to.strip_prefix('/').filter(|_| to != "/"),
            Renamed::Node => Some(to).filter(|to| !to.contains('/')),
            Renamed::Name(_) => {
                Some(to.strip_prefix("~/").or_else(|| to.strip_prefix('/')).unwrap_or(to))
            }
        };
        // The root is a namespace, too.
        let plain = plain.or((what == Renamed::Namespace && to == "/").then_some("root"));
        match plain {
            None => Err(BadRemap::Whole(rule.to_owned())),
            Some(plain) if !is_ros_name(plain) => {
                Err(BadRemap::To { rule: rule.to_owned(), to: to.to_owned() })
            }
            Some(_) => Ok(Self { what, to: to.to_owned() }),
        }
    }
}

impl fmt::Display for Remap {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let from = match &self.what {
            Renamed::Namespace => "__ns",
            Renamed::Node => "__node",
            Renamed::Name(name) => name,
        };
        write!(f, "{from}:={}", self.to)
    }
}

impl<'de> Deserialize<'de> for Remap {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        String::deserialize(from)?.parse().map_err(D::Error::custom)
    }
}

impl Serialize for Remap {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        to.collect_str(self)
    }
}

/// What these rules give other names on ROS 2, and which: the instance itself (`demo`), and what it
/// has (`demo/position`). The later of two rules for one thing applies.
#[must_use]
pub fn renamed(instance: &str, rules: &[Remap]) -> Vec<(String, String)> {
    let last = |what: &Renamed| rules.iter().rfind(|rule| rule.what == *what);
    let mut all = Vec::new();
    let node = last(&Renamed::Node).map(|rule| rule.to.as_str());
    match (last(&Renamed::Namespace), node) {
        (Some(namespace), node) => {
            let (namespace, node) = (namespace.to.trim_end_matches('/'), node.unwrap_or(instance));
            all.push((instance.to_owned(), format!("{namespace}/{node}")));
        }
        (None, Some(node)) => all.push((instance.to_owned(), node.to_owned())),
        (None, None) => {}
    }
    for rule in rules {
        if let Renamed::Name(name) = &rule.what
            && last(&rule.what) == Some(rule)
        {
            all.push((format!("{instance}/{name}"), rule.to.clone()));
        }
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rules_are_those_of_ros() {
        for (rule, what, to) in [
            ("position:=/odom", Renamed::Name("position".into()), "/odom"),
            ("~/poses/left:=scan", Renamed::Name("poses/left".into()), "scan"),
            ("goto:=~/go", Renamed::Name("goto".into()), "~/go"),
            ("__ns:=/lab/one", Renamed::Namespace, "/lab/one"),
            ("__ns:=/", Renamed::Namespace, "/"),
            ("__node:=arm", Renamed::Node, "arm"),
            ("__name:=arm", Renamed::Node, "arm"),
        ] {
            let read: Remap = rule.parse().unwrap();
            assert_eq!(read, Remap { what, to: to.into() });
            assert_eq!(read.to_string().parse(), Ok(read));
        }
    }

    #[test]
    fn what_is_no_rule_is_refused_with_the_way_out() {
        for (rule, told) in [
            ("position=/odom", "write `position:=/odom`"),
            (":=/odom", "write `position:=/odom`"),
            ("position:=", "write `position:=/odom`"),
            ("__namespace:=/lab", "`__ns` and `__node` are known"),
            ("/demo/position:=/odom", "without the node"),
            ("demo:position:=/odom", "without the node"),
            ("position:=/2odom", "`/2odom` is no name in ROS"),
            ("position:=//odom", "no name in ROS"),
            ("position:=/odom/", "no name in ROS"),
            ("position:=a b", "no name in ROS"),
            ("__ns:=lab", "a namespace begins with /"),
            ("__node:=lab/arm", "a node has none in its name"),
        ] {
            let error = rule.parse::<Remap>().unwrap_err().to_string();
            assert!(error.contains(told), "{rule}: {error}");
        }
    }

    #[test]
    fn the_last_rule_for_a_name_applies() {
        let rules = ["p:=/a", "__node:=arm", "p:=/b", "q:=c", "__ns:=/lab"];
        let rules: Vec<Remap> = rules.iter().map(|rule| rule.parse().unwrap()).collect();
        let pair = |ours: &str, theirs: &str| (ours.to_owned(), theirs.to_owned());
        assert_eq!(
            renamed("demo", &rules),
            [pair("demo", "/lab/arm"), pair("demo/p", "/b"), pair("demo/q", "c")]
        );
        let only = |rule: &str| renamed("demo", &[rule.parse().unwrap()]);
        assert_eq!(only("__ns:=/"), [pair("demo", "/demo")]);
        assert_eq!(only("__node:=arm"), [pair("demo", "arm")]);
        assert_eq!(renamed("demo", &[]), []);
    }
}
