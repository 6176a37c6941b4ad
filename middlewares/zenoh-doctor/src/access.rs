//! Rules of zenoh's access control that deny what a session needs.

use std::collections::BTreeMap;

use genom_middleware::Obstacle;
use serde::Deserialize;
use zenoh::Config;
use zenoh::key_expr::OwnedKeyExpr;

use crate::role::Role;
use crate::settings::get;

/// `access_control` of a configuration, as far as it is needed here.
#[derive(Deserialize)]
struct Access {
    enabled: bool,
    #[serde(default)]
    default_permission: Option<String>,
    #[serde(default)]
    rules: Option<Vec<Rule>>,
    #[serde(default)]
    policies: Option<Vec<Policy>>,
}

#[derive(Deserialize)]
struct Rule {
    id: String,
    key_exprs: Vec<OwnedKeyExpr>,
    messages: Vec<String>,
    /// None: both.
    #[serde(default)]
    flows: Option<Vec<String>>,
    permission: String,
}

#[derive(Deserialize)]
struct Policy {
    rules: Vec<String>,
    subjects: Vec<String>,
}

impl Rule {
    fn is_about(&self, message: &str, flow: &str) -> bool {
        self.messages.iter().any(|one| one == message)
            && self.flows.as_ref().is_none_or(|flows| flows.iter().any(|one| one == flow))
    }

    fn denies(&self) -> bool {
        self.permission == "deny"
    }
}

/// What denies: a rule with those to whom it applies, or none that allows.
type Cause<'a> = (Option<&'a Rule>, &'static str, &'static str);

/// What access control denies of these keys.
pub(crate) fn denied(config: &Config, keys: &[(OwnedKeyExpr, Role)]) -> Vec<Obstacle> {
    let Ok(access) = serde_json::from_value::<Access>(get(config, "access_control")) else {
        return Vec::new();
    };
    if !access.enabled {
        return Vec::new();
    }
    let (rules, policies) = (access.rules.unwrap_or_default(), access.policies.unwrap_or_default());
    let used = |rule: &&Rule| policies.iter().any(|policy| policy.rules.contains(&rule.id));
    let rules: Vec<&Rule> = rules.iter().filter(used).collect();
    let default_deny = access.default_permission.as_deref() != Some("allow");
    // By rule, message and direction: the keys.
    let mut found: BTreeMap<_, (Cause<'_>, Vec<&OwnedKeyExpr>)> = BTreeMap::new();
    for (key, role) in keys {
        for &(message, flow) in role.needs() {
            let about = || rules.iter().filter(|rule| rule.is_about(message, flow));
            let intersects = |rule: &&&Rule| rule.key_exprs.iter().any(|one| one.intersects(key));
            let mut denying: Vec<Option<&Rule>> = about()
                .filter(|rule| rule.denies())
                .filter(intersects)
                .map(|rule| Some(*rule))
                .collect();
            let includes = |rule: &&&Rule| rule.key_exprs.iter().any(|one| one.includes(key));
            let allowed = about().filter(|rule| !rule.denies()).any(|rule| includes(&rule));
            if denying.is_empty() && default_deny && !allowed {
                denying.push(None);
            }
            for rule in denying {
                let id = rule.map(|rule| rule.id.as_str());
                let entry = found.entry((id, message, flow));
                entry.or_insert_with(|| ((rule, message, flow), Vec::new())).1.push(key);
            }
        }
    }
    found.into_values().map(|(cause, keys)| obstacle(cause, &keys, &policies)).collect()
}

fn obstacle(
    (rule, message, flow): Cause<'_>,
    keys: &[&OwnedKeyExpr],
    policies: &[Policy],
) -> Obstacle {
    let first = keys.first().map(|key| key.as_str()).unwrap_or_default();
    let more = match keys.len() {
        0 | 1 => String::new(),
        count => format!(" and {} more keys", count - 1),
    };
    let of = format!("{message} ({flow}) of {first}{more}");
    match rule {
        Some(Rule { id, .. }) => {
            let holds = |policy: &&Policy| policy.rules.contains(id);
            let subjects = policies.iter().filter(holds).flat_map(|policy| &policy.subjects);
            let subjects: Vec<&str> = subjects.map(String::as_str).collect();
            Obstacle {
                what: format!(
                    "rule `{id}` of access_control denies {of}, with subjects {}",
                    subjects.join(", ")
                ),
                fix: format!("change rule `{id}` if that is not meant"),
            }
        }
        None => Obstacle {
            what: format!(
                "access_control denies {of}: its default_permission is deny, and no rule that a \
                 policy uses allows it"
            ),
            fix: "a rule that allows it, and a policy that uses the rule".to_owned(),
        },
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const KEYS: [(&str, Role); 4] = [
        ("demo/position", Role::Writes),
        ("demo/speed", Role::Writes),
        ("demo/goto", Role::Serves),
        ("hand/gain", Role::Reads),
    ];

    fn found(access: &str) -> Vec<String> {
        let mut config = Config::default();
        config.insert_json5("access_control", access).unwrap();
        let keys = KEYS.map(|(key, role)| (OwnedKeyExpr::new(key).unwrap(), role));
        denied(&config, &keys).into_iter().map(|one| one.what).collect()
    }

    fn rule(id: &str, permission: &str, messages: &str, keys: &str) -> String {
        format!(
            "{{ id: '{id}', permission: '{permission}', messages: [{messages}], \
             flows: ['egress', 'ingress'], key_exprs: ['{keys}'] }}"
        )
    }

    fn access(default: &str, rules: &[String], used: &str) -> String {
        format!(
            "{{ enabled: true, default_permission: '{default}', rules: [{}], \
             subjects: [{{ id: 'all' }}], policies: [{{ rules: [{used}], subjects: ['all'] }}] }}",
            rules.join(", ")
        )
    }

    #[test]
    fn a_rule_that_denies_is_named_with_what_and_whom() {
        let rules = [rule("still", "deny", "'put'", "demo/**")];
        assert_eq!(
            found(&access("allow", &rules, "'still'")),
            [
                "rule `still` of access_control denies put (egress) of demo/position and 1 more keys, \
              with subjects all"
            ]
        );
        // A rule that no policy uses, and access control that is off.
        let other = [rules[0].clone(), rule("x", "deny", "'put'", "no/**")];
        assert!(found(&access("allow", &other, "'x'")).is_empty());
        let off = access("allow", &rules, "'still'").replace("enabled: true", "enabled: false");
        assert!(found(&off).is_empty());
    }

    #[test]
    fn what_no_rule_allows_is_denied_by_default() {
        let rules = [rule("read", "allow", "'put', 'declare_subscriber'", "**")];
        let told = found(&access("deny", &rules, "'read'"));
        assert_eq!(told.len(), 3, "{told:?}");
        assert!(
            told[0].starts_with("access_control denies declare_queryable (egress) of demo/goto"),
            "{told:?}"
        );
        let all = "'put', 'declare_subscriber', 'declare_queryable', 'query', 'reply'";
        let rules = [rule("all", "allow", all, "**")];
        assert!(found(&access("deny", &rules, "'all'")).is_empty());
    }
}
