//! What a client does to a robot: services, parameters, values; and not without the right to.

use genom_tests::{component, path, request};
use serde_json::{Value, json};

use super::visitor::{CALL, Client, demo};

#[test]
fn a_call_starts_an_activity_and_its_end_is_a_message() {
    let (daemon, address) = demo(CALL, &[]);
    let mut client = Client::new(&daemon, &address);
    let service = client.of_name("service", "/demo/goto");
    let schema: Value =
        serde_json::from_str(service["request"]["schema"].as_str().unwrap()).unwrap();
    assert_eq!(schema["properties"]["goal"]["anyOf"][0]["type"], "number", "{schema}");
    assert_eq!(service["request"]["schemaEncoding"], "jsonschema");
    client.of_name("subscribe", "/genom/activities");
    client.of_name("subscribe", "/demo/position");
    let answer = client.ask("call", &[json!("/demo/goto"), json!({"goal": 0.2})]);
    let activity = answer["result"]["activity"].clone();
    assert!(activity.is_u64(), "{answer}");
    let ended = json!({"event": "activity_ended", "activity": activity});
    client.ask("sample", &[json!("/genom/activities"), ended]);
    client.ask("sample", &[json!("/demo/position"), json!({"position": 0.2})]);
    let speed = client.ask("call", &[json!("/demo/get_speed"), json!({})]);
    assert_eq!(speed, json!({"result": {"velocity": 0.5}}));
}

#[test]
fn a_call_that_is_refused_says_why() {
    let (daemon, address) = demo(CALL, &[]);
    let mut client = Client::new(&daemon, &address);
    for (service, inputs, encoding, told) in [
        ("/demo/goto", json!({"goal": 100.0}), "json", "::demo::OUT_OF_RANGE"),
        ("/demo/goto", json!({"gaol": 1.0}), "json", "`goal`"),
        ("/demo/goto", json!([]), "json", "object"),
        ("/demo/goto", json!({}), "cdr", "inputs are in `json`"),
        ("/demo/abort_activity", json!({"activity": 77}), "json", "::genom::"),
    ] {
        let answer = client.ask("call", &[json!(service), inputs, json!(encoding)]);
        let failure = answer["failure"].as_str().unwrap_or_else(|| panic!("{answer}"));
        assert!(failure.contains(told), "{service}: {failure}");
    }
    let answer = client.ask("call_id", &[json!(4_000_000), json!({})]);
    assert_eq!(answer["failure"], "there is no service 4000000");
}

#[test]
fn parameters_are_the_inputs_of_attributes() {
    let (daemon, address) = demo(CALL, &[]);
    let mut client = Client::new(&daemon, &address);
    let speed = "/demo/set_speed/velocity";
    let all = client.ask("get", &[json!([])]);
    assert_eq!(all, json!([{"name": speed, "type": "float64", "value": 0.5}]));
    client.ask("watch", &[json!([speed])]);
    client.ask("parameter", &[json!(speed), json!(0.5)]);
    let set = client.ask("set", &[json!(speed), json!(2)]);
    assert_eq!((&set[0]["name"], &set[0]["type"]), (&json!(speed), &json!("float64")));
    assert_eq!(set[0]["value"], 2.0);
    assert_eq!(daemon.json(&["call", "demo", "get_speed"])["result"]["velocity"], 2.0);
    // Whoever sets it, those who watch are told.
    daemon.ctl(&["call", "demo", "set_speed", "velocity=1.25"]).expect_code(0);
    client.ask("parameter", &[json!(speed), json!(1.25)]);
    // What the component does not accept stays as it was.
    for (name, value, told) in [
        (speed, json!(1000), "/demo/set_speed/velocity was not set: ::demo::OUT_OF_RANGE"),
        (speed, json!("fast"), "/demo/set_speed/velocity was not set: "),
        ("/demo/set_sped/velocity", json!(1), "set_sped/velocity was not set: there is no such"),
        ("/demo/set_speed/velocty", json!(1), "set_speed/velocty was not set: "),
        ("/demo/goto/goal", json!(1), "/demo/goto/goal was not set: there is no such attribute"),
        ("nonsense", json!(1), "nonsense was not set: a name is /COMPONENT/ATTRIBUTE/INPUT"),
    ] {
        client.ask("set", &[json!(name), value]);
        client.is_told(told);
    }
    assert_eq!(client.ask("get", &[json!([speed])])[0]["value"], 1.25);
}

#[test]
fn a_published_value_reaches_the_codels() {
    let (daemon, address) = demo(CALL, &[]);
    let mut client = Client::new(&daemon, &address);
    let channel = client.of_name("advertise", "/demo/parameter");
    client.ask("publish", &[channel.clone(), json!(0.0)]);
    let mut events = daemon.events();
    client.ask("publish", &[channel.clone(), json!("fast")]);
    client.is_told("/demo/parameter: ");
    // The axis stands still with this gain, until there is another one.
    daemon.ctl(&["start", "demo", "goto", "goal=1"]).expect_code(0);
    let echo = daemon.spawn(&["echo", "demo/parameter"]);
    echo.line_where(|line| line == "0.0");
    client.ask("publish", &[channel, json!(0.25)]);
    echo.line_where(|line| line == "0.25");
    for (topic, encoding, told) in [
        ("/demo/parameter", "ros1", "values are published as `json` or `cdr`, not `ros1`"),
        ("/demo/parameter", "cdr", "values as `cdr` need the name of their type (`schemaName`)"),
        ("demo", "json", "the topic of an in port is /COMPONENT/PORT"),
    ] {
        client.ask("advertise", &[json!(topic), json!(encoding)]);
        client.is_told(told);
    }
    let out = client.of_name("advertise", "/demo/position");
    client.ask("publish", &[out, json!({})]);
    client.is_told("/demo/position: demo/position is an out port");
    client.ask("publish", &[json!(77), json!({})]);
    client.is_told("there is no channel 77 of this client");
    // It is a connection as any other, and can be ended.
    daemon.ctl(&["disconnect", "demo/parameter"]).expect_code(0);
    events.wait_for(|event| event["event"] == "disconnected");
}

#[test]
fn values_are_published_as_cdr_of_the_type_that_the_port_has() {
    let (daemon, address) = demo(CALL, &[]);
    let mut client = Client::new(&daemon, &address);
    let at = "/components/demo/ports/parameter/type";
    let ty = request(&daemon.home().socket(), "GET", at, "").body;
    let (name, definition) = (ty["message"]["name"].clone(), ty["message"]["definition"].clone());
    let member = definition.as_str().unwrap().split_whitespace().nth(1).unwrap().to_owned();
    let advertised = |client: &mut Client, name: &Value, definition: &Value| {
        let port = json!("/demo/parameter");
        client.ask("advertise", &[port, json!("cdr"), name.clone(), definition.clone()])
    };
    let sent = |client: &mut Client, channel: &Value, value: f64| {
        let value = json!({ &member: value });
        client.ask("publish_cdr", &[channel.clone(), value, definition.clone()]);
    };
    // The port is read only during a motion; this one is slow enough to last.
    daemon.ctl(&["call", "demo", "set_speed", "velocity=0.01"]).expect_code(0);
    daemon.ctl(&["start", "demo", "goto", "goal=1"]).expect_code(0);
    let defined = advertised(&mut client, &name, &definition);
    let named = advertised(&mut client, &name, &json!(""));
    sent(&mut client, &defined, 0.5);
    let echo = daemon.spawn(&["echo", "demo/parameter"]);
    echo.line_where(|line| line == "0.5");
    sent(&mut client, &named, 0.25);
    echo.line_where(|line| line == "0.25");
    // Another type, by its name or by what it is made of, and bytes that are no value of it.
    let other = advertised(&mut client, &json!("demo/msg/Other"), &definition);
    sent(&mut client, &other, 0.75);
    client.is_told("/demo/parameter: demo/msg/Other is not its type; the port has ");
    let otherwise = advertised(&mut client, &name, &json!(format!("uint64 {member}")));
    sent(&mut client, &otherwise, 0.75);
    client.is_told("is defined otherwise here");
    for bytes in [&[][..], &[0, 1, 0, 0], &[0, 1, 0, 0, 0, 0, 0], &[9; 12]] {
        client.ask("publish_bytes", &[named.clone(), json!(bytes)]);
    }
    // None of them came through: the next value that does is this one.
    sent(&mut client, &named, 1.5);
    assert_eq!(echo.line_where(|line| line != "0.25"), "1.5");
}

#[test]
fn without_the_right_to_call_a_client_reads_and_nothing_else() {
    let (daemon, address) = demo("", &[]);
    let mut client = Client::new(&daemon, &address);
    let info = client.ask("info", &[]);
    assert_eq!(info["capabilities"], json!(["connectionGraph"]));
    client.of_name("channel", "/demo/position");
    assert_eq!(client.ask("services", &[]), json!([]));
    // It does not help to ask all the same.
    for service in 1..40 {
        let answer = client.ask("call_id", &[json!(service), json!({"goal": 0.1})]);
        let failure = answer["failure"].as_str().unwrap_or_else(|| panic!("{answer}"));
        assert!(
            failure.contains("needs the right `call`") || failure.contains("there is no service"),
            "{failure}"
        );
    }
    client.of_name("advertise", "/demo/parameter");
    client.is_told("publishing needs the right `call`");
    client.ask("publish", &[json!(1), json!(0.0)]);
    client.is_told("there is no channel 1 of this client");
    let name = "/demo/set_speed/velocity";
    for message in [
        json!({"op": "setParameters", "parameters": [{"name": name, "value": 2.0}], "id": "a"}),
        json!({"op": "getParameters", "parameterNames": [], "id": "a"}),
        json!({"op": "subscribeParameterUpdates", "parameterNames": [name]}),
    ] {
        client.of_name("send", &message.to_string());
    }
    client.is_told("setting parameters needs the right `call`");
    client.is_told("reading parameters needs the right `call`");
    assert_eq!(daemon.json(&["call", "demo", "get_speed"])["result"]["velocity"], 0.5);
    assert_eq!(daemon.port("demo", "parameter")["connected"], Value::Null);
    assert_eq!(daemon.json(&["activities", "demo"])["activities"], json!([]));
    let (stopped, _home) = daemon.stop("TERM");
    stopped.expect_err("refused POST /components/demo/services/");
}

#[test]
fn services_of_supervisors_take_their_rights() {
    let (daemon, address) = demo(CALL, &[]);
    let mut client = Client::new(&daemon, &address);
    client.of_name("service", "/demo/goto");
    let offered = client.ask("services", &[]);
    let offered: Vec<_> = offered.as_array().unwrap().iter().filter_map(Value::as_str).collect();
    assert!(offered.contains(&"/demo/abort_activity"), "{offered:?}");
    for of_others in ["/demo/kill", "/demo/connect_port", "/demo/connect_service"] {
        assert!(!offered.contains(&of_others), "{offered:?}");
    }
    for service in 1..40 {
        client.ask("call_id", &[json!(service), json!({})]);
    }
    assert_eq!(daemon.json(&["list"])["components"][0]["name"], "demo", "it was not killed");
}

#[test]
fn components_in_cells_are_commanded_the_same() {
    let rust = component("demo-rs");
    let (daemon, address) = demo(CALL, &[]);
    daemon.ctl(&["load", "--name", "apart", "--cell", "apart", path(&rust.library)]).expect_code(0);
    let mut client = Client::new(&daemon, &address);
    client.of_name("subscribe", "/apart/position");
    client.of_name("subscribe", "/genom/activities");
    let answer = client.ask("call", &[json!("/apart/goto"), json!({"goal": 0.1})]);
    let ended = json!({
        "event": "activity_ended", "component": "apart", "activity": answer["result"]["activity"],
    });
    client.ask("sample", &[json!("/genom/activities"), ended]);
    client.ask("sample", &[json!("/apart/position"), json!({"position": 0.1})]);
    let channel = client.of_name("advertise", "/apart/parameter");
    client.ask("publish", &[channel, json!(0.5)]);
    client.ask("call", &[json!("/apart/goto"), json!({"goal": 1.0})]);
    let echo = daemon.spawn(&["echo", "apart/parameter"]);
    echo.line_where(|line| line == "0.5");
}
