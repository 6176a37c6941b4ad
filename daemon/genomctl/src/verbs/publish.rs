//! `genomctl pub`: a value to an in port, from outside.

use clap_complete::engine::ArgValueCompleter;
use serde::Deserialize;
use serde_json::Value;

use crate::complete::Names;
use crate::failure::Failure;
use crate::inputs;
use crate::names::{Path2, encode, url};
use crate::session::Session;

/// Publish a value to an in port.
///
/// The port is connected to what is published this way, until it is connected to an out port or
/// disconnected. Members that are left out keep the value published last, at first zero.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// The in port: COMPONENT/PORT or COMPONENT/PORT/ELEMENT.
    #[arg(add = ArgValueCompleter::from(Names::Inports))]
    port: Path2,
    /// The value: 0.5, '{"position": 1.0}' or position=1.0.
    #[arg(required = true, allow_negative_numbers = true)]
    value: Vec<String>,
}

#[derive(Debug, Deserialize)]
struct Reply {
    address: String,
    value: Value,
}

pub(super) async fn run(args: Args, session: &Session) -> Result<(), Failure> {
    let (port, element) = args.port.port();
    let mut path = url(["components", &args.port.component, "ports", port]);
    if let Some(element) = element {
        path.push_str(&format!("?element={}", encode(element)));
    }
    let reply = session.post(&path, &value(&args.value)?).await?;
    session.show(reply, |reply: &Reply| format!("{} = {}\n", reply.address, reply.value))
}

/// One word of JSON is the value itself; else `key=value` words are members.
fn value(words: &[String]) -> Result<Value, Failure> {
    match words {
        [word] => match serde_json::from_str(word) {
            Ok(value) => Ok(value),
            Err(_) if word.contains('=') => inputs::parse(words),
            Err(_) => Ok(Value::from(word.as_str())),
        },
        words => inputs::parse(words),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn a_value_is_json_or_members_or_text() {
        let check = |words: &[&str], expected: Value| {
            let words: Vec<String> = words.iter().map(|&word| word.to_owned()).collect();
            assert_eq!(value(&words).unwrap(), expected);
        };
        check(&["0.5"], json!(0.5));
        check(&["[1, 2]"], json!([1, 2]));
        check(&["RED"], json!("RED"));
        check(&["x=1", "y.z=2"], json!({"x": 1, "y": {"z": 2}}));
    }
}
