//! `genomctl pub`: publishes a value to an in port.

use clap_complete::engine::ArgValueCompleter;
use genom_protocol::{Address, Published, routes};
use serde_json::Value;

use crate::complete::Names;
use crate::failure::Failure;
use crate::inputs;
use crate::names::{address, element};
use crate::session::Session;

/// Publish a value to an in port.
///
/// The port reads values published this way until it is disconnected, or connected to an out port.
/// Members that are left out keep the value published last, zero at first.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// The in port: COMPONENT/PORT or COMPONENT/PORT/ELEMENT.
    #[arg(value_parser = address, add = ArgValueCompleter::from(Names::Inports))]
    port: Address,
    /// The value: 0.5, '{"position": 1.0}' or position=1.0.
    #[arg(required = true, allow_negative_numbers = true)]
    value: Vec<String>,
}

pub(super) async fn run(args: Args, session: &Session) -> Result<(), Failure> {
    let route = routes::publish(&args.port.component, &args.port.port).with(&element(&args.port));
    let reply = session.send(route, &value(&args.value)?).await?;
    session.show(&reply, |reply: &Published| format!("{} = {}\n", reply.address, reply.value))
}

/// A single word of JSON is the whole value; otherwise `key=value` words are members.
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
