//! Asks for the inputs of a service one by one, if none were typed and both standard input and
//! output are terminals. The daemon decides whether an answer is valid.

use std::io::{self, BufRead, Write};

use genom_protocol::{CallParameters, CallReply, Code, Inputs, Parameter, Reason, Service, routes};
use serde_json::{Map, Value};

use crate::failure::Failure;
use crate::session::{Reply, Session};
use crate::{inputs, terminal};

/// How many times one input is asked for.
const TRIES: u32 = 3;

/// Calls a service with the inputs typed or, if there are none, with the user's answers. An answer
/// that the daemon refuses is asked for again. With `{}` nothing is asked for.
pub(crate) async fn call(
    session: &Session,
    component: &str,
    service: &str,
    words: &[String],
    zero: bool,
) -> Result<Reply<CallReply>, Failure> {
    let query = CallParameters { zero, ..CallParameters::default() };
    let call = || routes::call(component, service).with(&query);
    if !words.is_empty() || session.json || !terminal::somebody_there() {
        return session.send(call(), &Inputs(inputs::parse(words)?)).await;
    }
    let described = session.ask(routes::service(component, service)).await?.content;
    let mut form = Form::new(described);
    form.fill(&mut io::stdin().lock(), &mut io::stderr().lock())?;
    loop {
        match session.send(call(), &Inputs(form.given())).await {
            Err(Failure::Refused(reason)) if reason.is(Code::BadInput) => {
                form.mend(reason, &mut io::stdin().lock(), &mut io::stderr().lock())?;
            }
            answer => return answer,
        }
    }
}

/// The inputs of a service, and the answers so far.
struct Form {
    /// Each input, and how many times it was asked for.
    parameters: Vec<(Parameter, u32)>,
    given: Map<String, Value>,
}

impl Form {
    fn new(service: Service) -> Self {
        let inputs = service.parameters.into_iter().filter(|one| one.direction.is_input());
        Self { parameters: inputs.map(|one| (one, 0)).collect(), given: Map::new() }
    }

    fn given(&self) -> Value {
        Value::Object(self.given.clone())
    }

    /// Asks for each input; an empty answer takes the value shown.
    fn fill(&mut self, answers: &mut impl BufRead, out: &mut impl Write) -> Result<(), Failure> {
        let Self { parameters, given } = self;
        parameters.iter_mut().try_for_each(|asked| ask(asked, given, answers, out))
    }

    /// Asks again for the input that was refused. Fails with the refusal if it concerns none of
    /// them, or too many times the same one.
    fn mend(
        &mut self,
        refusal: Reason,
        answers: &mut impl BufRead,
        out: &mut impl Write,
    ) -> Result<(), Failure> {
        // A JSON pointer, possibly to a part of the value.
        let name =
            refusal.place.as_deref().and_then(|place| place.strip_prefix('/')?.split('/').next());
        let refused = self.parameters.iter_mut().find(|(one, _)| Some(one.name.as_str()) == name);
        match refused.filter(|(_, asked)| *asked < TRIES) {
            None => Err(Failure::Refused(refusal)),
            Some(refused) => {
                writeln!(out, "{}", refusal.message)?;
                ask(refused, &mut self.given, answers, out)
            }
        }
    }
}

fn ask(
    (parameter, asked): &mut (Parameter, u32),
    given: &mut Map<String, Value>,
    answers: &mut impl BufRead,
    out: &mut impl Write,
) -> Result<(), Failure> {
    *asked += 1;
    let Parameter { name, ty, doc, default, current, .. } = parameter;
    let doc = doc.as_ref().map_or_else(String::new, |doc| format!(", {}", doc.trim()));
    // The value that an empty answer takes: the present one for an attribute, else the default.
    let shown = current.as_ref().or(default.as_ref());
    let shown = shown.map_or_else(String::new, |shown| format!(" [{shown}]"));
    write!(out, "{name} ({ty}{doc}){shown}: ")?;
    out.flush()?;
    let mut answer = String::new();
    if answers.read_line(&mut answer)? == 0 {
        writeln!(out)?;
        let message = format!("no answer for {name}: nothing was started");
        return Err(Failure::usage(message, "write '{}' to leave all out"));
    }
    let answer = answer.trim();
    if answer.is_empty() {
        given.remove(name);
    } else {
        // An answer that is not JSON is taken as text, as in `key=value`.
        let value = serde_json::from_str(answer).unwrap_or_else(|_| answer.into());
        given.insert(name.clone(), value);
    }
    Ok(())
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
        serde_json::from_value(json!({
            "name": "goto", "kind": "activity", "parameters": parameters,
        }))
        .unwrap()
    }

    /// The inputs that result from these answers, and the questions.
    fn filled(answers: &str) -> (Value, String) {
        let (mut form, mut asked) = (Form::new(service()), Vec::new());
        form.fill(&mut answers.as_bytes(), &mut asked).unwrap();
        (form.given(), String::from_utf8(asked).unwrap())
    }

    #[test]
    fn inputs_are_asked_with_their_documentation_and_defaults() {
        let (given, asked) = filled("\nfast\n");
        assert_eq!(given, json!({"mode": "fast"}));
        assert_eq!(asked, "goal (double, m) [1.0]: mode (double, m): ");
        let (given, _) = filled("0.5\n{\"a\": 1}\n");
        assert_eq!(given, json!({"goal": 0.5, "mode": {"a": 1}}));
    }

    #[test]
    fn the_end_of_input_sends_nothing() {
        let mut form = Form::new(service());
        let ended = form.fill(&mut "1\n".as_bytes(), &mut Vec::new()).unwrap_err();
        assert!(matches!(ended, Failure::Usage { .. }), "{ended}");
    }

    #[test]
    fn a_refused_answer_is_asked_for_again_but_not_for_ever() {
        let refusal = |place: &str| -> Reason {
            let refusal = json!({"code": "bad_input", "message": "no number", "where": place});
            serde_json::from_value(refusal).unwrap()
        };
        let mut form = Form::new(service());
        form.fill(&mut "x\n2\n".as_bytes(), &mut Vec::new()).unwrap();
        let mut asked = Vec::new();
        form.mend(refusal("/goal/x"), &mut "y\n".as_bytes(), &mut asked).unwrap();
        assert_eq!(String::from_utf8(asked).unwrap(), "no number\ngoal (double, m) [1.0]: ");
        assert_eq!(form.given(), json!({"goal": "y", "mode": 2}));
        // An empty answer, which takes the default.
        form.mend(refusal("/goal"), &mut "\n".as_bytes(), &mut Vec::new()).unwrap();
        assert_eq!(form.given(), json!({"mode": 2}));
        for place in ["/goal", "/other", ""] {
            let given_up = form.mend(refusal(place), &mut "1\n".as_bytes(), &mut Vec::new());
            assert!(matches!(given_up, Err(Failure::Refused(_))), "{place}");
        }
        let ended = form.mend(refusal("/mode"), &mut "".as_bytes(), &mut Vec::new());
        assert!(matches!(ended, Err(Failure::Usage { .. })));
    }
}
