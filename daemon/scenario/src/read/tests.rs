//! Files that are right, and what is told of those that are not.

use expect_test::{Expect, expect};

use super::*;

#[track_caller]
fn check(text: &str, told: Expect) {
    let mistakes = Suite::read(Path::new("tests/a.toml"), text).unwrap_err();
    told.assert_eq(&mistakes.drawn());
}

/// A file with these steps.
fn steps(steps: &str) -> String {
    format!("[[scenario]]\nname = \"a\"\nsteps = [\n{steps}\n]\n")
}

#[test]
fn all_that_a_scenario_can_say_is_read() {
    let text = r#"
        deployment = "robot.toml"
        backend = "shm"
        path = ["../build"]
        components = ["demo"]

        [[scenario]]
        name = "everything"
        components = [{ library = "demo", name = "other", cell = "arm" }]
        connections = [{ in = "demo/parameter", out = "mission/gain" }]

        [[scenario.steps]]
        load = { library = "./demo.so", name = "third" }
        [[scenario.steps]]
        unload = "third"
        [[scenario.steps]]
        connect = "demo/parameter"
        to = "mission/gain"
        policy = "queue:4"
        [[scenario.steps]]
        disconnect = "demo/parameter"
        [[scenario.steps]]
        step = "10ms"
        [[scenario.steps]]
        publish = "demo/parameter"
        value = 0.5
        [[scenario.steps]]
        call = "demo/set_speed"
        inputs = { velocity = inf }
        throws = "::demo::OUT_OF_RANGE"
        detail = { value = inf, upper = 1 }
        tolerance = 1e-9
        [[scenario.steps]]
        start = "demo/goto"
        inputs.goal = 0x10
        as = "motion"
        [[scenario.steps]]
        fire = "demo/emergency"
        [[scenario.steps]]
        abort = "motion"
        [[scenario.steps]]
        wait = "demo/goto"
        within = "5s"
        takes = { least = "1s", most = "2s" }
        [[scenario.steps]]
        wait = "motion"
        result = {}
        takes = "1s"
        [[scenario.steps]]
        expect = "demo/position"
        value = { position = nan }
        samples = 3
        [[scenario.steps]]
        expect = "motion"
        states = ["main", "stop"]
        running = false
        [[scenario.steps]]
        expect = "demo"
        codels = { demo_servo = 3 }
        missed = 0
        state = "running"
        [[scenario.steps]]
        expect = "demo"
        codels = ["demo_servo"]
        [[scenario.steps]]
        fault = "demo/parameter"
        corrupt = { velocity = 9 }
        every = 2
        samples = 3
        [[scenario.steps]]
        repair = "demo/parameter"
        [[scenario.steps]]
        kill = "arm"
    "#;
    let suite = Suite::read(Path::new("/robot/tests/a.toml"), text).unwrap();
    let [scenario] = &suite.scenarios[..] else { panic!("one scenario") };
    assert_eq!(scenario.place.line, 7);
    assert_eq!(scenario.setup.components.len(), 2);
    let told: Vec<String> =
        scenario.steps.iter().map(|step| format!("{:?}", step.action)).collect();
    expect![[r#"
        Load(LoadRequest { library: "/robot/tests/demo.so", gen_file: None, name: Some("third"), daemon: None, backend: None, after: [], ports: {}, cell: None, restart: OnFailure, snapshot: None, restore: Ids, on_failure: [], supervision: [], qos: QosEntry { reliable: None, depth: None, transient_local: None, ports: {} }, remap: [], tasks: {}, attributes: {}, instead: None, resume: None })
        Unload("third")
        Connect(ConnectionRequest { inport: "demo/parameter", outport: "mission/gain", policy: Some("queue:4"), over: None, wait: false })
        Disconnect(Address { component: "demo", port: "parameter", element: None })
        Advance(10000000)
        Publish { port: Address { component: "demo", port: "parameter", element: None }, value: Number(0.5) }
        Call { service: Address { component: "demo", port: "set_speed", element: None }, inputs: Object {"velocity": String("inf")}, ended: Ended { within: 60000000000, result: None, throws: Some("::demo::OUT_OF_RANGE"), detail: Some(Object {"upper": Number(1), "value": String("inf")}), tolerance: 1e-9, takes: None } }
        Start { service: Address { component: "demo", port: "goto", element: None }, inputs: Object {"goal": Number(16)}, label: "motion" }
        Fire { component: "demo", event: "emergency" }
        Abort("motion")
        Wait { of: "demo/goto", ended: Ended { within: 5000000000, result: None, throws: None, detail: None, tolerance: 0.0, takes: Some(Takes { least: 1000000000, most: 2000000000 }) } }
        Wait { of: "motion", ended: Ended { within: 60000000000, result: Some(Object {}), throws: None, detail: None, tolerance: 0.0, takes: Some(Takes { least: 1000000000, most: 1000000000 }) } }
        Expect(Port { port: Address { component: "demo", port: "position", element: None }, value: Some(Object {"position": Null}), tolerance: 0.0, absent: false, samples: Some(3) })
        Expect(Activity { of: "motion", states: Some(["main", "stop"]), running: Some(false) })
        Expect(Component { name: "demo", codels: Some(Counts([("demo_servo", 3)])), missed: Some(0), state: Some("running") })
        Expect(Component { name: "demo", codels: Some(Ran(["demo_servo"])), missed: None, state: None })
        Fault(Fault { port: Address { component: "demo", port: "parameter", element: None }, harm: Corrupt(Object {"velocity": Number(9)}), every: 2, samples: Some(3) })
        Repair(Address { component: "demo", port: "parameter", element: None })
        Kill("arm")"#]].assert_eq(&told.join("\n"));
}

#[test]
fn a_key_that_there_is_not_is_told_with_the_nearest() {
    check(
        "scenarios = 1\n",
        expect![[r#"
        error: `scenario` is missing
         --> tests/a.toml:1:1
          |
        1 | scenarios = 1
          | ^
          |
          = help: [[scenario]] begins one
        error: a file of scenarios has no key `scenarios`
         --> tests/a.toml:1:1
          |
        1 | scenarios = 1
          | ^^^^^^^^^
          |
          = help: did you mean `scenario`?
    "#]],
    );
    check(
        &steps("{ cal = \"demo/goto\" }"),
        expect![[r#"
        error: a step says what it does by a key
         --> tests/a.toml:4:1
          |
        4 | { cal = "demo/goto" }
          | ^^^^^^^^^^^^^^^^^^^^^
          |
          = help: did you mean `call`?
    "#]],
    );
    check(
        &steps("{ call = \"demo/goto\", input = { goal = 1 } }"),
        expect![[r#"
        error: `call` has no key `input`
         --> tests/a.toml:4:23
          |
        4 | { call = "demo/goto", input = { goal = 1 } }
          |                       ^^^^^
          |
          = help: did you mean `inputs`?
    "#]],
    );
    check(
        &steps("{ expect = \"demo/position\", vale = 1 }"),
        expect![[r#"
        error: it is not said what `demo/position` has to be
         --> tests/a.toml:4:1
          |
        4 | { expect = "demo/position", vale = 1 }
          | ^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^
          |
          = help: value, absent or samples of a port; states or running of an activity; codels, missed or state of a component
        error: `expect` has no key `vale`
         --> tests/a.toml:4:29
          |
        4 | { expect = "demo/position", vale = 1 }
          |                             ^^^^
          |
          = help: did you mean `value`?
    "#]],
    );
}

#[test]
fn all_mistakes_of_a_file_are_told_at_their_places() {
    check(
        "backend = 3\n[[scenario]]\n[[scenario]]\nname = \"a\"\nsteps = [{ step = \"10\" }, 7]\n\
         [[scenario]]\nname = \"a\"\nsteps = [{ step = \"3h\" }, { step = \"3601s\" }]\n",
        expect![[r#"
            error: `backend` is a text, not 3
             --> tests/a.toml:1:11
              |
            1 | backend = 3
              |           ^
            error: `name` is missing
             --> tests/a.toml:2:1
              |
            2 | [[scenario]]
              | ^^^^^^^^^^^^
              |
              = help: say what the scenario shows: name = "stops at the wall"
            error: `steps` is missing
             --> tests/a.toml:2:1
              |
            2 | [[scenario]]
              | ^^^^^^^^^^^^
              |
              = help: [[scenario.steps]] begins one
            error: `step`: a unit is missing: s, ms, us or ns
             --> tests/a.toml:5:19
              |
            5 | steps = [{ step = "10" }, 7]
              |                   ^^^^
            error: a step is a table, not 7
             --> tests/a.toml:5:27
              |
            5 | steps = [{ step = "10" }, 7]
              |                           ^
            error: a second scenario `a`
             --> tests/a.toml:7:8
              |
            7 | name = "a"
              |        ^^^
            error: `step`: unknown unit `h`: s, ms, us or ns
             --> tests/a.toml:8:19
              |
            8 | steps = [{ step = "3h" }, { step = "3601s" }]
              |                   ^^^^
            error: a step of one hour is the longest, not 3601 s
             --> tests/a.toml:8:36
              |
            8 | steps = [{ step = "3h" }, { step = "3601s" }]
              |                                    ^^^^^^^
        "#]],
    );
}

#[test]
fn a_step_does_one_thing() {
    check(
        &steps("{ call = \"demo/goto\", step = \"10ms\" }"),
        expect![[r#"
        error: a step does one thing: `step` and `call` are two
         --> tests/a.toml:4:1
          |
        4 | { call = "demo/goto", step = "10ms" }
          | ^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^
          |
          = help: make two steps of it
    "#]],
    );
    check(
        &steps("{}"),
        expect![[r#"
        error: a step says what it does by a key
         --> tests/a.toml:4:1
          |
        4 | {}
          | ^^
          |
          = help: one of load, unload, connect, disconnect, step, publish, call, start, abort, wait, fire, expect, fault, repair, kill
    "#]],
    );
    check(
        &steps("{ expect = \"demo/goto\", states = [], missed = 0 }"),
        expect![[r#"
        error: `states` and `missed` are of different things
         --> tests/a.toml:4:1
          |
        4 | { expect = "demo/goto", states = [], missed = 0 }
          | ^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^
          |
          = help: make two steps of it
    "#]],
    );
    check(
        &steps("{ fault = \"demo/parameter\", every = 0 }"),
        expect![[r#"
        error: a fault is one of `drop`, `delay` and `corrupt`
         --> tests/a.toml:4:1
          |
        4 | { fault = "demo/parameter", every = 0 }
          | ^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^
          |
          = help: drop = true, delay = "20ms" or corrupt = { velocity = 9.0 }
        error: `every` is a whole number from 1, not 0
         --> tests/a.toml:4:37
          |
        4 | { fault = "demo/parameter", every = 0 }
          |                                     ^
    "#]],
    );
    check(
        &steps("{ call = \"demo/goto\", result = {}, throws = \"::demo::HALTED\" }"),
        expect![[r#"
            error: what ends with an exception (`throws`) has no `result`
             --> tests/a.toml:4:1
              |
            4 | { call = "demo/goto", result = {}, throws = "::demo::HALTED" }
              | ^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^
        "#]],
    );
}

#[test]
fn what_is_missing_or_of_another_kind_is_told() {
    check(
        &steps("{ call = \"goto\" }, { connect = \"a/b\" }"),
        expect![[r#"
        error: `goto` is no COMPONENT/PORT
         --> tests/a.toml:4:10
          |
        4 | { call = "goto" }, { connect = "a/b" }
          |          ^^^^^^
        error: `to` is missing
         --> tests/a.toml:4:20
          |
        4 | { call = "goto" }, { connect = "a/b" }
          |                    ^^^^^^^^^^^^^^^^^^^
          |
          = help: name the out port or the service: to = "demo/position"
    "#]],
    );
    check(
        &steps("{ publish = \"a/b\" }, { call = \"a/b\", inputs = 3 }"),
        expect![[r#"
        error: `value` is missing
         --> tests/a.toml:4:1
          |
        4 | { publish = "a/b" }, { call = "a/b", inputs = 3 }
          | ^^^^^^^^^^^^^^^^^^^
          |
          = help: say what is published: value = 0.5
        error: `inputs` is a table such as { goal = 1.0 }, not 3
         --> tests/a.toml:4:47
          |
        4 | { publish = "a/b" }, { call = "a/b", inputs = 3 }
          |                                               ^
    "#]],
    );
    check(
        &steps("{ start = \"a/b\", as = \"motion\" }, { wait = \"motoin\" }"),
        expect![[r#"
        error: no step before this one started `motoin`
         --> tests/a.toml:4:44
          |
        4 | { start = "a/b", as = "motion" }, { wait = "motoin" }
          |                                            ^^^^^^^^
          |
          = help: did you mean `motion`?
    "#]],
    );
    check(
        &steps("{ expect = \"demo\", value = 1 }, { expect = \"a/b\", missed = 0 }"),
        expect![[r#"
            error: `demo` is no COMPONENT/PORT
             --> tests/a.toml:4:12
              |
            4 | { expect = "demo", value = 1 }, { expect = "a/b", missed = 0 }
              |            ^^^^^^
            error: `missed` is of a component, which `a/b` is not
             --> tests/a.toml:4:33
              |
            4 | { expect = "demo", value = 1 }, { expect = "a/b", missed = 0 }
              |                                 ^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^
              |
              = help: write COMPONENT
        "#]],
    );
    check(
        &steps("{ publish = \"a/b\", value = 1979-05-27 }"),
        expect![[r#"
        error: no type of a component is a date
         --> tests/a.toml:4:28
          |
        4 | { publish = "a/b", value = 1979-05-27 }
          |                            ^^^^^^^^^^
    "#]],
    );
    check(
        &steps("{ load = { libary = \"demo\" } }"),
        expect![[r#"
        error: `load`: unknown field `libary`
         --> tests/a.toml:4:12
          |
        4 | { load = { libary = "demo" } }
          |            ^^^^^^
          |
          = help: did you mean `library`?
    "#]],
    );
}

#[test]
fn what_is_no_toml_is_told_at_its_place() {
    check(
        "[[scenario]\n",
        expect![[r#"
        error: unclosed array table, expected `]`
         --> tests/a.toml:1:12
          |
        1 | [[scenario]
          |            ^
    "#]],
    );
    check(
        "[[scenario]]\nname = \"a\"\nname = \"b\"\n",
        expect![[r#"
        error: duplicate key
         --> tests/a.toml:3:1
          |
        3 | name = "b"
          | ^^^^
    "#]],
    );
}

#[test]
fn a_text_of_any_bytes_is_read_or_refused() {
    // Each prefix of a file, and each with a character changed.
    let text = steps("{ call = \"demo/goto\", inputs = { goal = 1.5 }, takes = \"1s\" }");
    for end in 0..text.len() {
        let _ = Suite::read(Path::new("a.toml"), &text[..end]).map_err(|told| told.drawn());
        let mut other = text.clone().into_bytes();
        other[end] = b'[';
        let other = String::from_utf8(other).unwrap();
        let _ = Suite::read(Path::new("a.toml"), &other).map_err(|told| told.drawn());
    }
}
