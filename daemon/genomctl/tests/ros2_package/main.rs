//! `genomctl ros2-package`: the files written, how ROS's own parser and an independent CDR library
//! read them, and what is refused.

#![forbid(unsafe_code)]
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod peer;
mod refused;
#[path = "../offline/support.rs"]
#[allow(dead_code, reason = "shared with other tests")]
mod support;

use expect_test::expect;

use crate::support::Room;

/// Every kind of type.
pub(crate) const EVERYTHING: &str = include_str!("everything.gen");

fn text(room: &Room, path: &str) -> String {
    String::from_utf8(room.read(path)).unwrap()
}

#[test]
fn packages_are_written_for_colcon() {
    let room = Room::new(&[("robot.gen", EVERYTHING)]);
    room.check("ros2-package --no-standard-interface robot.gen src", &expect![[r#"
        geo/msg/Cloud            RIHS01_1d41e1ee8da7cf524724bac9e629760b94f2964fc2b7d52efe4a301f34074b51
        geo/msg/Point            RIHS01_ced6c280fb4f349a5d72eca312c4b444300928c089ec09200a7e20f473f04cbf
        robot/action/Walk        RIHS01_cf047073478fcad380813066b8c653b9e483665b3e453914be5d759b6a5e9fac
        robot/msg/Blob           RIHS01_a8ae30d3f9fd60a5a046d0932122827605a19dd8416164a258fbef7f2341055a
        robot/msg/Command        RIHS01_028b81b40791de9650b71cc2da0a5d5c93b42ed653a60fb464cbebabbbe9a8ad
        robot/msg/Matrix         RIHS01_db2b9be8a647fda0b21f3ef41c8457f948793ddf229fa14ff79ac31d3cd7a35f
        robot/msg/ModeT          RIHS01_c23999a1f3cd267e7a138a2160f79d25a9e05ccb676bb83d791338376afa0adb
        robot/msg/Scalars        RIHS01_49ce0e3a7c505024dcc79a0443304cf84b875da02fc723230737d623f7c43d59
        robot/msg/SequenceShort  RIHS01_948496959950138dbb71741248aea8771fc6fe1381c327b3187b8927e9f14a78
        robot/msg/State          RIHS01_73ebde127efff7f19deef9d63d030f51b02816572e36913eedf206e7395d3f11
        robot/srv/Plan           RIHS01_64683bc3f07fbf538c42ced56be8e67f45ff689474c90e2a18b0e3542d4029a3
        robot/srv/SetSpeed       RIHS01_c767350c4feae6ec9e9c31d66f80a61b99a29de9c7b3d189e3b680ed9aab8056
    "#]]);
    expect![[r#"
        # ::robot::state
        uint32 MODE_IDLE=0
        uint32 MODE_MOVING=1
        uint32 MODE_AT_REST=2
        uint32 COLOR_RED=0
        uint32 COLOR_GREEN=1
        robot/Scalars all
        string name
        string<=7 tag
        string<=3[2] tags
        uint32 now
        uint32[3] paint
        float64[6] rotation
        geo/Point[] seen
        robot/SequenceShort[<=2] rows
        robot/Matrix[] stack
        int32[<=1] maybe
        geo/Cloud[<=1] perhaps
        robot/Command last
        float64 kp  # IDL: Kp
    "#]]
    .assert_eq(&text(&room, "src/robot/msg/State.msg"));
    expect![[r#"
        # ::robot::command
        uint32 MODE_IDLE=0
        uint32 MODE_MOVING=1
        uint32 MODE_AT_REST=2
        uint32 genom_discriminant
        int32[<=1] pause
        geo/Point[<=1] target
        robot/Blob[<=1] raw
    "#]]
    .assert_eq(&text(&room, "src/robot/msg/Command.msg"));
    expect![[r#"
        # ::robot::plan::input
        geo/Point from
        string<=31 hint
        ---
        # ::robot::plan::output
        string genom_exception
        string genom_detail
        geo/Point[] route
        bool found
    "#]]
    .assert_eq(&text(&room, "src/robot/srv/Plan.srv"));
    expect![[r#"
        # ::robot::walk::input
        geo/Point goal
        int32 laps
        ---
        # ::robot::walk::output
        string genom_exception
        string genom_detail
        int32 laps
        float64 done
        ---
        string genom_state
    "#]]
    .assert_eq(&text(&room, "src/robot/action/Walk.action"));
    expect![[r#"
        <?xml version="1.0"?>
        <package format="3">
          <name>robot</name>
          <version>0.0.0</version>
          <description>Interfaces of robot.gen, made by genomctl ros2-package.</description>
          <maintainer email="nobody@localhost">nobody</maintainer>
          <license>unknown</license>

          <buildtool_depend>ament_cmake</buildtool_depend>
          <buildtool_depend>rosidl_default_generators</buildtool_depend>
          <depend>action_msgs</depend>
          <depend>geo</depend>
          <exec_depend>rosidl_default_runtime</exec_depend>
          <member_of_group>rosidl_interface_packages</member_of_group>

          <export>
            <build_type>ament_cmake</build_type>
          </export>
        </package>
    "#]]
    .assert_eq(&text(&room, "src/robot/package.xml"));
    expect![[r#"
        cmake_minimum_required(VERSION 3.8)
        project(robot)

        find_package(ament_cmake REQUIRED)
        find_package(rosidl_default_generators REQUIRED)
        find_package(action_msgs REQUIRED)
        find_package(geo REQUIRED)

        rosidl_generate_interfaces(${PROJECT_NAME}
          "action/Walk.action"
          "msg/Blob.msg"
          "msg/Command.msg"
          "msg/Matrix.msg"
          "msg/ModeT.msg"
          "msg/Scalars.msg"
          "msg/SequenceShort.msg"
          "msg/State.msg"
          "srv/Plan.srv"
          "srv/SetSpeed.srv"
          DEPENDENCIES action_msgs geo
        )

        ament_export_dependencies(rosidl_default_runtime)
        ament_package()
    "#]]
    .assert_eq(&text(&room, "src/robot/CMakeLists.txt"));
}

#[test]
fn a_package_is_written_anew_and_others_are_left_alone() {
    let room = Room::new(&[("robot.gen", EVERYTHING)]);
    assert_eq!(room.run("ros2-package robot.gen src", "").0, 0);
    room.write("src/robot/msg/Gone.msg", b"bool x\n");
    assert_eq!(room.run("ros2-package robot.gen src", "").0, 0);
    assert!(!room.path("src/robot/msg/Gone.msg").exists());
    room.write("src/robot/package.xml", b"<package/>");
    room.check(
        "ros2-package robot.gen src",
        &expect![[r#"
        ! error: src/robot is a package of somebody else's: name another directory
        exit 1
    "#]],
    );
}

#[test]
fn what_goes_under_a_foreign_name_is_not_written() {
    let room = Room::new(&[("robot.gen", EVERYTHING)]);
    let masquerade = "--masquerade ::geo::cloud=geometry_msgs/msg/Polygon";
    room.check(
        &format!("ros2-package --no-standard-interface {masquerade} robot.gen src"),
        &expect![[r#"
            ! error[ros2]: ::geo::cloud and geometry_msgs/msg/Polygon differ at `data`, there `points`:
            !              ::geo::cloud is
            !                geo/Point[] data
            !                  float64 x
            !                  float64 y
            !              geometry_msgs/msg/Polygon is
            !                geometry_msgs/Point32[] points
            !                  float32 x
            !                  float32 y
            !                  float32 z
            !   --> robot.gen:52:23
            !    |
            ! 52 |   port out geo::cloud scan;
            !    |                       ^^^^
            ! error: 1 error in the description
            exit 1
        "#]],
    );
    let room = Room::new(&[("arm.gen", ARM)]);
    let masquerade = "--masquerade arm::pose=geometry_msgs/msg/Pose";
    let (code, out, err) =
        room.run(&format!("ros2-package --no-standard-interface {masquerade} arm.gen src"), "");
    assert_eq!((code, err.as_str()), (0, ""));
    let names: Vec<_> = out.lines().filter_map(|line| line.split_whitespace().next()).collect();
    assert_eq!(names, ["arm/msg/Track", "arm/srv/Where"]);
    assert_eq!(
        text(&room, "src/arm/msg/Track.msg"),
        "# ::arm::track\ngeometry_msgs/Pose[] poses\n"
    );
    assert!(text(&room, "src/arm/package.xml").contains("<depend>geometry_msgs</depend>"));
}

const ARM: &str = "component arm {
  struct vector { double x, y, z; };
  struct pose { vector at; double qx, qy, qz, qw; };
  struct track { sequence<pose> poses; };
  ids { pose current; };
  port out pose hand;
  port out track past;
  task t { codel<start> arm_go(out hand, out past, inout ::ids) yield ether; };
  attribute where(out current);
};
";
