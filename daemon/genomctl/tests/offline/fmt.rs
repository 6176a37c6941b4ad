//! `genomctl fmt`.

use expect_test::expect;

use crate::support::Room;

const UGLY: &str = "component c{\ntask t {period 1 s;};   // one\n      port out double p{};\n};\n";

#[test]
fn a_file_is_written_back_formatted() {
    let room = Room::new(&[("c.gen", UGLY)]);
    room.check(
        "fmt --check c.gen",
        &expect![[r#"
        c.gen:1: would be formatted
        -component c{
        -task t {period 1 s;};   // one
        -      port out double p{};
        +component c {
        +  task t { period 1 s; }; // one
        +  port out double p {};
        ! error: 1 file to format
        exit 1
    "#]],
    );
    room.check("fmt c.gen", &expect![]);
    expect![[r#"
        component c {
          task t { period 1 s; }; // one
          port out double p {};
        };
    "#]]
    .assert_eq(&String::from_utf8(room.read("c.gen")).unwrap());
    room.check("fmt --check c.gen", &expect![[""]]);
}

#[test]
fn a_formatted_file_is_left_alone() {
    let room = Room::new(&[("c.gen", "component c {\n};\n")]);
    let before = std::fs::metadata(room.path("c.gen")).unwrap().modified().unwrap();
    room.check("fmt c.gen", &expect![[""]]);
    assert_eq!(std::fs::metadata(room.path("c.gen")).unwrap().modified().unwrap(), before);
}

#[test]
fn standard_input_is_formatted_to_standard_output() {
    let room = Room::new(&[]);
    expect![[r#"
        component c {};
    "#]]
    .assert_eq(&room.transcript("fmt -", "component c{};"));
    expect![[r#"
        <stdin>:1: would be formatted
        -component c{};
        +component c {};
        +
        ! error: 1 file to format
        exit 1
    "#]]
    .assert_eq(&room.transcript("fmt --check -", "component c{};"));
}

#[test]
fn latin_1_stays_latin_1() {
    let room = Room::new(&[]);
    room.write("c.gen", b"component c{\ndoc \"\xe9t\xe9\";\n};\n");
    room.check("fmt c.gen", &expect![[""]]);
    assert_eq!(room.read("c.gen"), b"component c {\n  doc \"\xe9t\xe9\";\n};\n");
}

#[test]
fn what_cannot_be_formatted_is_said_and_left_alone() {
    let room = Room::new(&[("bad.gen", "/* no end"), ("c.gen", UGLY)]);
    room.check(
        "fmt bad.gen c.gen",
        &expect![[r#"
        ! error: bad.gen: line 1: this comment is never closed
        ! error: 1 file cannot be formatted
        exit 1
    "#]],
    );
    assert_eq!(room.read("bad.gen"), b"/* no end");
    assert_ne!(room.read("c.gen"), UGLY.as_bytes(), "the others are formatted all the same");
    room.check(
        "fmt none.gen",
        &expect![[r#"
        ! error: none.gen: No such file or directory (os error 2)
        ! help: name a .gen file
        exit 2
    "#]],
    );
    room.check(
        "fmt",
        &expect![[r#"
        ! error: the following required arguments were not provided:
        !   <FILES>...
        !
        ! Usage: genomctl fmt <FILES>...
        !
        ! For more information, try '--help'.
        exit 2
    "#]],
    );
}
