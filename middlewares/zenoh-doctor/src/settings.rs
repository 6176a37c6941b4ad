//! Reads settings of a zenoh configuration.

use serde_json::Value;
use zenoh::Config;

/// A setting; null if it has none.
pub(crate) fn get(config: &Config, key: &str) -> Value {
    let text = config.get_json(key).unwrap_or_default();
    serde_json::from_str(&text).unwrap_or_default()
}

/// The text of a setting, unless it is empty.
pub(crate) fn text(config: &Config, key: &str) -> Option<String> {
    get(config, key).as_str().filter(|text| !text.is_empty()).map(str::to_owned)
}

/// `peer`, `client` or `router`.
pub(crate) fn mode(config: &Config) -> String {
    text(config, "mode").unwrap_or_else(|| "peer".to_owned())
}

/// The endpoints below `connect` or `listen`: a list, perhaps of lists, or one such for each mode.
pub(crate) fn endpoints(config: &Config, section: &str) -> Vec<String> {
    let all = get(config, &format!("{section}/endpoints"));
    let mut found = Vec::new();
    collect(all.get(mode(config)).unwrap_or(&all), &mut found);
    found
}

fn collect(value: &Value, found: &mut Vec<String>) {
    match value {
        Value::String(endpoint) => found.push(endpoint.clone()),
        Value::Array(all) => all.iter().for_each(|one| collect(one, found)),
        // One of several, as zenoh spells it.
        Value::Object(all) => {
            all.values().filter(|one| one.is_array()).for_each(|one| collect(one, found));
        }
        _ => {}
    }
}

/// An endpoint without its metadata and settings.
pub(crate) fn locator(endpoint: &str) -> &str {
    endpoint.split(['?', '#']).next().unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn endpoints_are_those_of_the_mode_in_whatever_form() {
        let mut config = Config::default();
        for (given, expected) in [
            (r#"["tcp/h:1", "tcp/h:2"]"#, &["tcp/h:1", "tcp/h:2"][..]),
            (r#"{ peer: ["tcp/h:1"], router: ["tcp/h:2"] }"#, &["tcp/h:1"]),
            ("[]", &[]),
        ] {
            config.insert_json5("connect/endpoints", given).unwrap();
            assert_eq!(endpoints(&config, "connect"), expected, "{given}");
        }
    }
}
