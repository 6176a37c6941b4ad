//! Components with the build of GenoM3's own components (genom3.md 5.9) are built unmodified, with
//! genomd in the place of GenoM3.

use std::fs;
use std::path::Path;
use std::process::Command;

use genom_components::debian;
use genom_tests::{Home, path, repository};

use super::{Prefix, copied};

/// The macros that such projects have a copy of.
const MACROS: &str = "daemon/project/templates/autotools/autoconf/ag_templates.m4";

/// A project, and where it is built.
struct Project {
    prefix: Prefix,
    sources: std::path::PathBuf,
    build: std::path::PathBuf,
    scratch: tempfile::TempDir,
}

impl Project {
    fn new(name: &str, build: &str) -> Self {
        let scratch = tempfile::tempdir().unwrap();
        let sources = copied(name, scratch.path());
        fs::create_dir(sources.join("autoconf")).unwrap();
        let macros = sources.join("autoconf/ag_templates.m4");
        fs::copy(repository().join(MACROS), macros).unwrap();
        let build = sources.join(build);
        fs::create_dir_all(&build).unwrap();
        Self { prefix: Prefix::new(), sources, build, scratch }
    }

    #[track_caller]
    fn run(&self, directory: &Path, command: &str) -> String {
        let programs = debian::autotools().unwrap();
        let mut run = Command::new("sh");
        run.args(["-c", command]).current_dir(directory);
        run.envs(self.prefix.environment(&programs));
        self.prefix.run(&mut run)
    }

    /// What a user types.
    fn install(&self, options: &str) {
        self.run(&self.sources, "autoreconf -i");
        let configure = self.sources.join("configure");
        let prefix = self.prefix.path().display();
        let line = format!("{} --prefix={prefix} {options}", configure.display());
        self.run(&self.build, &line);
        self.run(&self.build, "make");
        self.run(&self.build, "make install");
    }
}

#[test]
fn a_component_with_types_of_a_package_is_built_out_of_tree_and_found_below_its_prefix() {
    let project = Project::new("axis", "build");
    project.prefix.add_shapes();
    project.install("--with-templates=genomd/server");
    let prefix = project.prefix.path();
    assert!(prefix.join("lib/libaxis_codels-1.4.so").is_file());
    assert!(prefix.join("share/idl/axis/axis.gen").is_file());
    let packages = format!("PKG_CONFIG_PATH={}/share/pkgconfig", prefix.display());

    let found = Home::new().start_by(&["env", &packages], &["--path", path(prefix), "axis"]);
    found.ctl(&["call", "axis", "set_speed", "speed=0.5"]).expect_code(0);
    let refused = found.ctl(&["call", "axis", "set_speed", "speed=2"]);
    refused.expect_code(1);
    assert!(refused.err.contains("axis::e_range"), "{}", refused.err);
    found.ctl(&["call", "axis", "go", "x=3"]).expect_code(0);
    let at = found.json(&["call", "axis", "where"]);
    assert_eq!(at["result"]["at"]["x"], 3.0, "{at}");
    drop(found);

    // The program of genomd/server names the library by itself.
    let checked = project.run(&project.build, "axis-genomd --check");
    assert!(checked.contains("axis"), "{checked}");

    // The header is made again when a file changes that the description includes.
    fs::write(project.sources.join("limits.idl"), "const double axis_greatest_speed = 2.0;\n")
        .unwrap();
    let made = project.run(&project.build, "make");
    assert!(made.contains("mappings"), "{made}");
    project.run(&project.build, "make uninstall && make distclean");
    assert!(!prefix.join("bin/axis-genomd").exists());
}

#[test]
fn a_component_in_cpp_is_built_in_tree_and_found_by_pkg_config() {
    let project = Project::new("turret", ".");
    project.install("");
    let prefix = project.prefix.path().display();
    let packages = format!("PKG_CONFIG_PATH={prefix}/share/pkgconfig:{prefix}/lib/pkgconfig");

    let found = Home::new().start_by(&["env", &packages], &["turret"]);
    for count in 1..=2 {
        let reply = found.json(&["call", "turret", "aim", "angle=0.5"]);
        assert_eq!(reply["result"]["count"], count, "{reply}");
    }
}

#[test]
fn a_skeleton_is_a_project_that_builds_and_runs() {
    let project = Project::new("turret", ".");
    let own = project.scratch.path().join("new");
    fs::create_dir(&own).unwrap();
    fs::copy(project.sources.join("turret.gen"), own.join("turret.gen")).unwrap();
    project.run(&own, "genom3 skeleton turret.gen && ./autogen.sh");
    let prefix = project.prefix.path().display();
    project.run(&own, &format!("./configure --prefix={prefix} && make install"));
    let found = Home::new().start(&["--path", path(project.prefix.path()), "turret"]);
    found.ctl(&["call", "turret", "aim", "angle=0.5"]).expect_code(0);
}
