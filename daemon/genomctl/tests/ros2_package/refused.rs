//! Types without an equivalent in ROS are reported at their position.

use expect_test::expect;

use crate::support::Room;

#[test]
fn what_has_no_equivalent_is_shown_in_the_text() {
    let room = Room::new(&[("bad.gen", BAD)]);
    room.check("ros2-package bad.gen src", &expect![[r#"
        ! error[ros2]: ::bad::twice::kp: it would be called `kp` in ROS, as `Kp` is
        !  --> bad.gen:2:29
        !   |
        ! 2 |   struct twice { double Kp, kp; };
        !   |                             ^^
        !   |
        !   = help: rename one of them
        !
        ! error[ros2]: ::bad::nothing::empty: a string that can only be empty has no equivalent in ROS
        !  --> bad.gen:3:30
        !   |
        ! 3 |   struct nothing { string<1> empty; };
        !   |                              ^^^^^
        !   |
        !   = help: string<2> holds one character
        !
        ! error[ros2]: ::bad::node: a type that contains itself has no equivalent in ROS
        !  --> bad.gen:6:10
        !   |
        ! 6 |   struct node { long x; nodes kids; };
        !   |          ^^^^
        !   |
        !   = help: refer to the inner ones by their rank in a sequence beside
        !
        ! error[ros2]: ::bad::armState: it would be bad/msg/ArmState in ROS, as ::bad::arm_state is
        !  --> bad.gen:8:10
        !   |
        ! 8 |   struct armState { double b; };
        !   |          ^^^^^^^^
        !   |
        !   = help: rename one of them
        !
        ! error[ros2]: ::bad::_1: bad/msg/1 is no legal name in ROS
        !   --> bad.gen:10:10
        !    |
        ! 10 |   struct _1 { long x; };
        !    |          ^^
        !    |
        !    = help: begin it with a letter, and use letters, digits and single underscores
        !
        ! error[ros2]: ::bad::f::output::genom_exception: it would be called `genom_exception` in ROS, as `genom_exception` is
        !   --> bad.gen:17:43
        !    |
        ! 17 |   function f(in double genom_, out double genom_exception) {
        !    |                                           ^^^^^^^^^^^^^^^
        !    |
        !    = help: rename one of them
        ! error: 6 errors in the description
        exit 1
    "#]]);
    assert!(!room.path("src").exists(), "nothing is written");
}

const BAD: &str = "component bad {
  struct twice { double Kp, kp; };
  struct nothing { string<1> empty; };
  struct node;
  typedef sequence<node> nodes;
  struct node { long x; nodes kids; };
  struct arm_state { long a; };
  struct armState { double b; };
  struct both { arm_state a; armState b; };
  struct _1 { long x; };
  ids { double v; };
  port out twice a;
  port out nothing b;
  port out node c;
  port out both d;
  port out _1 e;
  function f(in double genom_, out double genom_exception) {
    codel bad_f(in genom_, out genom_exception);
  };
  task t { codel<start> bad_go(out a, out b, out c, out d, out e, inout v) yield ether; };
};
";

#[test]
fn packages_that_need_each_other_are_refused() {
    let circle = "module a { struct low { long x; }; };
module b { struct mid { a::low x; }; };
module a { struct high { b::mid x; }; };
component c { port out a::high p; task t { codel<start> c_go(out p) yield ether; }; };
";
    let room = Room::new(&[("circle.gen", circle)]);
    room.check("ros2-package circle.gen src", &expect![[r#"
        ! error: packages a, b need each other, and ROS cannot build that: put the types into one scope
        exit 1
    "#]]);
}

#[test]
fn wrong_use_is_told() {
    let room = Room::new(&[("none.gen", ""), ("one.gen", "component one {};\n")]);
    room.check(
        "ros2-package --masquerade x one.gen src",
        &expect![[r#"
            ! error: `x` is no masquerade
            ! help: write for instance --masquerade ::demo::pose=geometry_msgs/msg/Pose
            exit 2
        "#]],
    );
    room.check(
        "ros2-package none.gen src",
        &expect![[r#"
        ! error: there is no component; those described are: none
        exit 1
    "#]],
    );
    room.check(
        "ros2-package none.gen",
        &expect![[r#"
        ! error: 2 values required by '<FILE.gen> <DIRECTORY>...'; only 1 was provided
        !
        ! Usage: genomctl ros2-package [OPTIONS] <FILE.gen> <DIRECTORY>...
        !
        ! For more information, try '--help'.
        exit 2
    "#]],
    );
}
