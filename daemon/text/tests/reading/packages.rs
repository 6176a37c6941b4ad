//! `#pragma requires` asks a pkg-config program (genom3.md 1.3).

use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};

use expect_test::expect;
use genom_text::preprocess::Options;

use crate::support::read_with;

/// A stand-in for pkg-config that records its arguments and gives a fixed answer.
fn program(dir: &Path, answer: &str) -> PathBuf {
    let path = dir.join("pkg-config");
    let log = dir.join("log");
    let script = format!("#!/bin/sh\nprintf '<%s>' \"$@\" >> {}\n{answer}\n", log.display());
    std::fs::write(&path, script).unwrap();
    std::fs::set_permissions(&path, std::fs::Permissions::from_mode(0o755)).unwrap();
    path
}

#[test]
fn include_directories_and_definitions_hold_from_the_pragma_on() {
    let dir = tempfile::tempdir().unwrap();
    let pkg_config = Some(program(dir.path(), "echo '-I/x -I i -DA=1 -DB -pthread'"));
    let options = Options { pkg_config, ..Options::default() };
    let text = "A\n#pragma requires \"idl >= 2.0\" other\nA B\n#include <b.gen>\nend";
    let read = read_with(&[("a.gen", text), ("i/b.gen", "found")], &options);
    assert_eq!(read.tokens(), "A #requires <idl >= 2.0> <other> 1 1 found end");
    assert_eq!(read.messages(), "");
    let asked = std::fs::read_to_string(dir.path().join("log")).unwrap();
    assert_eq!(asked, "<--cflags><idl >= 2.0><other>");
}

#[test]
fn no_shell_sees_the_name_of_a_package() {
    let dir = tempfile::tempdir().unwrap();
    let pkg_config = Some(program(dir.path(), ""));
    let options = Options { pkg_config, ..Options::default() };
    let text = format!("#pragma requires \"x; touch {}/owned\"", dir.path().display());
    read_with(&[("a.gen", text.as_str())], &options);
    assert!(dir.path().join("log").exists());
    assert!(!dir.path().join("owned").exists());
}

#[test]
fn a_missing_package_is_an_error_until_a_directory_is_given() {
    let dir = tempfile::tempdir().unwrap();
    let pkg_config = Some(program(dir.path(), "echo 'no package x' >&2; exit 1"));
    let mut options = Options { pkg_config, ..Options::default() };
    let text = "#pragma requires \"x\"\n#include <b.gen>";
    let texts = [("a.gen", text), ("i/b.gen", "found")];
    expect![[r#"
        a.gen:1:18: E0131 package `x` not found: no package x
        a.gen:2:10: E0121 cannot find `b.gen`
    "#]]
    .assert_eq(&read_with(&texts, &options).messages());
    options.include_dirs.push("i".into());
    let read = read_with(&texts, &options);
    assert_eq!(read.tokens(), "#requires <x> found");
    expect![[r#"
        a.gen:1:18: W0106 package `x` not found: no package x
    "#]]
    .assert_eq(&read.messages());
}

#[test]
fn a_missing_pkg_config_is_an_error_that_names_the_package() {
    let pkg_config = Some(PathBuf::from("/nowhere/pkg-config"));
    let options = Options { pkg_config, ..Options::default() };
    let read = read_with(&[("a.gen", "#pragma requires x y")], &options);
    expect![[r#"
        a.gen:1:18: E0131 package `x`, `y` not found: there is no program `/nowhere/pkg-config` to find it
    "#]]
    .assert_eq(&read.messages());
    assert!(read.diagnostics[0].help.as_deref().unwrap().contains("-I DIR"));
}
