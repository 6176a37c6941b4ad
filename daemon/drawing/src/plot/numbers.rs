//! The numbers in a value, which can be plotted.

use serde_json::Value;

/// The numbers in a value, with the path of each: `pose.x`, `samples.0`.
pub fn numbers(value: &Value, path: &str, to: &mut Vec<(String, f64)>) {
    let within = |name: &str| match path {
        "" => name.to_owned(),
        path => format!("{path}.{name}"),
    };
    match value {
        Value::Number(number) => to.extend(number.as_f64().map(|it| (path.to_owned(), it))),
        Value::Bool(on) => to.push((path.to_owned(), f64::from(u8::from(*on)))),
        Value::Array(all) => {
            for (index, one) in all.iter().enumerate() {
                numbers(one, &within(&index.to_string()), to);
            }
        }
        Value::Object(all) => all.iter().for_each(|(name, one)| numbers(one, &within(name), to)),
        Value::Null | Value::String(_) => {}
    }
}

/// The number at a path; not a number where there is none.
#[must_use]
pub fn number(value: &Value, path: &str) -> f64 {
    let step = |at: &Value, step: &str| match at {
        Value::Array(all) => step.parse().ok().and_then(|index: usize| all.get(index)).cloned(),
        at => at.get(step).cloned(),
    };
    let mut at = value.clone();
    for part in path.split('.').filter(|part| !part.is_empty()) {
        match step(&at, part) {
            Some(next) => at = next,
            None => return f64::NAN,
        }
    }
    match at {
        Value::Bool(on) => f64::from(u8::from(on)),
        at => at.as_f64().unwrap_or(f64::NAN),
    }
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    #[test]
    fn numbers_are_found_with_their_paths() {
        let value = json!({"pose": {"x": 1.5, "name": "a"}, "on": true, "all": [3, null]});
        let mut found = Vec::new();
        numbers(&value, "", &mut found);
        let wanted = [("pose.x", 1.5), ("on", 1.0), ("all.0", 3.0)];
        assert_eq!(found, wanted.map(|(path, it)| (path.to_owned(), it)));
        for (path, it) in wanted {
            assert_eq!(number(&value, path), it);
        }
        assert_eq!(number(&json!(7), ""), 7.0);
        assert!(number(&value, "pose.y").is_nan() && number(&value, "pose.name").is_nan());
    }
}
