//! Asks for the inputs of a service, one by one, when nothing was typed and somebody is there.

use std::io::{self, BufRead, Write};

use serde::Deserialize;
use serde_json::{Map, Value};

use crate::failure::Failure;
use crate::names::url;
use crate::parameter::Parameter;
use crate::session::Session;
use crate::{inputs, terminal};

#[derive(Debug, Deserialize)]
struct Service {
    parameters: Vec<Parameter>,
}

/// The inputs typed; or what somebody answers, when none were. `{}` takes all defaults unasked.
pub(crate) async fn inputs(
    session: &Session,
    component: &str,
    service: &str,
    words: &[String],
) -> Result<Value, Failure> {
    if !words.is_empty() || session.json || !terminal::somebody_there() {
        return inputs::parse(words);
    }
    let reply = session.get(&url(["components", component, "services", service])).await?;
    let described: Service = session.read(reply)?;
    ask(&described, &mut io::stdin().lock(), &mut io::stderr().lock())
}

/// Asks for each; an empty answer takes the default.
fn ask(
    service: &Service,
    answers: &mut impl BufRead,
    out: &mut impl Write,
) -> Result<Value, Failure> {
    let mut given = Map::new();
    for parameter in service.parameters.iter().filter(|one| one.direction != "out") {
        let Parameter { name, ty, doc, default, .. } = parameter;
        let doc = doc.as_ref().map_or_else(String::new, |doc| format!(", {}", doc.trim()));
        let shown = default.as_ref().map_or_else(String::new, |default| format!(" [{default}]"));
        write!(out, "{name} ({ty}{doc}){shown}: ")?;
        out.flush()?;
        let mut answer = String::new();
        if answers.read_line(&mut answer)? == 0 {
            writeln!(out)?;
            let message = format!("no answer for {name}: nothing was sent");
            return Err(Failure::usage(message, "write '{}' to take all defaults"));
        }
        let answer = answer.trim();
        if !answer.is_empty() {
            // What is no JSON is text, as in key=value.
            let value = serde_json::from_str(answer).unwrap_or_else(|_| answer.into());
            given.insert(name.clone(), value);
        }
    }
    Ok(Value::Object(given))
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    fn service() -> Service {
        let parameter = |name: &str, direction: &str, default: Value| {
            json!({"name": name, "direction": direction, "type": "double", "doc": "m",
                   "default": default})
        };
        let parameters = [
            parameter("goal", "in", json!(1.0)),
            parameter("x", "out", json!(2.0)),
            parameter("mode", "inout", Value::Null),
        ];
        serde_json::from_value(json!({ "parameters": parameters })).unwrap()
    }

    #[test]
    fn inputs_are_asked_with_their_documentation_and_defaults() {
        let mut asked = Vec::new();
        let given = ask(&service(), &mut "\nfast\n".as_bytes(), &mut asked).unwrap();
        assert_eq!(given, json!({"mode": "fast"}));
        let asked = String::from_utf8(asked).unwrap();
        assert_eq!(asked, "goal (double, m) [1.0]: mode (double, m): ");
        let given = ask(&service(), &mut "0.5\n{\"a\": 1}\n".as_bytes(), &mut Vec::new()).unwrap();
        assert_eq!(given, json!({"goal": 0.5, "mode": {"a": 1}}));
    }

    #[test]
    fn the_end_of_input_sends_nothing() {
        assert!(ask(&service(), &mut "1\n".as_bytes(), &mut Vec::new()).is_err());
    }
}
