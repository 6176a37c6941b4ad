//! Hints of `genomctl check`: what cannot work as described, although nothing in it is wrong.

use expect_test::expect;

use crate::support::Room;

/// One component for each kind of hint: services that wait for each other, an activity that may sleep
/// once it was asked to stop, and a codel that is not shorter than the period of its task.
const ALL: &str = "component c {
  ids { long x; };
  event alarm;
  task t { period 5 ms; };
  attribute a(in x) { after b; };
  attribute b(in x) { after a; };
  activity go() {
    task t;
    codel<start> c_go() yield pause::start, ether wcet 6 ms;
    codel<stop> c_stop() yield sleep, ether;
    codel<alarm> c_alarm() yield ether;
  };
};
";

#[test]
fn order_stop_and_overrun_are_told_as_hints_and_nothing_is_refused() {
    let room = Room::new(&[("c.gen", ALL)]);
    room.check(
        "check c.gen",
        &expect![[r#"
            component c: 3 services, 1 ports, 1 tasks, digest 66805f3a534989bf61e8adfb0ca3adf
            ! hint[order]: a can never run: there is no order of a, b in which `before` and `after` hold
            !  --> c.gen:5:13
            !   |
            ! 5 |   attribute a(in x) { after b; };
            !   |             ^
            !
            ! hint[order]: b can never run: there is no order of b, a in which `before` and `after` hold
            !  --> c.gen:6:13
            !   |
            ! 6 |   attribute b(in x) { after a; };
            !   |             ^
            !
            ! hint[overrun]: c_go takes up to 6 ms, and t has a tick each 5 ms
            !  --> c.gen:9:18
            !   |
            ! 9 |     codel<start> c_go() yield pause::start, ether wcet 6 ms;
            !   |                  ^^^^
            !
            ! hint[stop]: activity go may sleep in state stop once it was asked to stop: only an event ends that
            !   --> c.gen:10:17
            !    |
            ! 10 |     codel<stop> c_stop() yield sleep, ether;
            !    |                 ^^^^^^
        "#]],
    );
    room.check(
        "check --deny-warnings --format short c.gen",
        &expect![[r#"
            ! c.gen:5:13: hint: a can never run: there is no order of a, b in which `before` and `after` hold [order]
            ! c.gen:6:13: hint: b can never run: there is no order of b, a in which `before` and `after` hold [order]
            ! c.gen:9:18: hint: c_go takes up to 6 ms, and t has a tick each 5 ms [overrun]
            ! c.gen:10:17: hint: activity go may sleep in state stop once it was asked to stop: only an event ends that [stop]
        "#]],
    );
    room.check(
        "check --limit 1 --format short c.gen",
        &expect![[r#"
            ! c.gen:5:13: hint: a can never run: there is no order of a, b in which `before` and `after` hold [order]
            ! ... and 3 hints more
        "#]],
    );
}

#[test]
fn nothing_is_hinted_where_all_can_work() {
    let sound = ALL
        .replace("after b;", "")
        .replace("wcet 6 ms", "wcet 4 ms")
        .replace("yield sleep, ether", "yield ether");
    let room = Room::new(&[("c.gen", &sound)]);
    room.check("check --short c.gen", &expect![[r#""#]]);
}

#[test]
fn a_description_with_errors_has_no_hints() {
    let wrong =
        ALL.replace("task t { period 5 ms; };", "task t { period 5 ms; };\n  task u { x; };");
    let room = Room::new(&[("c.gen", &wrong)]);
    room.check(
        "check --short c.gen",
        &expect![[r#"
            ! c.gen:5:12: error: expected a property, found `x` [E0107]
            ! error: 1 error in the description
            exit 1
        "#]],
    );
}

#[test]
fn hints_in_json_have_the_name_of_their_property() {
    let room = Room::new(&[("c.gen", ALL)]);
    let (status, out, _) = room.run("check --format json c.gen", "");
    assert_eq!(status, 0);
    let document: serde_json::Value = serde_json::from_str(&out).unwrap();
    assert_eq!((&document["errors"], &document["warnings"]), (&0.into(), &0.into()));
    let all = document["diagnostics"].as_array().unwrap();
    let told: Vec<_> = all
        .iter()
        .map(|one| (one["severity"].as_str().unwrap(), one["code"].as_str().unwrap(), &one["line"]))
        .collect();
    assert_eq!(
        told,
        [
            ("hint", "order", &5.into()),
            ("hint", "order", &6.into()),
            ("hint", "overrun", &9.into()),
            ("hint", "stop", &10.into()),
        ]
    );
}
