//! `genomctl check` and `genomctl explain`.

use expect_test::expect;

use crate::support::Room;

/// Ten independent mistakes, and uses of what they declare.
const TEN: &str = r#"const long big = 1 / 0;
const long twice = big + big;
struct point { double x; nothing y; };
struct point { double z; };
component ten {
  ids { point at; long n; };
  port out missing p { doc "one"; };
  port in point near;
  task slow { period 0 ms; };
  attribute set(in nowhere);
  function f(in long a = "text") {
    codel c_f(in a, in unknown);
  };
  activity move(in long goal) {
    task missing_task;
    codel<start> c_move(in goal, out p) yield pause::start, ether;
    interrupts nobody;
  };
};
"#;

#[test]
fn ten_mistakes_are_ten_messages() {
    let room = Room::new(&[("ten.gen", TEN)]);
    room.check("check --format short ten.gen", &expect![[r#"
        ! ten.gen:1:22: error: division by zero [E0312]
        ! ten.gen:3:26: error: unknown type `nothing` [E0206]
        ! ten.gen:4:8: error: `point` is already declared [E0205]
        ! ten.gen:7:12: error: unknown type `missing` [E0206]
        ! ten.gen:9:15: error: the period of task `slow` is below a microsecond: no clock can serve it [E0512]
        ! ten.gen:10:20: error: unknown member `nowhere` in struct `::ten::ids` [E0715]
        ! ten.gen:11:26: error: a string cannot become long [E0803]
        ! ten.gen:12:24: error: unknown source for parameter `unknown` [E0712]
        ! ten.gen:15:10: error: unknown task `missing_task` [E0513]
        ! ten.gen:17:16: error: no such service `nobody` [E0517]
        ! error: 10 errors in the description
        exit 1
    "#]]);
}

#[test]
fn a_mistake_is_drawn_in_its_text() {
    let room =
        Room::new(&[("c.gen", "component c {\n  port in gian g;\n};\ntypedef double gain;\n")]);
    room.check(
        "check c.gen",
        &expect![[r#"
        ! error[E0206]: unknown type `gian`
        !  --> c.gen:2:11
        !   |
        ! 2 |   port in gian g;
        !   |           ^^^^
        ! error: 1 error in the description
        exit 1
    "#]],
    );
}

#[test]
fn data_go_to_standard_output() {
    let room = Room::new(&[("c.gen", "component c { task t { period; }; };\n")]);
    room.check(
        "check --format json c.gen",
        &expect![[r#"
            {
              "errors": 1,
              "warnings": 0,
              "diagnostics": [
                {
                  "code": "E0103",
                  "severity": "error",
                  "message": "expected a value, found `;`",
                  "file": "c.gen",
                  "line": 1,
                  "column": 30,
                  "end_line": 1,
                  "end_column": 31,
                  "notes": [],
                  "included_from": [],
                  "help": null
                }
              ]
            }
            ! error: 1 error in the description
            exit 1
        "#]],
    );
    // The global option gives the same, on one line as for all verbs.
    let line = room.run("--json check c.gen", "").1;
    assert_eq!(line.lines().count(), 1, "{line}");
    let data = |text: &str| serde_json::from_str::<serde_json::Value>(text).unwrap();
    assert_eq!(data(&line), data(&room.run("check --format json c.gen", "").1));
}

#[test]
fn several_files_are_one_specification() {
    let room = Room::new(&[
        ("types.gen", "struct point { double x, y; };\n"),
        ("arm.gen", "component arm { doc \"An arm.\"; port out point tip {}; };\n"),
        ("d/units.h", "#define METRE double\n"),
        ("leg.gen", "#include <units.h>\ncomponent leg { port out METRE NAME {}; };\n"),
    ]);
    room.check(
        "check types.gen arm.gen",
        &expect![[r#"
        component arm: 0 services, 2 ports, 0 tasks, digest 5215ed8bd837c36717be16a83f22c5a
        ! warning[W0903]: no codel uses port `tip`
        !  --> arm.gen:1:47
        !   |
        ! 1 | component arm { doc "An arm."; port out point tip {}; };
        !   |                                               ^^^
    "#]],
    );
    room.check(
        "check arm.gen --format short",
        &expect![[r#"
        ! arm.gen:1:41: error: unknown type `point` [E0206]
        ! error: 1 error in the description
        exit 1
    "#]],
    );
    room.check(
        "check -I d -D NAME=length leg.gen",
        &expect![[r#"
        ! error[E0618]: port `length` needs a type with a name
        !  --> leg.gen:2:26
        !   |
        ! 2 | component leg { port out METRE NAME {}; };
        !   |                          ^^^^^
        !   |
        !   = note: in the expansion of macro `METRE`, defined at d/units.h:1
        !   = help: declare `typedef double NAME;` and use NAME
        ! error: 1 error in the description
        exit 1
    "#]],
    );
    room.check(
        "check leg.gen --format short",
        &expect![[r#"
        ! leg.gen:1:10: error: cannot find `units.h` [E0121]
        ! error: 1 error in the description
        exit 1
    "#]],
    );
}

#[test]
fn warnings_are_refused_only_when_asked() {
    let room = Room::new(&[("c.gen", "component c { task idle {}; };\n")]);
    room.check(
        "check c.gen",
        &expect![[r#"
        component c: 0 services, 1 ports, 1 tasks, digest 8db8a3f82ce9ba18c3bfa688024d6
        ! warning[W0905]: nothing runs in task `idle`
        !  --> c.gen:1:20
        !   |
        ! 1 | component c { task idle {}; };
        !   |                    ^^^^
    "#]],
    );
    room.check(
        "check --deny-warnings --format short c.gen",
        &expect![[r#"
        ! c.gen:1:20: warning: nothing runs in task `idle` [W0905]
        ! error: 1 warning in the description
        exit 1
    "#]],
    );
}

#[test]
fn wrong_usage_ends_with_2() {
    let room = Room::new(&[("a.so", ""), ("b.so", "")]);
    room.check(
        "check none.gen",
        &expect![[r#"
        ! error: none.gen: no such file
        ! help: name a .gen file
        exit 2
    "#]],
    );
    room.check(
        "check --format long c.gen",
        &expect![[r#"
        ! error: invalid value 'long' for '--format <FORMAT>'
        !   [possible values: human, short, json]
        !
        ! For more information, try '--help'.
        exit 2
    "#]],
    );
    room.check(
        "check a.so b.so",
        &expect![[r#"
        ! error: several files with a library among them
        ! help: write `genomctl check LIBRARY [DESCRIPTION]`
        exit 2
    "#]],
    );
    room.check(
        "explain E9999",
        &expect![[r#"
        ! error: there is no code `E9999`
        ! help: `genomctl explain` lists them
        exit 2
    "#]],
    );
}

#[test]
fn a_code_is_explained() {
    let room = Room::new(&[]);
    room.check("explain E0301", &expect![[r#"
        E0301: an operator does not apply (rule C1)

        `+ - * /` take numbers; `% | & ^ << >>` integers; `~` also takes a boolean. Booleans, characters, strings and enumerators take no binary operator.

        For instance:

            const long n = 1 + TRUE;
    "#]]);
}
