//! Outputs made of valid descriptions: header, describe, graph, digest.

use expect_test::expect;

use crate::support::Room;

const ARM: &str = r#"component arm {
  doc "An arm.";
  struct angle { double value; };
  ids { angle current; };
  port out angle position { doc "Where it is."; };
  exception FAR { double by; };
  task motion { period 10 ms; };
  attribute where(out current);
  activity turn(in angle goal = { .value = 1.5 : "rad" }) {
    doc "Turns it.";
    task motion;
    codel<start> arm_begin(in goal) yield main;
    codel<main> arm_step(inout current, out position) yield pause::main, ether;
    throws FAR;
    interrupts turn;
  };
};
component leg {};
"#;
const BAD: &str = "component bad { task t { period; }; };\n";

#[test]
fn a_header_holds_types_and_prototypes() {
    let room = Room::new(&[("arm.gen", ARM), ("bad.gen", BAD)]);
    let c = "genom_event arm_begin(const arm_angle *goal, const genom_context self);";
    for (lang, type_line, codel) in [
        ("c", "typedef struct arm_angle arm_angle;", c),
        ("c++", "typedef struct arm_angle arm_angle;", c),
        ("rust", "pub struct arm_angle {", "pub type arm_begin_codel = unsafe extern \"C\" fn("),
        ("python", "class angle(View):", "class FAR(Raised):"),
    ] {
        let (code, out, err) =
            room.run(&format!("header --lang {lang} --component arm arm.gen"), "");
        assert_eq!(code, 0, "{err}");
        for wanted in [type_line, codel] {
            assert!(out.contains(wanted), "{lang}: no `{wanted}` in\n{out}");
        }
    }
    room.check("header --lang c --component foot arm.gen", &expect![[r#"
        ! warning[W0906]: activity `turn` loops and has no codel<stop>
        !  --> arm.gen:9:12
        !   |
        ! 9 |   activity turn(in angle goal = { .value = 1.5 : "rad" }) {
        !   |            ^^^^
        !   |
        !   = help: interrupted, it ends at once with `genom::interrupted`: add codel<stop> to end well
        ! error: there is no component `foot`; those described are: `arm`, `leg`
        exit 1
    "#]]);
    room.check(
        "header --lang c bad.gen",
        &expect![[r#"
        ! error[E0103]: expected a value, found `;`
        !  --> bad.gen:1:32
        !   |
        ! 1 | component bad { task t { period; }; };
        !   |                                ^
        ! error: 1 error in the description
        exit 1
    "#]],
    );
    room.check(
        "header --lang go arm.gen",
        &expect![[r#"
        ! error: invalid value 'go' for '--lang <LANG>'
        !   [possible values: c, c++, rust, python]
        !
        ! For more information, try '--help'.
        exit 2
    "#]],
    );
}

#[test]
fn a_description_is_told_to_people_and_programs() {
    let room = Room::new(&[("arm.gen", ARM)]);
    room.check("describe --no-standard-interface arm.gen", &expect![[r#"
        component arm 0
          An arm.

        tasks
          motion every 10ms

        ports
          out position: ::arm::angle  Where it is.

        attributes
          where(out current: ::arm::angle)

        activities
          turn(in goal: ::arm::angle = {"value":1.5})  Turns it.

        exceptions
          ::arm::FAR

        digest d674c6c4b9f95feb163e254944383

        component leg 0

        digest d41d8cd98f0b24e980998ecf8427e
        ! warning[W0906]: activity `turn` loops and has no codel<stop>
        !  --> arm.gen:9:12
        !   |
        ! 9 |   activity turn(in angle goal = { .value = 1.5 : "rad" }) {
        !   |            ^^^^
        !   |
        !   = help: interrupted, it ends at once with `genom::interrupted`: add codel<stop> to end well
    "#]]);
    let (_, out, _) = room.run("describe --json arm.gen", "");
    let documents: Vec<serde_json::Value> =
        out.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    let names: Vec<_> = documents.iter().map(|one| one["name"].as_str().unwrap()).collect();
    assert_eq!(names, ["arm", "leg"]);
}

#[test]
fn state_machines_are_drawn() {
    let room = Room::new(&[("arm.gen", ARM)]);
    room.check("graph --component arm --no-standard-interface arm.gen", &expect![[r#"
        digraph "arm" {
          rankdir=LR;
          node [fontname="sans-serif"];
          edge [fontname="sans-serif"];
          subgraph cluster_component {
            label="arm";
            port_position [shape=cds, label="out position"];
            task_motion [shape=component, label="task motion (10ms)"];
            service_where [shape=box, label="attribute where"];
            service_turn [shape=box, label="activity turn"];
          }
          subgraph cluster_service_turn {
            label="activity turn";
            service_turn__start [shape=ellipse, label="start\narm_begin"];
            service_turn__main [shape=ellipse, label="main\narm_step"];
            service_turn__ether [shape=ellipse, label="ether"];
            service_turn__start -> service_turn__main;
            service_turn__main -> service_turn__main [label="pause", style=dashed];
            service_turn__main -> service_turn__ether;
          }
          task_motion -> service_turn [label="runs", style=dashed];
          service_turn -> port_position;
          service_turn -> service_turn [label="interrupts", style=dashed];
        }
        ! warning[W0906]: activity `turn` loops and has no codel<stop>
        !  --> arm.gen:9:12
        !   |
        ! 9 |   activity turn(in angle goal = { .value = 1.5 : "rad" }) {
        !   |            ^^^^
        !   |
        !   = help: interrupted, it ends at once with `genom::interrupted`: add codel<stop> to end well
    "#]]);
    room.check(
        "graph --format mermaid --component arm --no-standard-interface arm.gen",
        &expect![[r#"
            flowchart LR
              subgraph component["arm"]
                port_position[/"out position"/]
                task_motion[["task motion (10ms)"]]
                service_where["attribute where"]
                service_turn["activity turn"]
              end
              subgraph machine_service_turn["activity turn"]
                service_turn__start(["start<br>arm_begin"])
                service_turn__main(["main<br>arm_step"])
                service_turn__ether(["ether"])
                service_turn__start --> service_turn__main
                service_turn__main -.->|pause| service_turn__main
                service_turn__main --> service_turn__ether
              end
              task_motion -.->|runs| service_turn
              service_turn --> port_position
              service_turn -.->|interrupts| service_turn
            ! warning[W0906]: activity `turn` loops and has no codel<stop>
            !  --> arm.gen:9:12
            !   |
            ! 9 |   activity turn(in angle goal = { .value = 1.5 : "rad" }) {
            !   |            ^^^^
            !   |
            !   = help: interrupted, it ends at once with `genom::interrupted`: add codel<stop> to end well
        "#]],
    );
    room.check("graph --component foot arm.gen", &expect![[r#"
        ! warning[W0906]: activity `turn` loops and has no codel<stop>
        !  --> arm.gen:9:12
        !   |
        ! 9 |   activity turn(in angle goal = { .value = 1.5 : "rad" }) {
        !   |            ^^^^
        !   |
        !   = help: interrupted, it ends at once with `genom::interrupted`: add codel<stop> to end well
        ! error: there is no component `foot`; those described are: `arm`, `leg`
        exit 1
    "#]]);
}

#[test]
fn digests_are_those_of_components_and_services() {
    let room = Room::new(&[("arm.gen", ARM)]);
    room.check("digest --no-standard-interface arm.gen", &expect![[r#"
        d674c6c4b9f95feb163e254944383  arm
        43b4ee89a1ce8120f7c92d404b78e5dd  arm/where
        a3f12e1c333d9e2b7183fe523db27e63  arm/turn
        d41d8cd98f0b24e980998ecf8427e  leg
        ! warning[W0906]: activity `turn` loops and has no codel<stop>
        !  --> arm.gen:9:12
        !   |
        ! 9 |   activity turn(in angle goal = { .value = 1.5 : "rad" }) {
        !   |            ^^^^
        !   |
        !   = help: interrupted, it ends at once with `genom::interrupted`: add codel<stop> to end well
    "#]]);
    room.check("digest --json --no-standard-interface arm.gen", &expect![[r#"
        {"component":"arm","digest":"d674c6c4b9f95feb163e254944383","services":{"where":"43b4ee89a1ce8120f7c92d404b78e5dd","turn":"a3f12e1c333d9e2b7183fe523db27e63"}}
        {"component":"leg","digest":"d41d8cd98f0b24e980998ecf8427e","services":{}}
        ! warning[W0906]: activity `turn` loops and has no codel<stop>
        !  --> arm.gen:9:12
        !   |
        ! 9 |   activity turn(in angle goal = { .value = 1.5 : "rad" }) {
        !   |            ^^^^
        !   |
        !   = help: interrupted, it ends at once with `genom::interrupted`: add codel<stop> to end well
    "#]]);
    let with = room.run("digest arm.gen", "").1;
    assert!(with.lines().any(|line| line.ends_with("  arm/connect_port")), "{with}");
}
