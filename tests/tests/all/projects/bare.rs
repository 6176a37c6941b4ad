//! `genomctl build` of a description and its codels, without any build files.

use std::fs;
use std::path::PathBuf;
use std::process::{Command, Output};

use genom_components::debian;
use genom_tests::{Home, path, program};

use super::{Prefix, copied};

/// A component whose build files are taken away.
struct Place {
    prefix: Prefix,
    scratch: tempfile::TempDir,
    directory: PathBuf,
}

impl Place {
    fn new(name: &str) -> Self {
        let scratch = tempfile::tempdir().unwrap();
        let directory = copied(name, scratch.path());
        for file in ["configure.ac", "Makefile.am", "codels/Makefile.am"] {
            fs::remove_file(directory.join(file)).unwrap();
        }
        let prefix = Prefix::new();
        prefix.add_shapes();
        Self { prefix, scratch, directory }
    }

    fn build(&self, arguments: &[&str]) -> Output {
        let mut command = Command::new(program("genomctl"));
        command.arg("build").args(arguments).current_dir(self.scratch.path());
        command.envs(self.prefix.environment(&debian::autotools().unwrap()));
        command.output().unwrap()
    }

    fn file(&self, name: &str) -> PathBuf {
        self.directory.join(name)
    }
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

#[test]
fn a_description_and_its_codels_become_a_library_that_runs() {
    for (name, service, input) in [("axis", "set_speed", "speed=0.5"), ("turret", "aim", "angle=1")]
    {
        let place = Place::new(name);
        let built = place.build(&[name]);
        assert!(built.status.success(), "{}", text(&built.stderr));
        let library = place.scratch.path().join(text(&built.stdout).trim());
        assert_eq!(library, place.file(&format!("build/{name}.so")));
        // The description and what it includes lie beside the library.
        let packages = format!("PKG_CONFIG_PATH={}/share/pkgconfig", place.prefix.path().display());
        let daemon = Home::new().start_by(&["env", &packages], &[path(&library)]);
        daemon.ctl(&["call", name, service, input]).expect_code(0);
    }
}

#[test]
fn only_sources_that_changed_are_compiled_again() {
    let place = Place::new("axis");
    let date = |name: &str| fs::metadata(place.file(name)).unwrap().modified().unwrap();
    assert!(place.build(&["axis"]).status.success());
    let objects = ["build/objects/axis_codels_cc.o", "build/objects/axis_motion_codels_c.o"];
    let before = objects.map(date);
    let source = place.file("codels/axis_motion_codels.c");
    let more = fs::read_to_string(&source).unwrap() + "\n/* More. */\n";
    fs::write(&source, more).unwrap();
    assert!(place.build(&["axis/axis.gen"]).status.success());
    let after = objects.map(date);
    assert_eq!(before[0], after[0]);
    assert_ne!(before[1], after[1]);
}

#[test]
fn a_codel_with_other_parameters_is_explained_against_the_description() {
    let place = Place::new("axis");
    let change = |name: &str, from: &str, to: &str| {
        let file = place.file(name);
        let text = fs::read_to_string(&file).unwrap();
        assert!(text.contains(from));
        fs::write(&file, text.replace(from, to)).unwrap();
    };
    // In C the compiler sees it.
    change("codels/axis_motion_codels.c", "axis_go(double x", "axis_go(long x");
    let refused = place.build(&["axis"]);
    let told = text(&refused.stderr);
    assert_eq!(refused.status.code(), Some(1), "{told}");
    assert!(
        told.contains("axis_motion_codels.c:23: axis_go is not what axis/axis.gen:37 asks for")
    );
    assert!(told.contains("    genom_event axis_go(double x, double speed,"), "{told}");
    change("codels/axis_motion_codels.c", "axis_go(long x", "axis_go(double x");
    // In C++ it is another function, and only the linker misses the codel.
    change("codels/axis_codels.cc", "axis_check_speed(double", "axis_check_speed(int");
    let told = text(&place.build(&["axis"]).stderr);
    assert!(told.contains("axis_check_speed is not what axis/axis.gen:21 asks for"), "{told}");
    assert!(told.contains("error: the library was not linked"), "{told}");
    change("codels/axis_codels.cc", "axis_check_speed(int", "other(double");
    let told = text(&place.build(&["axis"]).stderr);
    assert!(told.contains("codel axis_check_speed is in none of the sources"), "{told}");
    assert!(!place.file("build/axis.so").exists());
}

#[test]
fn what_cannot_be_built_is_told_with_the_way_out() {
    let place = Place::new("axis");
    let told = |arguments: &[&str]| {
        let output = place.build(arguments);
        assert!(!output.status.success());
        text(&output.stderr)
    };
    let empty = place.scratch.path().join("empty");
    fs::create_dir(&empty).unwrap();
    assert!(told(&["empty"]).contains("empty: no .gen file with codels, and no build files"));
    fs::copy(place.file("axis.gen"), empty.join("axis.gen")).unwrap();
    fs::copy(place.file("limits.idl"), empty.join("limits.idl")).unwrap();
    assert!(told(&["empty"]).contains("there is no .c, .cc, .cpp or .cxx file in empty"));
    let description = fs::read_to_string(place.file("axis.gen")).unwrap();
    let more =
        description.replace("require \"genom3 >= 2.99.26\";", "codels-require \"no-such >= 1\";");
    fs::write(place.file("axis.gen"), more).unwrap();
    let said = told(&["axis"]);
    assert!(
        said.contains("shapes-idl >= 2.0, no-such >= 1 that the description requires: ")
            && said.contains("PKG_CONFIG_PATH"),
        "{said}"
    );
    assert!(told(&["none.gen"]).contains("none.gen"));
}

#[test]
fn a_component_is_found_by_pkg_config_also_where_a_directory_has_a_blank() {
    let place = Place::new("axis");
    let built = place.build(&["axis"]);
    assert!(built.status.success(), "{}", text(&built.stderr));
    let prefix = place.scratch.path().join("a b");
    let (lib, idl) = (prefix.join("lib"), prefix.join("share/idl/axis"));
    for directory in [&lib.join("pkgconfig"), &idl] {
        fs::create_dir_all(directory).unwrap();
    }
    fs::copy(place.file("build/axis.so"), lib.join("libaxis_codels-1.0.so")).unwrap();
    for name in ["axis.gen", "limits.idl"] {
        fs::copy(place.file(name), idl.join(name)).unwrap();
    }
    // As one that was moved: pkg-config quotes blanks of directories that it finds itself.
    let package = "prefix=${pcfiledir}/../..\nidldir=${prefix}/share/idl/axis\n\
        Name: axis-genom3\nDescription: axis\nVersion: 1.0\n\
        Cflags: -I${idldir}\nLibs: -L${prefix}/lib\n";
    fs::write(lib.join("pkgconfig/axis-genom3.pc"), package).unwrap();
    let mut check = Command::new(program("genomd"));
    check.args(["--check", "axis"]).current_dir(place.scratch.path());
    check.envs(place.prefix.environment(&debian::autotools().unwrap()));
    let packages = [lib.join("pkgconfig"), place.prefix.path().join("share/pkgconfig")];
    let output = check.env("PKG_CONFIG_PATH", std::env::join_paths(packages).unwrap()).output();
    let output = output.unwrap();
    assert!(output.status.success(), "{}", text(&output.stderr));
}
