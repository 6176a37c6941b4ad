//! A library that disagrees with its description is refused before any of its code runs.

#![allow(clippy::expect_used)] // helpers are no test functions

mod support;

use std::path::PathBuf;
use std::sync::Arc;

use expect_test::{Expect, expect};
use genom_description::source::SourceMap;
use genom_host::contract::{Checked, check};
use genom_host::{Component, Library};
use genom_runtime::plan::Plan;
use support::Scratch;
use support::demo::{in_c, in_rust, root};

const DEMO: &str = include_str!("../../../components/demo/demo.gen");

/// Plan of the first component of a description, and the map of its lines.
fn plan(text: &str) -> (Plan, SourceMap) {
    let analysis = genom_description::read_text("demo.gen", text, &Default::default());
    assert!(!analysis.has_errors(), "{:?}", analysis.diagnostics);
    let plan = Plan::new(&Arc::new(analysis.specification), 0).expect("a plan");
    (plan, analysis.sources)
}

/// Expects these differences between `path` and `text`.
#[track_caller]
fn disagree(path: PathBuf, text: &str, expected: &Expect) {
    let (plan, sources) = plan(text);
    let locate = |span| format!("demo.gen:{}", sources.location(span).line);
    let library = Library::open(&path).expect("a library");
    let name = path.display().to_string();
    let shown = match Component::load(library, &plan, &locate) {
        Ok(_) => "loads".to_owned(),
        Err(errors) => errors.to_string().replace(&name, "demo.so"),
    };
    expected.assert_eq(&shown);
}

/// The demo's description with `from` replaced by `to`.
#[track_caller]
fn altered(from: &str, to: &str) -> String {
    assert!(DEMO.contains(from), "the demo has {from:?}");
    DEMO.replacen(from, to, 1)
}

#[test]
fn the_demo_in_rust_agrees_with_its_description() {
    disagree(in_rust(), DEMO, &expect!["loads"]);
    let (plan, _) = plan(DEMO);
    let report = check(&Library::open(&in_rust()).unwrap(), &plan, &|_| String::new());
    assert_eq!((report.checked, report.codels), (Checked::Descriptors, 8));
    assert_eq!(report.differences, []);
}

#[test]
fn the_demo_in_c_agrees_with_its_description_by_its_debug_information() {
    let scratch = Scratch::new();
    for options in [&["-gdwarf-5"][..], &["-gdwarf-4", "-O2"], &["-gdwarf-3"]] {
        let path = in_c(&scratch, options);
        disagree(path.clone(), DEMO, &expect!["loads"]);
        let report = check(&Library::open(&path).unwrap(), &plan(DEMO).0, &|_| String::new());
        assert_eq!((report.checked, report.codels), (Checked::DebugInformation, 8), "{options:?}");
    }
    let path = in_c(&scratch, &["-g0"]);
    let text = altered("demo_reset(inout current)", "demo_reset(in velocity)");
    let report = check(&Library::open(&path).unwrap(), &plan(&text).0, &|_| String::new());
    assert_eq!((report.checked, report.codels), (Checked::Unchecked, 0));
}

#[test]
fn the_figures_of_both_papers_agree_with_their_codels() {
    let scratch = Scratch::new();
    for paper in ["2010", "2011"] {
        let directory = root().join("components/demo/papers").join(paper);
        let source = directory.join("codels/demo_codels.c");
        let include = format!("-I{}", directory.display());
        let source = source.to_str().expect("a path in UTF-8");
        let path = scratch.cc("demo.so", "", &["-shared", "-fPIC", &include, source]);
        let description = directory.join("demo.gen");
        let analysis = genom_description::read(&[description], &Default::default());
        assert!(!analysis.has_errors(), "{:?}", analysis.diagnostics);
        let plan = Plan::new(&Arc::new(analysis.specification), 0).expect("a plan");
        let library = Library::open(&path).unwrap();
        let report = check(&library, &plan, &|_| "demo.gen".to_owned());
        assert_eq!(report.checked, Checked::DebugInformation, "{paper}");
        assert_eq!(report.differences, [], "{paper}");
        let loaded = Component::load(library, &plan, &|_| "demo.gen".to_owned());
        assert_eq!(loaded.err().map(|errors| errors.to_string()), None, "{paper}");
    }
}

#[test]
fn a_c_library_that_differs_is_refused_with_both_declarations() {
    let scratch = Scratch::new();
    let path = in_c(&scratch, &[]);
    let differs = |from, to, expected| disagree(path.clone(), &altered(from, to), &expected);
    differs(
        "double velocity;   /* m/s */",
        "float velocity;",
        expect![[r#"
        demo.so: codel `demo_init` (demo.gen:52): argument 1 `ids`: `demo_ids.current`: `demo_state.velocity`: `float` is wanted, not `double`
          .gen:    genom_event demo_init(demo_ids *ids, const demo_position *position, const genom_context self)
          library: genom_event demo_init(demo_ids *ids, const demo_position *position, const genom_context self)
        demo.so: codel `demo_reset` (demo.gen:71): argument 1 `current`: `demo_state.velocity`: `float` is wanted, not `double`
          .gen:    genom_event demo_reset(demo_state *current, const genom_context self)
          library: genom_event demo_reset(demo_state *current, const genom_context self)"#]],
    );
    differs(
        "demo_reset(inout current)",
        "demo_reset(inout velocity)",
        expect![[r#"
        demo.so: codel `demo_reset` (demo.gen:71): argument 1 `velocity`: `double` is wanted, not `demo_state`
          .gen:    genom_event demo_reset(double *velocity, const genom_context self)
          library: genom_event demo_reset(demo_state *current, const genom_context self)"#]],
    );
    differs(
        "demo_check_goal(in goal)",
        "demo_check_goal(in goal, in velocity)",
        expect![[r#"
        demo.so: codel `demo_check_goal` (demo.gen:79): 3 arguments are wanted, the context included; it takes 2
          .gen:    genom_event demo_check_goal(double goal, double velocity, const genom_context self)
          library: genom_event demo_check_goal(double goal, const genom_context self)"#]],
    );
    differs(
        "typedef double gain;",
        "typedef float gain;",
        expect![[r#"
            demo.so: codel `demo_servo` (demo.gen:81): argument 5 `parameter`: its data: `float` is wanted, not `demo_gain`
              .gen:    genom_event demo_servo(double goal, double velocity, bool halted, demo_state *current, const demo_parameter *parameter, const demo_position *position, const genom_context self)
              library: genom_event demo_servo(double goal, double velocity, bool halted, demo_state *current, const demo_parameter *parameter, const demo_position *position, const genom_context self)"#]],
    );
    differs(
        "string<64> what;",
        "string<32> what;",
        expect![[r#"
        demo.so: exception `::demo::OUT_OF_RANGE` (demo.gen:7): `demo_OUT_OF_RANGE_detail.what`: an array [32] is wanted, not `char[64]`
          .gen:    { double value; double lower; double upper; char[32] what; }
          library: { double value; double lower; double upper; char[64] what; }"#]],
    );
    differs(
        "boolean halted;",
        "long halted;",
        expect![[r#"
            demo.so: codel `demo_init` (demo.gen:52): argument 1 `ids`: `demo_ids.halted`: `int32_t` is wanted, not `bool`
              .gen:    genom_event demo_init(demo_ids *ids, const demo_position *position, const genom_context self)
              library: genom_event demo_init(demo_ids *ids, const demo_position *position, const genom_context self)
            demo.so: codel `demo_begin` (demo.gen:80): argument 1 `halted`: `int32_t` is wanted, not `bool`
              .gen:    genom_event demo_begin(int32_t *halted, const genom_context self)
              library: genom_event demo_begin(bool *halted, const genom_context self)
            demo.so: codel `demo_servo` (demo.gen:81): argument 3 `halted`: `int32_t` is wanted, not `bool`
              .gen:    genom_event demo_servo(double goal, double velocity, int32_t halted, demo_state *current, const demo_parameter *parameter, const demo_position *position, const genom_context self)
              library: genom_event demo_servo(double goal, double velocity, bool halted, demo_state *current, const demo_parameter *parameter, const demo_position *position, const genom_context self)
            demo.so: codel `demo_halt` (demo.gen:84): argument 2 `halted`: `int32_t` is wanted, not `bool`
              .gen:    genom_event demo_halt(demo_state *current, int32_t *halted, const demo_position *position, const genom_context self)
              library: genom_event demo_halt(demo_state *current, bool *halted, const demo_position *position, const genom_context self)"#]],
    );
    let text = altered("port in gain parameter", "port out gain parameter").replacen(
        "in parameter, out position",
        "out parameter, out position",
        1,
    );
    disagree(
        path,
        &text,
        &expect![[r#"
            demo.so: codel `demo_servo` (demo.gen:81): argument 5 `parameter`: a handle with data, write is wanted, not one with data, read
              .gen:    genom_event demo_servo(double goal, double velocity, bool halted, demo_state *current, const demo_parameter *parameter, const demo_position *position, const genom_context self)
              library: genom_event demo_servo(double goal, double velocity, bool halted, demo_state *current, const demo_parameter *parameter, const demo_position *position, const genom_context self)"#]],
    );
}

#[test]
fn a_member_of_another_type_is_told_with_both_declarations() {
    let text = altered("double velocity;   /* m/s */", "float velocity;");
    disagree(
        in_rust(),
        &text,
        &expect![[r#"
        demo.so: codel `demo_init` (demo.gen:52): argument 1 `ids`: ::demo::ids::current: ::demo::state::velocity: float is wanted, not double
          .gen:    genom_event demo_init(demo_ids *ids, const demo_position *position, const genom_context self)
          library: fn demo_init(ids: &mut ::demo::ids, position: &mut OutPort<::demo::state>)"#]],
    );
}

#[test]
fn an_argument_more_or_another_direction_is_told() {
    let text = altered("demo_reset(inout current)", "demo_reset(in current)");
    disagree(
        in_rust(),
        &text,
        &expect![[r#"
        demo.so: codel `demo_reset` (demo.gen:71): argument 1 `current`: `&T` is wanted, not `&mut T`
          .gen:    genom_event demo_reset(const demo_state *current, const genom_context self)
          library: fn demo_reset(current: &mut ::demo::state)"#]],
    );
    let text = altered("demo_check_goal(in goal)", "demo_check_goal(in goal, in velocity)");
    disagree(
        in_rust(),
        &text,
        &expect![[r#"
        demo.so: codel `demo_check_goal` (demo.gen:79): 2 arguments before the context are wanted, it takes 1
          .gen:    genom_event demo_check_goal(double goal, double velocity, const genom_context self)
          library: fn demo_check_goal(goal: double)"#]],
    );
}

#[test]
fn a_port_of_another_direction_and_an_exception_of_another_shape_are_told() {
    let text = altered("port in gain parameter", "port out gain parameter").replacen(
        "in parameter, out position",
        "out parameter, out position",
        1,
    );
    disagree(
        in_rust(),
        &text,
        &expect![[r#"
        demo.so: codel `demo_servo` (demo.gen:81): argument 5 `parameter`: `OutPort` is wanted, not `InPort`
          .gen:    genom_event demo_servo(double goal, double velocity, bool halted, demo_state *current, const demo_parameter *parameter, const demo_position *position, const genom_context self)
          library: fn demo_servo(goal: double, velocity: double, halted: boolean, current: &mut ::demo::state, parameter: &mut InPort<double>, position: &mut OutPort<::demo::state>)"#]],
    );
    let text = altered("string<64> what;", "string<32> what;");
    disagree(
        in_rust(),
        &text,
        &expect![[r#"
        demo.so: exception ::demo::OUT_OF_RANGE (demo.gen:7): ::demo::OUT_OF_RANGE::what: string<32>: bound or length 32 is wanted, not 64
          .gen:    ::demo::OUT_OF_RANGE
          library: ::demo::OUT_OF_RANGE"#]],
    );
}

/// The report of `check` for the demo in C, built with these options, and a description that
/// differs in one type.
fn checked(options: &[&str]) -> genom_host::contract::Report {
    let scratch = Scratch::new();
    let path = in_c(&scratch, options);
    let text = altered("demo_reset(inout current)", "demo_reset(inout velocity)");
    check(&Library::open(&path).expect("a library"), &plan(&text).0, &|_| String::new())
}

#[test]
fn compressed_debug_information_is_read() {
    for options in [["-gdwarf-5", "-gz=zlib"], ["-gdwarf-4", "-gz=zlib"]] {
        let report = checked(&options);
        assert_eq!((report.checked, report.codels), (Checked::DebugInformation, 8), "{options:?}");
        assert_eq!((report.differences.len(), report.unchecked), (1, None), "{options:?}");
    }
}

#[test]
fn debug_information_that_lies_elsewhere_is_no_check_and_says_so() {
    let unchecked = |report: genom_host::contract::Report| {
        assert_eq!((report.checked, report.codels), (Checked::Unchecked, 0));
        report.unchecked.unwrap_or_default()
    };
    let split = "types are in .dwo files, which do not go with the library (build it without \
                 -gsplit-dwarf)";
    assert_eq!(unchecked(checked(&["-gdwarf-5", "-gsplit-dwarf"])), split);
    assert_eq!(unchecked(checked(&["-gdwarf-4", "-gsplit-dwarf"])), split);
    let none = "the library tells no types (build it with -g)";
    assert_eq!(unchecked(checked(&["-g0"])), none);
}

#[test]
fn codels_compiled_without_debug_information_are_named() {
    let scratch = Scratch::new();
    let c = |name: &str| {
        format!(
            "#include <genom3/c/exception.h>\n\
             genom_event {name}(double x, const genom_context self) {{ return genom_ok; }}"
        )
    };
    let bare = scratch.cc("bare.o", &c("b_run"), &["-c", "-fPIC", "-g0"]);
    let bare = bare.to_str().unwrap();
    let path = scratch.cc("demo.so", &c("a_run"), &["-shared", "-fPIC", bare]);
    let text = "component demo { task t; function a(in double x) { codel a_run(in x); }; \
                function b(in double x) { codel b_run(in x); }; };";
    let report = check(&Library::open(&path).unwrap(), &plan(text).0, &|_| String::new());
    assert_eq!((report.checked, report.codels), (Checked::DebugInformation, 1));
    let why = "codels `b_run`: the library tells no types of them (build all of it with -g)";
    assert_eq!(report.unchecked.as_deref(), Some(why));
}

#[test]
fn a_codel_of_c_linkage_in_cpp_is_compared_as_one_of_c() {
    let scratch = Scratch::new();
    let source = "#include <string>
        #include <genom3/c/exception.h>
        struct demo_s { int32_t a; char *b; };
        extern \"C\" genom_event f_run(const demo_s *x, double *y, const genom_context) {
          *y = std::string(x->b).size() + x->a;
          return genom_ok;
        }";
    let path = scratch.cxx("demo.so", source, &["-shared", "-fPIC"]);
    let text = |member: &str| {
        format!(
            "component demo {{\n struct s {{ long a; {member} b; }};\n task t;\n \
             function f(in s x, out double y) {{\n  codel f_run(in x, out y);\n }};\n}};"
        )
    };
    disagree(path.clone(), &text("string"), &expect!["loads"]);
    disagree(
        path,
        &text("long"),
        &expect![[r#"
        demo.so: codel `f_run` (demo.gen:5): argument 1 `x`: `demo_s.b`: `int32_t` is wanted, not `char *`
          .gen:    genom_event f_run(const demo_s *x, double *y, const genom_context self)
          library: genom_event f_run(const struct demo_s *x, double *y, const genom_context )"#]],
    );
}
