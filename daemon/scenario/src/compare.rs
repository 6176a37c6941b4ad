//! Compares values with what they have to be.

use serde_json::Value;

/// A part of a value that is not what it has to be.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Difference {
    /// Where in the value: `current.position`, `points[3].x`; empty for the whole.
    pub(crate) path: String,
    /// What it has to be.
    pub(crate) expected: Value,
    /// What it is; `None` if there is no such part.
    pub(crate) found: Option<Value>,
}

/// All parts of `found` that differ from `expected`.
///
/// Members of a table that are not expected may have any value; arrays have the same length. Two
/// numbers are the same if they differ by `tolerance` at most.
pub(crate) fn differences(expected: &Value, found: &Value, tolerance: f64) -> Vec<Difference> {
    let mut all = Vec::new();
    walk(String::new(), expected, Some(found), tolerance, &mut all);
    all
}

fn walk(
    path: String,
    expected: &Value,
    found: Option<&Value>,
    tolerance: f64,
    all: &mut Vec<Difference>,
) {
    match (expected, found) {
        (Value::Object(wanted), Some(Value::Object(found))) => {
            for (key, expected) in wanted {
                let dot = if path.is_empty() { "" } else { "." };
                walk(format!("{path}{dot}{key}"), expected, found.get(key), tolerance, all);
            }
        }
        (Value::Array(wanted), Some(Value::Array(found))) if wanted.len() == found.len() => {
            for (at, (expected, found)) in wanted.iter().zip(found).enumerate() {
                walk(format!("{path}[{at}]"), expected, Some(found), tolerance, all);
            }
        }
        (expected, found) => {
            if !found.is_some_and(|found| same(expected, found, tolerance)) {
                let (expected, found) = (expected.clone(), found.cloned());
                all.push(Difference { path, expected, found });
            }
        }
    }
}

fn same(expected: &Value, found: &Value, tolerance: f64) -> bool {
    match (expected, found) {
        (Value::Number(a), Value::Number(b)) => {
            let whole = |number: &serde_json::Number| {
                number.as_i64().map(i128::from).or(number.as_u64().map(i128::from))
            };
            // Large whole numbers are not all numbers of floating point.
            if let (Some(a), Some(b)) = (whole(a), whole(b))
                && tolerance == 0.0
            {
                return a == b;
            }
            let (a, b) = (a.as_f64().unwrap_or(f64::NAN), b.as_f64().unwrap_or(f64::NAN));
            (a - b).abs() <= tolerance
        }
        _ => expected == found,
    }
}

/// The parts that were expected, and what they are.
pub(crate) fn told(differences: &[Difference], tolerance: f64) -> (String, String) {
    let named = |path: &str, what: String| match path {
        "" => what,
        path => format!("{path} = {what}"),
    };
    let expected = differences.iter().map(|one| {
        let within = match one.expected.is_number() && tolerance > 0.0 {
            true => format!(" within {tolerance}"),
            false => String::new(),
        };
        named(&one.path, format!("{}{within}", one.expected))
    });
    let found = differences.iter().map(|one| {
        let found = one.found.as_ref().map(Value::to_string);
        named(&one.path, found.unwrap_or_else(|| "(nothing)".to_owned()))
    });
    (expected.collect::<Vec<_>>().join(", "), found.collect::<Vec<_>>().join(", "))
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[track_caller]
    fn check(expected: Value, found: Value, tolerance: f64, paths: &[&str]) {
        let all = differences(&expected, &found, tolerance);
        let found: Vec<&str> = all.iter().map(|one| one.path.as_str()).collect();
        assert_eq!(found, paths);
    }

    #[test]
    fn numbers_are_the_same_within_the_tolerance_and_no_further() {
        check(json!(1.0), json!(1), 0.0, &[]);
        check(json!(1.0), json!(1.5), 0.5, &[]);
        check(json!(1.0), json!(1.500001), 0.5, &[""]);
        check(json!(-1), json!(1), 1.9, &[""]);
        check(json!(9_007_199_254_740_993_u64), json!(9_007_199_254_740_992_u64), 0.0, &[""]);
        check(json!(u64::MAX), json!(u64::MAX - 1), 1.0, &[]);
        check(json!(-1), json!(u64::MAX), 0.0, &[""]);
    }

    #[test]
    fn what_is_not_a_number_is_compared_as_it_is() {
        check(json!("inf"), json!("inf"), 0.0, &[]);
        check(json!("inf"), json!("-inf"), 1e300, &[""]);
        check(json!(null), json!(null), 0.0, &[]);
        check(json!(null), json!(0.0), 1.0, &[""]);
        check(json!(true), json!(1), 1.0, &[""]);
        check(json!("RED"), json!("red"), 0.0, &[""]);
    }

    #[test]
    fn only_expected_members_count_and_all_elements() {
        let found = json!({"a": {"b": [1, 2], "c": 3}, "d": 4});
        check(json!({"a": {"b": [1, 2]}}), found.clone(), 0.0, &[]);
        check(
            json!({"a": {"b": [1, 3], "c": 0}, "e": 1}),
            found.clone(),
            0.0,
            &["a.b[1]", "a.c", "e"],
        );
        check(json!({"a": {"b": [1]}}), found.clone(), 9.0, &["a.b"]);
        check(json!({"a": 1}), found, 0.0, &["a"]);
        check(json!({}), json!([]), 0.0, &[""]);
    }

    #[test]
    fn differences_are_told_with_their_places() {
        let all = differences(&json!({"x": 1, "y": "a"}), &json!({"x": 2.5}), 0.1);
        let (expected, found) = told(&all, 0.1);
        assert_eq!(expected, r#"x = 1 within 0.1, y = "a""#);
        assert_eq!(found, "x = 2.5, y = (nothing)");
    }
}
