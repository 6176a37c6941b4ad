//! The command `genom3`, as the builds of components call it (GenoM3 manual, "Running genom3").

use std::fs;
use std::os::unix::fs::PermissionsExt as _;
use std::path::Path;
use std::process::{Command, Output};

use genom_tests::{program, repository};

use super::Prefix;

/// A directory with the command and a description.
struct Room {
    prefix: Prefix,
    scratch: tempfile::TempDir,
}

impl Room {
    fn new(description: &str) -> Self {
        let room = Self { prefix: Prefix::new(), scratch: tempfile::tempdir().unwrap() };
        room.write("a.gen", description);
        room
    }

    fn path(&self) -> &Path {
        self.scratch.path()
    }

    fn write(&self, name: &str, text: &str) {
        fs::write(self.path().join(name), text).unwrap();
    }

    fn text(&self, name: &str) -> String {
        fs::read_to_string(self.path().join(name)).unwrap()
    }

    fn output(&self, arguments: &str) -> Output {
        let mut command = Command::new(self.prefix.path().join("bin/genom3"));
        command.args(arguments.split_whitespace()).current_dir(self.path());
        command.stdin(std::process::Stdio::null()).output().unwrap()
    }

    #[track_caller]
    fn ok(&self, arguments: &str) -> String {
        let output = self.output(arguments);
        let told = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(output.status.success(), "genom3 {arguments}: {told}");
        String::from_utf8(output.stdout).unwrap()
    }

    /// Exit status and what is told.
    fn refused(&self, arguments: &str) -> (i32, String) {
        let output = self.output(arguments);
        (output.status.code().unwrap(), String::from_utf8_lossy(&output.stderr).into_owned())
    }
}

const ARM: &str = "component arm {
  version \"1.0\"; lang \"c\"; email \"a@example.org\"; require \"genom3 >= 2.99\";
  ids { double speed; };
  attribute set_speed(in speed) { validate arm_check(local in speed); };
  task main { period 10 ms; };
  activity go(in double x) { task main; codel<start> arm_go(in x) yield pause::start, ether; };
};
";

#[test]
fn the_exit_status_of_a_check_is_the_number_of_errors() {
    let room = Room::new(ARM);
    assert_eq!(room.output("-n a.gen").status.code(), Some(0));
    room.write("bad.gen", "typedef lonk t;\ntypedef lonk u;\n");
    let (code, told) = room.refused("--parse-only bad.gen");
    assert_eq!(code, 2, "{told}");
    assert!(told.contains("bad.gen:1:9: error: unknown type `lonk`"), "{told}");
    let (code, told) = room.refused("-n none.gen");
    assert!(code == 1 && told.contains("none.gen: "), "{told}");
}

#[test]
fn the_version_is_one_that_packages_ask_for() {
    let room = Room::new(ARM);
    assert!(room.ok("--version").starts_with("genom3 2.99.4"));
    let mut asked = Command::new("pkg-config");
    asked.args(["--print-errors", "--exists", "genom3 >= 2.99.26"]);
    let programs = genom_components::debian::autotools().unwrap();
    room.prefix.run(asked.envs(room.prefix.environment(&programs)));
}

#[test]
fn preprocessed_text_reads_like_the_files_it_was_made_of() {
    let room = Room::new("#include \"t.idl\"\n#ifdef WIDE\ntypedef double w;\n#endif\n");
    room.write("t.idl", "#define N 3\nconst long n = N;\n");
    let text = room.ok("-D WIDE -E a.gen");
    assert!(text.contains("# 2 \"t.idl\"\nconst long n = 3 ;"), "{text}");
    assert!(text.contains("typedef double w ;"), "{text}");
    let dumped = room.ok("-DWIDE -N a.gen");
    assert_eq!(dumped, "const long n = 3;\ntypedef double w;\n");
}

#[test]
fn mappings_are_a_header_and_a_rule_for_make() {
    let room = Room::new(ARM);
    let header = room.ok("mappings -MD -MF .deps/a.d -MT a.h --signature -l c a.gen");
    assert!(header.contains("genom_event arm_go(double x, const genom_context self);"));
    assert_eq!(room.text(".deps/a.d"), "a.h: \\\n  a.gen\n\na.gen:\n");
    let types = room.ok("mappings a.gen");
    assert!(types.contains("GENOM_EVENT(arm_start") && !types.contains("arm_go("), "{types}");
    room.ok("mappings -MD a.gen");
    assert!(room.text("out.d").starts_with("out: "));
    let (code, told) = room.refused("mappings -l python a.gen");
    assert!(code == 2 && told.contains("no mappings for language python"), "{told}");
}

#[test]
fn a_skeleton_has_an_empty_codel_for_each_that_the_description_names() {
    let room = Room::new(ARM);
    let told = room.ok("skeleton -C new a.gen");
    assert!(told.contains("creating new/codels/arm_main_codels.c\n"), "{told}");
    let codels = room.text("new/codels/arm_main_codels.c");
    assert!(codels.contains("genom_event\narm_go(double x, const genom_context self)\n{"));
    assert!(codels.contains("return arm_pause_start;"), "{codels}");
    assert!(room.text("new/codels/arm_codels.c").contains("arm_check("));
    assert!(room.text("new/configure.ac").contains("[arm-genom3], [1.0]"));
    let again = room.ok("skeleton -C new a.gen");
    assert!(!again.contains("creating"), "{again}");
    let cxx = room.ok("skeleton -C cxx -l c++ -t a.gen");
    assert!(cxx.contains("cxx/codels/arm_codels.cc"), "{cxx}");
    assert!(!room.text("cxx/codels/arm_codels.cc").contains("Validates"));
}

#[test]
fn a_merge_adds_what_is_new_keeps_what_was_written_and_marks_what_differs() {
    let room = Room::new(ARM);
    room.ok("skeleton a.gen");
    let mine = room.text("codels/arm_codels.c").replace("/* your code */", "int mine = 1;");
    room.write("codels/arm_codels.c", &mine);
    let more = "  function home(in double at) { codel arm_home(in at); };\n  task";
    let changed = ARM.replacen("  task", more, 1).replace("(in double x)", "(in long x)");
    room.write("a.gen", &changed);

    let told = room.ok("skeleton -u a.gen");
    assert!(told.contains("adding arm_home to codels/arm_codels.c"), "{told}");
    assert!(told.contains("differs: codels/arm_main_codels.c:"), "{told}");
    let codels = room.text("codels/arm_codels.c");
    assert!(codels.starts_with(&mine) && codels.contains("\narm_home(double at,"), "{codels}");
    let marked = room.text("codels/arm_main_codels.c");
    assert!(marked.contains("<<<<<<< codels/arm_main_codels.c\ngenom_event\narm_go(double x"));
    assert!(marked.contains("=======\ngenom_event arm_go(int32_t x"), "{marked}");
    // There is nobody to ask.
    room.write("codels/arm_main_codels.c", "void arm_go(long x) {}\n");
    let (code, told) = room.refused("skeleton -i a.gen");
    assert!(code == 2 && told.contains("takes a terminal"), "{told}");
}

#[test]
fn a_merge_tool_gets_the_existing_source_and_a_proposal() {
    let room = Room::new(ARM);
    room.ok("skeleton a.gen");
    room.write("a.gen", &ARM.replace("(in double x)", "(in long x)"));
    let tool = room.path().join("tool");
    fs::write(&tool, "#!/bin/sh\necho \"$@\" >called\ncp \"$2\" \"$1\"\n").unwrap();
    fs::set_permissions(&tool, fs::Permissions::from_mode(0o755)).unwrap();
    room.ok("skeleton -m ./tool a.gen");
    let called = "codels/arm_main_codels.c codels/arm_main_codels.c.proposed\n";
    assert_eq!(room.text("called"), called);
    assert!(room.text("codels/arm_main_codels.c").contains("arm_go(int32_t x"));
    assert!(!room.path().join("codels/arm_main_codels.c.proposed").exists());
}

#[test]
fn templates_that_generate_servers_are_refused_with_the_reason() {
    let room = Room::new(ARM);
    assert_eq!(room.ok("-l"), "genomd/cmake\ngenomd/server\nmappings\nskeleton\n");
    let (code, told) = room.refused("pocolibs/server -C x a.gen");
    assert!(code == 2 && told.contains("binds components to middlewares"), "{told}");
    let (code, told) = room.refused("a.gen");
    assert!(code == 2 && told.contains("`genom3 -n a.gen`"), "{told}");
    assert_eq!(room.refused("").0, 2);
    assert_eq!(room.refused("--no-such-option").0, 2);
}

#[test]
fn an_sdk_does_not_replace_genom3_of_another_package() {
    let prefix = tempfile::tempdir().unwrap();
    let bin = prefix.path().join("bin");
    fs::create_dir(&bin).unwrap();
    fs::write(bin.join("genom3"), "another").unwrap();
    let output = Command::new(program("genomctl")).arg("sdk").arg(prefix.path()).output().unwrap();
    assert!(!output.status.success());
    assert!(String::from_utf8_lossy(&output.stderr).contains("did not install"));
    assert_eq!(fs::read_to_string(bin.join("genom3")).unwrap(), "another");
    // The headers are those of the repository.
    let event = "include/genom3/c/event.h";
    let own = fs::read(repository().join("plugin-api").join(event)).unwrap();
    assert_eq!(fs::read(prefix.path().join(event)).unwrap(), own);
}
