//! `genomctl add`: what a project has grown by builds, and what was written is still there.

use std::fs;
use std::path::Path;
use std::process::Command;

use genom_tests::{Daemon, Finished, Running, path, program};

struct Project {
    scratch: tempfile::TempDir,
}

impl Project {
    /// A new component `arm`, which its author has changed.
    fn new(language: &str) -> Self {
        let project = Self { scratch: tempfile::tempdir().unwrap() };
        project.ctl(&["new", "arm", "--lang", language]).expect_code(0);
        project.edit("arm/arm.gen", "  task motion {", "  /* Mine. */\n  task motion {  // fast");
        project.edit("arm/arm.gen", "    period 10 ms;", "\tperiod   10 ms;   /* kept */");
        project
    }

    fn path(&self, name: &str) -> std::path::PathBuf {
        self.scratch.path().join(name)
    }

    fn text(&self, name: &str) -> String {
        fs::read_to_string(self.path(name)).unwrap()
    }

    #[track_caller]
    fn edit(&self, name: &str, old: &str, new: &str) {
        let text = self.text(name);
        assert!(text.contains(old), "{text}");
        fs::write(self.path(name), text.replacen(old, new, 1)).unwrap();
    }

    fn ctl(&self, arguments: &[&str]) -> Finished {
        let mut command = Command::new(program("genomctl"));
        command.args(arguments).current_dir(self.scratch.path());
        Running::start(&mut command).finish()
    }

    #[track_caller]
    fn add(&self, arguments: &[&str]) -> String {
        let finished = self.ctl(&[&["add", "-C", "arm"], arguments].concat());
        finished.expect_code(0);
        finished.out
    }
}

/// Whether all lines of `old` are in `new`, in their order.
fn keeps(old: &str, new: &str) -> bool {
    let mut lines = new.lines();
    old.lines().all(|line| lines.any(|other| other == line))
}

#[test]
fn what_is_added_to_a_component_builds_and_runs_and_what_was_written_stays() {
    for (language, codels) in
        [("c", "arm/codels/arm_codels.c"), ("c++", "arm/codels/arm_codels.cc")]
    {
        let project = Project::new(language);
        let before = [project.text("arm/arm.gen"), project.text(codels)];
        project.add(&["port", "out", "target=place", "--doc", "Where it \"goes\"."]);
        let told = project.add(&["task", "plan", "--period", "20ms"]);
        let name = path(Path::new(codels));
        assert_eq!(
            told,
            format!(
                "changed arm/arm.gen\nadded arm_plan_start to {name}\nadded arm_plan_main to {name}\n"
            )
        );
        project.add(&[
            "service",
            "go_to",
            "--activity",
            "--in",
            "goal=double=0.5",
            "--in",
            "path=place[2]",
            "--task",
            "plan",
            "--validate",
            "--throw",
            "e_out_of_range",
            "--interrupt",
            "move_to",
        ]);
        project.add(&["service", "twice", "--function", "--in", "a=long", "--out", "b=long"]);
        project.add(&["service", "get_speed", "--attribute", "--out", "speed"]);

        let description = project.text("arm/arm.gen");
        assert!(keeps(&before[0], &description), "{description}");
        assert!(project.text(codels).starts_with(&before[1]), "added at the end");
        for line in [
            "  port out place current;\n\n  port out place target {\n    doc \"Where it \\\"goes\\\".\";\n  };\n",
            "\n  task plan {\n    period 20 ms;\n    codel<start> arm_plan_start() yield main;\n",
            "\n  activity go_to(in double goal = 0.5, in place path[2]) {\n    task plan;\n",
            "    throw e_out_of_range;\n    interrupt move_to;\n  };\n",
            "\n  attribute get_speed(out speed);\n",
        ] {
            assert!(description.contains(line), "{line} in {description}");
        }

        // The author goes on, and the rest is found where it is.
        project.edit(codels, "/* your code */", "/* mine */");
        project.ctl(&["build", "arm/arm.gen"]).expect_code(0);
        let library = project.path("arm/build/arm.so");
        let daemon = Daemon::start(&["--clock", "virtual", path(&library)]);
        let places = "path=[{\"position\": 0.0}, {\"position\": 1.0}]";
        daemon.ctl(&["start", "arm", "go_to", places]).expect_code(0);
        daemon.ctl(&["step", "1s"]).expect_code(0);
        daemon.ctl(&["wait", "arm", "go_to"]).expect_code(0).expect_out("done\n");
        daemon.ctl(&["call", "arm", "twice", "a=2"]).expect_code(0);
        daemon.ctl(&["call", "arm", "get_speed"]).expect_code(0).expect_out("speed = 0.5\n");
    }
}

#[test]
fn a_mistake_changes_nothing_and_is_told_with_its_reason() {
    let project = Project::new("c");
    let before = [project.text("arm/arm.gen"), project.text("arm/codels/arm_codels.c")];
    for (arguments, code, told) in [
        (&["port", "out", "p=Pose"][..], 1, "unknown type `Pose`"),
        (&["port", "out", "p"], 1, "`p` has no type; write p=double"),
        (&["port", "out", "current=place"], 1, "current"),
        (&["task", "motion"], 1, "motion"),
        (&["task", "a b"], 1, "`a b` is no name of a task"),
        (&["task", "t", "--period", "10"], 2, "a unit is missing"),
        (&["service", "go"], 2, "required arguments"),
        (&["service", "go", "--activity", "--in", "x=double; };"], 1, "is no type"),
        (&["service", "go", "--activity", "--task", "none"], 1, "none"),
        (&["service", "go", "--attribute", "--in", "height"], 1, "height"),
        (&["service", "go", "--attribute", "--in", "speed=double"], 1, "write it without type"),
        (&["service", "go", "--function", "--task", "motion"], 2, "--activity"),
        (&["service", "go", "--function", "--throw", "e_none"], 1, "e_none"),
        (&["service", "go", "--function", "--throw", "a; };"], 1, "`a; };` is no name"),
    ] {
        let refused = project.ctl(&[&["add", "-C", "arm/arm.gen"], arguments].concat());
        refused.expect_code(code).expect_err(told);
        if code == 1 {
            refused.expect_err("nothing was changed");
        }
        let now = [project.text("arm/arm.gen"), project.text("arm/codels/arm_codels.c")];
        assert_eq!(now, before, "{arguments:?}");
    }
    // A second task: an activity has to say which.
    project.add(&["task", "other"]);
    let refused = project.ctl(&["add", "-C", "arm", "service", "go", "--activity"]);
    refused.expect_code(1).expect_err("name the task that runs it; there are: motion, other");
    project.ctl(&["add", "-C", "nowhere", "task", "t"]).expect_code(1).expect_err("nowhere");
    project.edit("arm/arm.gen", "struct place", "strukt place");
    project.ctl(&["add", "-C", "arm", "task", "t"]).expect_code(1).expect_err("as it is");
}

#[test]
fn an_existing_function_of_that_name_is_left_and_what_differs_is_told() {
    let project = Project::new("c");
    let codels = "arm/codels/arm_codels.c";
    let mine =
        "\ngenom_event\narm_twice(double a, const genom_context self)\n{\n  return genom_ok;\n}\n";
    fs::write(project.path(codels), project.text(codels) + mine).unwrap();
    let before = project.text(codels);
    let told = project.add(&["service", "twice", "--function", "--in", "a=long"]);
    let wanted = "arm_twice(int32_t a, const genom_context self)";
    assert!(told.contains(": arm_twice is there already") && told.contains(wanted), "{told}");
    assert_eq!(project.text(codels), before);
}
