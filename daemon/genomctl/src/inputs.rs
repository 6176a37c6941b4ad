//! Inputs of a service, typed as JSON or as `key=value` words.

use serde_json::{Map, Value};

use crate::failure::Failure;

/// The inputs as JSON: `{}` if nothing was typed, a JSON object, or `key=value` pairs.
///
/// A key may have a path: `pose.x=1`, `gains.2=0.5`. A value that is not JSON is taken as a string.
pub(crate) fn parse(words: &[String]) -> Result<Value, Failure> {
    let mut inputs = Map::new();
    for word in words {
        if word.trim_start().starts_with('{') {
            merge_object(&mut inputs, word)?;
        } else if let Some((key, value)) = word.split_once('=') {
            let value = serde_json::from_str(value).unwrap_or_else(|_| value.into());
            set(&mut inputs, key, value)
                .map_err(|()| usage(format!("`{key}` is given twice, or goes into a value")))?;
        } else {
            return Err(usage(format!("`{word}` is neither JSON nor key=value")));
        }
    }
    Ok(Value::Object(inputs))
}

fn merge_object(inputs: &mut Map<String, Value>, word: &str) -> Result<(), Failure> {
    match serde_json::from_str::<Map<String, Value>>(word) {
        Ok(object) => {
            inputs.extend(object);
            Ok(())
        }
        Err(error) => Err(usage(format!("`{word}` is no JSON object: {error}"))),
    }
}

/// Sets `value` at the dotted key; fails if there is a value already.
fn set(inputs: &mut Map<String, Value>, key: &str, value: Value) -> Result<(), ()> {
    match key.split_once('.') {
        None if inputs.contains_key(key) => Err(()),
        None => {
            inputs.insert(key.to_owned(), value);
            Ok(())
        }
        Some((head, rest)) => {
            let inner = inputs.entry(head).or_insert_with(|| Value::Object(Map::new()));
            set(inner.as_object_mut().ok_or(())?, rest, value)
        }
    }
}

fn usage(message: String) -> Failure {
    Failure::usage(message, "write '{\"goal\": 1.0}' or goal=1.0")
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    fn check(words: &[&str], expected: Result<Value, ()>) {
        let words: Vec<String> = words.iter().map(|&word| word.to_owned()).collect();
        assert_eq!(parse(&words).map_err(|_| ()), expected);
    }

    #[test]
    fn inputs_are_json_or_pairs() {
        check(&[], Ok(json!({})));
        check(&["{\"goal\": 1.5}"], Ok(json!({"goal": 1.5})));
        check(&["goal=1.5", "mode=fast"], Ok(json!({"goal": 1.5, "mode": "fast"})));
        check(&["pose.x=1", "pose.y=2"], Ok(json!({"pose": {"x": 1, "y": 2}})));
    }

    #[test]
    fn nonsense_is_refused() {
        check(&["goal"], Err(()));
        check(&["{goal}"], Err(()));
        check(&["goal=1", "goal=2"], Err(()));
        check(&["goal=1", "goal.x=2"], Err(()));
    }
}
