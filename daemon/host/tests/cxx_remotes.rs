//! Remotes as codels in C++ see them (genom3.md 5.8, 6), with a fake of the other component.

#![allow(clippy::expect_used, clippy::panic, clippy::unwrap_used)] // helpers are no test functions

mod support;

use genom_description::model::{Ix as _, RemoteIx};
use genom_runtime::body::{Body, RemoteCall};
use genom_types::Record;
use serde_json::{Value, json};
use support::cxx::{compile, load, refusal};

const TEXT: &str = r#"
interface other {
  exception TOO_LONG { long limit; string what; sequence<long> tried; };
  exception CLOSED;
  exception UNSEEN { string why; };
  function join(in double scale, in string first, in sequence<string> rest, in octet pad[2],
                inout sequence<double> values, out string joined) {
    throw TOO_LONG, CLOSED, UNSEEN;
  };
};
component demo {
  lang "c++";
  uses other;
  task main;
  activity ask(in string first, out string joined, out sequence<double> values) {
    task main;
    async codel<start> ask_start(in first, remote in join, out joined, out values) yield ether;
    throw other::TOO_LONG, other::CLOSED, other::UNSEEN, genom::no_such_service;
  };
};
"#;

const CODELS: &str = r#"
genom::event ask_start(const std::string &first, demo::join &join, std::string &joined,
    std::vector<double> &values) {
  const uint8_t pad[2] = { 3, 4 };
  values.assign(3, 0.5);
  joined = "a value of before, which goes";
  try {
    join.call(2., first, std::vector<std::string>(2, std::string(30, 'r')), pad, values, joined);
  } catch (const other::TOO_LONG &e) {
    if (e.detail.tried.size() > 1) throw;
    joined = e.detail.what + "; " + e.what();
  } catch (const genom::unkex &e) {
    joined = e.detail.what;
  }
  return demo::ether;
}
"#;

/// The other component: the first string decides what it does.
struct Fake;

impl RemoteCall for Fake {
    fn call(&mut self, input: &Record, output: &mut Record) -> Result<(), (String, Value)> {
        let input = input.to_json();
        let what = "a text that no small string of the C++ library holds";
        let too_long = |tried: &[i32]| {
            let detail = json!({ "limit": 3, "what": what, "tried": tried });
            Err(("::other::TOO_LONG".to_owned(), detail))
        };
        match input["first"].as_str().unwrap() {
            "long" => too_long(&[1]),
            "longer" => too_long(&[1, 2]),
            "closed" => Err(("::other::CLOSED".to_owned(), Value::Null)),
            "unseen" => Err(("::other::UNSEEN".to_owned(), json!({ "why": what }))),
            "odd" => Err(("::foreign::EXCEPTION".to_owned(), Value::Null)),
            _ => {
                assert_eq!(input["rest"], json!(["r".repeat(30), "r".repeat(30)]));
                assert_eq!((&input["scale"], &input["pad"]), (&json!(2.0), &json!([3, 4])));
                let mut values = input["values"].as_array().unwrap().clone();
                values.push(json!(9.0));
                let joined = format!("{} joined", input["first"].as_str().unwrap());
                output.merge_json(&json!({ "values": values, "joined": joined })).unwrap();
                Ok(())
            }
        }
    }
}

#[test]
fn a_remote_takes_arguments_gives_outputs_and_throws() {
    let compiled = compile(TEXT, CODELS, &["-O2", "-femit-class-debug-always"]);
    let demo = load(&compiled, TEXT);
    let ask = |first: &str| {
        let mut frame = demo.begin("ask", json!({ "first": first }));
        let event = demo.call(&mut *frame, "ask_start");
        (event, frame.detail().unwrap_or_default(), frame.output().to_json()["joined"].clone())
    };
    // It can be called only once a supervisor has connected it.
    assert_eq!(ask("one").0, "::genom::no_such_service");
    demo.component.bind_remote(RemoteIx::new(0), Some(Box::new(Fake)));

    let mut frame = demo.begin("ask", json!({ "first": "one" }));
    assert_eq!(demo.call(&mut *frame, "ask_start"), "::demo::ether");
    let output = json!({ "joined": "one joined", "values": [0.5, 0.5, 0.5, 9.0] });
    assert_eq!(frame.output().to_json(), output);

    let what = "a text that no small string of the C++ library holds";
    // Caught, rethrown, and not caught; the codels have no type for the last one.
    let (event, _, joined) = ask("long");
    assert_eq!(
        (event.as_str(), joined),
        ("::demo::ether", json!(format!("{what}; ::other::TOO_LONG")))
    );
    let (event, detail, _) = ask("longer");
    assert_eq!(event, "::other::TOO_LONG");
    assert_eq!(detail, json!({ "limit": 3, "what": what, "tried": [1, 2] }));
    let (event, detail, _) = ask("unseen");
    assert_eq!((event.as_str(), detail), ("::other::UNSEEN", json!({ "why": what })));
    assert_eq!(ask("closed").0, "::other::CLOSED");
    let (event, _, joined) = ask("odd");
    assert_eq!((event.as_str(), joined), ("::demo::ether", json!("::foreign::EXCEPTION")));

    // Many in a row: nothing of one call affects the next.
    for _ in 0..100 {
        assert_eq!(ask("long").0, "::demo::ether");
        assert_eq!(ask("longer").0, "::other::TOO_LONG");
    }

    demo.component.bind_remote(RemoteIx::new(0), None);
    assert_eq!(ask("one").0, "::genom::no_such_service");

    let differs = TEXT.replace("in double scale", "in float scale");
    let told = refusal(&compiled, &differs);
    let why = "argument 2 `join`: argument `scale` of its call: `float` is wanted, not `double`";
    assert!(told.contains(why), "{told}");
}
