//! Headers compile, and have the layouts that genomd computes.

use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::process::Command;

use expect_test::expect_file;
use genom_description::Analysis;
use genom_description_tools::{Language, header};
use genom_types::{DataType, Kind};

use crate::support::{accepted, all_accepted, path};

fn include() -> PathBuf {
    path("../../plugin-api/include")
}

/// Runs a compiler, which must not print anything.
#[track_caller]
fn compile(command: &mut Command, what: &str) {
    let output = command.output().unwrap();
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success() && said.is_empty(), "{what}: {said}");
}

fn write_header(analysis: &Analysis, language: Language, dir: &Path, name: &str) -> PathBuf {
    let file = dir.join(name);
    std::fs::write(&file, header(&analysis.specification, None, language).unwrap()).unwrap();
    file
}

fn gcc(program: &str, standard: &str, dir: &Path) -> Command {
    let mut command = Command::new(program);
    command.args([standard, "-Wall", "-Wextra", "-Werror", "-I"]).arg(include()).arg("-I").arg(dir);
    command
}

#[test]
fn headers_compile_without_warning_in_c_and_cxx_and_rust() {
    let dir = tempfile::tempdir().unwrap();
    // All in one source: every header is included twice, then all of them together.
    let mut modules = String::new();
    for (rank, (file, analysis)) in all_accepted().iter().enumerate() {
        let what = file.display().to_string();
        let name = format!("h{rank}.h");
        write_header(analysis, Language::C, dir.path(), &name);
        let source = dir.path().join("x.c");
        std::fs::write(&source, format!("#include \"{name}\"\n#include \"{name}\"\n")).unwrap();
        compile(gcc("gcc", "-std=gnu99", dir.path()).arg("-fsyntax-only").arg(&source), &what);
        write_header(analysis, Language::Cxx, dir.path(), &name);
        let source = dir.path().join("x.cc");
        std::fs::write(&source, format!("#include \"{name}\"\n#include \"{name}\"\n")).unwrap();
        compile(gcc("g++", "-std=c++11", dir.path()).arg("-fsyntax-only").arg(&source), &what);
        write_header(analysis, Language::Rust, dir.path(), &format!("h{rank}.rs"));
        writeln!(modules, "pub mod h{rank};").unwrap();
    }
    let source = dir.path().join("lib.rs");
    std::fs::write(&source, modules).unwrap();
    let mut rustc = Command::new("rustc");
    rustc.args(["--edition=2021", "--crate-type=lib", "-Dwarnings", "--emit=metadata", "-o"]);
    compile(rustc.arg(dir.path().join("x.rmeta")).arg(&source), "rust");
}

#[test]
fn several_components_are_included_together_in_any_order() {
    let dir = tempfile::tempdir().unwrap();
    let demo = accepted(&path("tests/tools/rich.gen"));
    write_header(&demo, Language::C, dir.path(), "a.h");
    let other = dir.path().join("b.gen");
    let text = std::fs::read_to_string(path("tests/tools/rich.gen")).unwrap();
    std::fs::write(&other, text.replace("component demo", "component other")).unwrap();
    write_header(&accepted(&other), Language::C, dir.path(), "b.h");
    let source = dir.path().join("x.c");
    // Codels have other prototypes in the other component: only types can be shared.
    for (first, second) in [("a.h", "b.h"), ("b.h", "a.h")] {
        let strip = |name: &str| {
            let text = std::fs::read_to_string(dir.path().join(name)).unwrap();
            let kept: Vec<_> = text
                .lines()
                .filter(|line| !line.starts_with("genom_event ") || !line.ends_with(");"))
                .collect();
            std::fs::write(dir.path().join(format!("types_{name}")), kept.join("\n")).unwrap();
        };
        strip(first);
        strip(second);
        std::fs::write(
            &source,
            format!("#include \"types_{first}\"\n#include \"types_{second}\"\n"),
        )
        .unwrap();
        compile(gcc("gcc", "-std=gnu99", dir.path()).arg("-fsyntax-only").arg(&source), first);
    }
}

/// A C program that prints size, alignment and offsets of every type of a header.
fn measuring_program(analysis: &Analysis, expected: &mut String) -> String {
    let spec = &analysis.specification;
    let mut body = String::new();
    for (id, kind) in spec.types.iter() {
        let Ok(ty) = DataType::new(&spec.types, id) else { continue };
        let c = spec.types.c_name(id);
        // Structs made of parameters are not in the header.
        let record = match kind.name().map(|name| name.segments()) {
            Some([_, _, part]) => ["input", "output", "local"].contains(&part.as_str()),
            _ => false,
        };
        let measured = match kind {
            Kind::Native { .. } => false,
            Kind::Exception { members, .. } => !members.is_empty(),
            Kind::Sequence { .. } | Kind::Optional { .. } => true,
            kind => kind.name().is_some(),
        };
        if record || !measured {
            continue;
        }
        writeln!(body, "  printf(\"{c} %zu %zu\\n\", sizeof({c}), __alignof__({c}));").unwrap();
        writeln!(expected, "{c} {} {}", ty.size(), ty.align()).unwrap();
        let mut offset = |member: &str, at: usize| {
            writeln!(body, "  printf(\"  {member} %zu\\n\", offsetof({c}, {member}));").unwrap();
            writeln!(expected, "  {member} {at}").unwrap();
        };
        if let Kind::Struct { members, .. } | Kind::Exception { members, .. } = kind {
            for (rank, member) in members.iter().enumerate() {
                offset(&member.name, ty.member_offset(rank).unwrap());
            }
        }
        if let Kind::Union { members, .. } = kind {
            for (rank, member) in members.iter().enumerate() {
                offset(&format!("_u.{}", member.name), ty.member_offset(rank).unwrap());
            }
        }
    }
    format!(
        "#include <stddef.h>\n#include <stdio.h>\n#include \"h.h\"\nint main(void) {{\n{body}  return 0;\n}}\n"
    )
}

#[test]
fn sizes_and_offsets_in_c_and_cxx_are_those_of_genomd() {
    let languages =
        [("gcc", "-std=gnu99", Language::C, "x.c"), ("g++", "-std=c++11", Language::Cxx, "x.cc")];
    let dir = tempfile::tempdir().unwrap();
    for ((file, analysis), (compiler, standard, language, name)) in
        all_accepted().iter().flat_map(|one| languages.map(|language| (one, language)))
    {
        write_header(analysis, language, dir.path(), "h.h");
        let mut expected = String::new();
        let source = dir.path().join(name);
        std::fs::write(&source, measuring_program(analysis, &mut expected)).unwrap();
        let program = dir.path().join("x");
        let what = format!("{} in {compiler}", file.display());
        let mut command = gcc(compiler, standard, dir.path());
        compile(command.arg("-o").arg(&program).arg(&source), &what);
        let output = Command::new(&program).output().unwrap();
        assert_eq!(String::from_utf8_lossy(&output.stdout), expected, "{what}");
    }
    // The rich description must be among them, with its inner types.
    let mut expected = String::new();
    measuring_program(&accepted(&path("tests/tools/rich.gen")), &mut expected);
    assert!(expected.contains("demo_holder ") && expected.lines().count() > 80);
}

#[test]
fn the_header_is_that_of_the_reference_to_the_letter() {
    let analysis = accepted(&path("tests/tools/rich.gen"));
    let text = header(&analysis.specification, Some("demo"), Language::C).unwrap();
    // genom3.md 5.10 and around.
    for line in [
        "genom_event t_init(demo_ids *ids, const demo_mpin *mpin, const demo_mpout *mpout, const demo_name *name, const demo_note *note, const demo_point *point, const demo_matrix *matrix, const demo_colour *colour, const demo_shared *shared, const genom_context self);",
        "genom_event t_step(const demo_r1 *r1, const genom_context self);",
        "genom_event check(int32_t v, int32_t current, const genom_context self);",
        "genom_event fc(const char *d, const char e[8], char g[8], char **c, const demo_s *h, demo_s *i, const sequence_long *j, sequence_long *k, const demo_arr2 l, demo_arr2 m, m_col n, m_col *o, bool p, const optional_long *q, const demo_e_sys_detail *r, const demo_text t, demo_text *u, uint64_t w, float x, demo_flag *y, const demo_opaque *lo, demo_opaque **lo2, const genom_context self);",
        "genom_event fc2(const char *stb, int32_t sqa, demo_four *bsq, const demo_opaque *nat, demo_opaque **nat2, int32_t class_, int32_t input, int32_t *inout, demo_ids *all, const genom_context self);",
        "genom_event act_start(int32_t x, int32_t *y, int32_t *z, const demo_pin *pin, const demo_pout *pout, const genom_context self);",
        "genom_event act_step(int32_t a, int32_t self_, const genom_context self);",
        "genom_event act_stop(int32_t z, const genom_context self);",
        "  genom_event (*call)(i_long_type a, i_param b[3], char **d, genom_context self);",
        "  demo_s *(*data)(const char *id, genom_context self);",
        "  genom_event (*open)(const char *id, genom_context self);",
        "  char *(*data)(genom_context self);",
        "  demo_text *(*data)(genom_context self);",
        "  double *(*data)(genom_context self);",
        "GENOM_EVENT(demo_start, \"::demo::start\");",
        "GENOM_EVENT(demo_ether, \"::demo::ether\");",
        "GENOM_EVENT(demo_pause_start, \"::demo::pause::start\");",
        "GENOM_EVENT(demo_e_sys_id, \"::demo::e_sys\");",
        "demo_e_sys(const demo_e_sys_detail *detail, genom_context self)",
        "typedef void demo_e_void_detail;",
        "#ifndef _demo_s_c_type",
        "typedef uint32_t m_col;",
        "  m_RED = 0,",
        "  char _buffer[2][4];",
        "  uint32_t _maximum = 4, _length = 0;",
        "typedef struct node node;",
        "  node *_buffer;",
        "typedef int32_t demo_arr2[2][3];",
        "typedef struct demo_opaque demo_opaque;",
        "static const int8_t m_letter = 120;",
        "static const char *const m_name = \"a\\n\\\"b\\\" \\\\q\";",
        "static const m_col m_favourite = m_GREEN;",
        "static const int32_t m_depth = -2147483648;",
    ] {
        let found = text.lines().any(|found| found == line);
        assert!(found, "missing: {line}\nin:\n{text}");
    }
    // Split into what precedes the component's own types, and the rest.
    let middle = text.find("#ifndef _demo_opaque_c_type").expect("the component's first type");
    let (others, own) = text.split_at(middle);
    expect_file!["rich-others.h"].assert_eq(others);
    expect_file!["rich-own.h"].assert_eq(own);
    let rust = header(&analysis.specification, Some("demo"), Language::Rust).unwrap();
    expect_file!["rich.rs.txt"].assert_eq(&rust);
}

#[test]
fn structs_made_of_parameters_are_not_in_the_header() {
    let mut written = 0;
    for (file, analysis) in all_accepted() {
        let text = header(&analysis.specification, None, Language::C).unwrap();
        let components = analysis.specification.components.iter();
        let services = components.flat_map(|c| c.services.iter().map(move |s| (&c.name, &s.name)));
        let interfaces = analysis.specification.interfaces.iter();
        let others = interfaces.flat_map(|i| i.services.iter().map(move |s| (&i.name, s)));
        for (owner, service) in services.chain(others) {
            written += 1;
            for part in ["input", "output", "local"] {
                let tag = format!("struct {owner}_{service}_{part} ");
                assert!(!text.contains(&tag), "{tag}in {}", file.display());
            }
        }
    }
    assert!(written > 50, "only {written} services");
}

#[test]
fn the_papers_codels_have_their_prototypes() {
    let analysis = accepted(&path("../description/tests/papers/figure-2010.gen"));
    let text = header(&analysis.specification, None, Language::C).unwrap();
    let servo = "genom_event demo_servo(double position, double *velocity, const demo_position *position_port, const genom_context self);";
    assert!(text.contains(servo), "{text}");
    assert!(text.contains("GENOM_EVENT(demo_main, \"::demo::main\");"), "{text}");
}

/// Prototypes made by GenoM3 2.99.41 name the interface, older ones the component.
#[test]
fn ports_of_interfaces_have_the_names_of_both() {
    let dir = tempfile::tempdir().unwrap();
    let text = "interface camera { struct image { long width; }; port out image frame;
         port in image mask; };
         component eye { provides camera; task main { period 10 ms;
         codel<start> eye_look(port in mask, port out frame) yield ether; }; };
         component show { uses camera; task main { period 10 ms;
         codel<start> show_it(port in frame, port out mask) yield ether; }; };";
    let analysis = genom_description::read_text("x.gen", text, &Default::default());
    assert!(!analysis.has_errors(), "{:?}", analysis.diagnostics);
    write_header(&analysis, Language::C, dir.path(), "h.h");
    let source = dir.path().join("x.c");
    let codel = "#include \"h.h\"
        genom_event eye_look(const camera_mask *mask, const camera_frame *frame,
          const genom_context self)
        { mask->read(self); return frame->write(self); }
        genom_event show_it(const show_frame *frame, const show_mask *mask, const genom_context self)
        { frame->read(self); return mask->write(self); }
        const eye_frame *same(const camera_frame *frame) { return frame; }
        int main(void) { return 0; }\n";
    std::fs::write(&source, codel).unwrap();
    compile(gcc("gcc", "-std=gnu11", dir.path()).arg("-fsyntax-only").arg(&source), "C");
    compile(
        gcc("g++", "-std=c++17", dir.path()).args(["-fsyntax-only", "-x", "c++"]).arg(&source),
        "C++",
    );
}

#[test]
fn two_types_with_one_name_in_c_are_refused() {
    let text = "module a { struct b_c { long x; }; }; module a_b { struct c { double y; }; };";
    let analysis = genom_description::read_text("x.gen", text, &Default::default());
    let refused = header(&analysis.specification, None, Language::C).unwrap_err().to_string();
    assert_eq!(
        refused,
        "`::a::b_c` and `::a_b::c` have one name in C, `a_b_c`: rename one of them"
    );
}

#[test]
fn an_unknown_component_is_refused_with_those_there_are() {
    let analysis = accepted(&path("tests/tools/rich.gen"));
    let error = header(&analysis.specification, Some("nope"), Language::C).unwrap_err();
    assert_eq!(error.to_string(), "there is no component `nope`; those described are: `demo`");
}

/// Components of the project that have a hand-written header.
const COMPONENTS: [&str; 3] =
    ["components/demo", "components/demo/papers/2010", "components/demo/papers/2011"];

#[test]
fn codels_written_for_a_header_by_hand_compile_with_the_one_made_here() {
    for folder in COMPONENTS {
        let component = path("../..").join(folder);
        let analysis = accepted(&component.join("demo.gen"));
        let dir = tempfile::tempdir().unwrap();
        write_header(&analysis, Language::C, dir.path(), "demo_c_types.h");
        let mut sources = Vec::new();
        for entry in std::fs::read_dir(component.join("codels")).unwrap() {
            let file = entry.unwrap().path();
            let name = file.file_name().unwrap().to_string_lossy().into_owned();
            if name != "demo_c_types.h" {
                std::fs::copy(&file, dir.path().join(&name)).unwrap();
                sources.extend(Some(name).filter(|name| name.ends_with(".c")));
            }
        }
        assert!(!sources.is_empty(), "{folder} has no codels in C");
        for name in sources {
            let source = dir.path().join(&name);
            let what = format!("{folder}: {name}");
            compile(gcc("gcc", "-std=gnu99", dir.path()).arg("-fsyntax-only").arg(&source), &what);
        }
    }
}

#[test]
fn codels_in_cxx_can_use_every_type() {
    let dir = tempfile::tempdir().unwrap();
    write_header(&accepted(&path("tests/tools/rich.gen")), Language::Cxx, dir.path(), "h.h");
    let program = dir.path().join("x");
    for standard in ["-std=c++11", "-std=c++14", "-std=c++20"] {
        let mut command = gcc("g++", standard, dir.path());
        command.arg("-o").arg(&program).arg(path("tests/tools/codels.cc"));
        compile(&mut command, standard);
        assert!(Command::new(&program).status().unwrap().success(), "{standard} misbehaves");
    }
}

/// Sources of codels depend on what GenoM3's headers included, errno above all.
#[test]
fn codels_that_include_only_the_header_have_errno_memory_and_strings() {
    let dir = tempfile::tempdir().unwrap();
    write_header(&accepted(&path("tests/tools/rich.gen")), Language::C, dir.path(), "h.h");
    let text = "#include \"h.h\"\n\
        static inline genom_event failed(const char *what, genom_context self) {\n\
          demo_e_sys_detail d;\n\
          d.code = errno;\n\
          assert(what != NULL);\n\
          strncpy(d.what, what, sizeof(d.what) - 1);\n\
          return demo_e_sys(&d, self);\n\
        }\n\
        genom_event check(int32_t v, int32_t current, const genom_context self) {\n\
          char *copy = (char *)malloc(8);\n\
          if (!copy || v == current) return failed(\"check\", self);\n\
          free(copy);\n\
          return v ? demo_e_sys(NULL, self) : genom_ok;\n\
        }\n";
    for (program, standard, name) in
        [("gcc", "-std=gnu99", "x.c"), ("gcc", "-std=gnu17", "x.c"), ("g++", "-std=c++20", "x.cc")]
    {
        let source = dir.path().join(name);
        std::fs::write(&source, text).unwrap();
        compile(gcc(program, standard, dir.path()).arg("-fsyntax-only").arg(&source), standard);
    }
}

/// genom3.md D: `_maximum` of bounded sequences is not const, so whole structs can be assigned.
#[test]
fn codels_assign_structs_with_bounded_sequences_whole() {
    let dir = tempfile::tempdir().unwrap();
    write_header(&accepted(&path("tests/tools/rich.gen")), Language::C, dir.path(), "h.h");
    let text = "#include \"h.h\"\n\
        void both(demo_four *to, demo_holder *all, const demo_holder *from) {\n\
          *to = (demo_four){ ._maximum = 4, ._length = 1, ._buffer = { 2. } };\n\
          *all = *from;\n\
        }\n";
    let source = dir.path().join("x.c");
    std::fs::write(&source, text).unwrap();
    compile(gcc("gcc", "-std=gnu99", dir.path()).arg("-fsyntax-only").arg(&source), "x.c");
}
