//! Events and exceptions: what codels return, raise, and let escape (genom3.md 5.3, 5.4).

mod support;

use expect_test::expect;
use genom_description::model::Direction::{In, Out};
use genom_description::model::{CodelIx, Ix as _, Owner, ServiceIx, ServiceKind, TaskIx};
use genom_runtime::body::{Body, Returned};
use genom_types::Kind;
use serde_json::json;
use support::generator::Gen;
use support::load::{load, try_load, try_load_with};

/// What the generated header of component `demo` declares.
const HEADER: &str = r#"
    #include <stdint.h>
    #include <stdlib.h>
    #include <string.h>
    #include <genom3/c/event.h>
    #include <genom3/c/context.h>
    #include <genom3/c/exception.h>
    GENOM_EVENT(demo_ether, "::demo::ether");
    GENOM_EVENT(demo_start, "::demo::start");
    GENOM_EVENT(demo_pause_start, "::demo::pause::start");
    GENOM_EVENT(demo_e_sys_id, "::demo::e_sys");
    typedef struct demo_e_sys_detail { int16_t code; char what[128]; } demo_e_sys_detail;
    static inline genom_event demo_e_sys(const demo_e_sys_detail *d, genom_context self)
    { return self->raise(demo_e_sys_id, d, sizeof *d, self); }
    GENOM_EVENT(demo_e_void_id, "::demo::e_void");
    static inline genom_event demo_e_void(genom_context self)
    { return self->raise(demo_e_void_id, NULL, 0, self); }
"#;

/// Function `f(in long x)` of a component with two exceptions.
fn one_function() -> (Gen, ServiceIx, CodelIx) {
    let mut gen_ = Gen::new();
    let (short, long) = (gen_.ty(Kind::Short), gen_.ty(Kind::Long));
    let what = gen_.string(Some(128));
    gen_.exception("e_sys", &[("code", short), ("what", what)]);
    gen_.exception("e_void", &[]);
    let (service, codel) = gen_.function("f", &[(In, "x", long)]);
    (gen_, service, codel)
}

#[test]
fn events_are_known_by_content_whatever_the_pointer() {
    let (gen_, service, codel) = one_function();
    let c = format!(
        "{HEADER}
        static char changing[64];
        genom_event f(int32_t x, const genom_context self) {{
          switch (x) {{
            case 0: return genom_ok;
            case 1: return demo_ether;
            case 2: return demo_pause_start;
            case 3: return \"::demo::start\";
            case 4: return strcpy(changing, \"::demo::ether\");
            case 5: return strcpy(changing, \"::demo::start\");
            default: return \"::other::state\";
          }}
        }}"
    );
    let loaded = load(gen_, &c);
    let names = ["", "::demo::ether", "::demo::pause::start", "::demo::start", "::demo::ether"];
    let names = names.into_iter().chain(["::demo::start", "::other::state"]);
    for (x, name) in names.enumerate() {
        let mut frame = loaded.begin(service, json!({ "x": x }));
        for _ in 0..3 {
            assert_eq!(loaded.call(&mut *frame, codel), name);
            assert_eq!(frame.detail(), None);
        }
    }
    let mut frame = loaded.begin(service, json!({ "x": 4 }));
    assert_eq!(loaded.call(&mut *frame, codel), "::demo::ether");
    let ty = loaded.specification.components[0].services[service].input;
    frame.begin(&support::generator::record(&loaded.specification, ty, json!({ "x": 5 })));
    assert_eq!(
        loaded.call(&mut *frame, codel),
        "::demo::start",
        "a buffer that the codel writes again is read again"
    );
}

#[test]
fn an_exception_carries_a_copy_of_its_detail() {
    let (gen_, service, codel) = one_function();
    let c = format!(
        "{HEADER}
        genom_event f(int32_t x, const genom_context self) {{
          genom_event last;
          switch (x) {{
            case 0: {{
              demo_e_sys_detail d = {{ -3, \"negative\" }};
              genom_event e = demo_e_sys(&d, self);
              memset(&d, 0xff, sizeof d);
              return e;
            }}
            case 1: return demo_e_void(self);
            case 2: return demo_e_sys_id;
            case 3: return genom_syserr(&(genom_syserr_detail){{ .code = 5 }}, self);
            case 4: return genom_unkex(&(genom_unkex_detail){{ .what = \"odd\" }}, self);
            case 5: return self->raise(demo_e_sys_id, malloc(1 << 20), 1 << 20, self);
            default: {{
              demo_e_sys_detail d = {{ 7, \"seven\" }};
              demo_e_sys(&d, self);
              const demo_e_sys_detail *r = self->raised(&last, self);
              return last == demo_e_sys_id && r->code == 7 ? demo_ether : demo_start;
            }}
          }}
        }}"
    );
    let loaded = load(gen_, &c);
    let run = |x: i32| {
        let mut frame = loaded.begin(service, json!({ "x": x }));
        let event = loaded.call(&mut *frame, codel);
        (event, frame.detail())
    };
    let sys = |detail| ("::demo::e_sys".to_owned(), detail);
    assert_eq!(run(0), sys(Some(json!({ "code": -3, "what": "negative" }))));
    assert_eq!(run(1), ("::demo::e_void".into(), None));
    assert_eq!(run(2), sys(None), "not raised by this codel");
    assert_eq!(run(3), ("::genom::syserr".into(), Some(json!({ "code": 5 }))));
    assert_eq!(run(4), ("::genom::unkex".into(), Some(json!({ "what": "odd" }))));
    assert_eq!(run(5), ("::genom::fatal".into(), None), "larger than any detail");
    assert_eq!(run(6), ("::demo::ether".into(), None), "raised shows what was raised");
}

#[test]
fn a_cpp_exception_that_escapes_becomes_unkex_with_what_it_says() {
    let (gen_, service, codel) = one_function();
    let cpp = r#"
        #include <cstdint>
        #include <stdexcept>
        #include <genom3/c/context.h>
        struct Own { int x; };
        struct Counted { static int alive; Counted() { alive++; } ~Counted() { alive--; } };
        int Counted::alive = 0;
        extern "C" genom_event f(int32_t x, const genom_context self) {
          if (Counted::alive) return "::demo::leak";
          Counted counted;
          switch (x) {
            case 0: throw std::runtime_error("the arm is gone");
            case 1: throw "a text";
            case 2: throw Own();
            case 3: throw std::runtime_error(std::string(1000, 'x'));
            default: return nullptr;
          }
        }"#;
    let compile = |scratch: &support::Scratch| scratch.cxx("demo.so", cpp, &["-shared", "-fPIC"]);
    let loaded = try_load_with(gen_, compile).unwrap();
    let xs = "x".repeat(127);
    for (x, what) in
        [(0, "the arm is gone"), (1, "a text"), (2, "C++ exception of type Own"), (3, &xs)]
    {
        let mut frame = loaded.begin(service, json!({ "x": x }));
        assert_eq!(loaded.call(&mut *frame, codel), "::genom::unkex");
        assert_eq!(frame.detail(), Some(json!({ "what": what })));
    }
    let mut frame = loaded.begin(service, json!({ "x": 9 }));
    assert_eq!(loaded.call(&mut *frame, codel), "", "destructors ran and the library goes on");
}

#[test]
fn each_task_has_a_context_and_validate_and_functions_have_the_control_tasks() {
    let mut gen_ = Gen::new();
    let long = gen_.ty(Kind::UnsignedLongLong);
    let (function, one) = gen_.function("context_of", &[(Out, "y", long)]);
    let activity = gen_.service(ServiceKind::Activity, "a", &[(Out, "y", long)], &[]);
    let source = genom_description::model::Source::Parameter { index: 0, path: vec![] };
    let two = gen_.codel(Owner::Service(activity), "context_of", &[(Out, "y", long, source)]);
    let permanent = gen_.codel(Owner::Task(TaskIx::new(0)), "start", &[]);
    let c = "#include <stdint.h>\n#include <genom3/c/context.h>
        static genom_context seen;
        genom_event context_of(uint64_t *y, const genom_context self)
        { *y = (uint64_t)self; return seen && seen == self ? \"::demo::stop\" : 0; }
        genom_event start(const genom_context self) { seen = self; return \"::demo::ether\"; }";
    let loaded = load(gen_, c);
    let mut task = loaded.component.frame(Owner::Task(TaskIx::new(0)));
    assert_eq!(loaded.call(&mut *task, permanent), "::demo::ether");
    assert_eq!(task.output().ty().size(), 0);
    let (event, in_control) = loaded.run(function, one, json!({}));
    assert_eq!(event, "");
    let (event, in_task) = loaded.run(activity, two, json!({}));
    assert_eq!(event, "::demo::stop", "the same context as the task's own activity");
    assert_ne!(in_control, in_task);
}

#[test]
fn a_frame_runs_the_codels_of_its_owner_only() {
    let mut gen_ = Gen::new();
    let (service, own) = gen_.function("f", &[]);
    let (_, other) = gen_.function("g", &[]);
    let c = "const char *f(void *self) { return 0; } const char *g(void *self) { return 0; }";
    let loaded = load(gen_, c);
    let mut frame = loaded.begin(service, json!({}));
    assert_eq!(frame.call(other, 1), Returned::Failed);
    assert_eq!(frame.detail(), Some(json!({ "what": "codel 1 is none of this service" })));
    assert_eq!(frame.call(CodelIx::new(usize::MAX), 1), Returned::Failed);
    assert_eq!(frame.call(own, usize::MAX), Returned::Failed, "no such context");
}

#[test]
fn all_missing_codels_are_told_at_once_with_file_and_place() {
    let mut gen_ = Gen::new();
    let long = gen_.ty(Kind::Long);
    gen_.function("there", &[(In, "x", long)]);
    gen_.function("gone", &[(In, "x", long)]);
    gen_.function("mangled", &[(In, "x", long)]);
    gen_.function("kill", &[]);
    let cpp = "extern \"C\" const char *there(int, const void *) { return 0; }
        const char *mangled(int, const void *) { return 0; }";
    let compile = |scratch: &support::Scratch| {
        scratch.cxx("demo.so", cpp, &["-shared", "-fPIC", "-Wl,--no-as-needed"])
    };
    let errors = try_load_with(gen_, compile).err().unwrap();
    let directory = errors.library.parent().unwrap().display().to_string();
    expect![[r#"
        demo.so: codel `gone` (demo.gen:2) is not defined
        demo.so: codel `mangled` (demo.gen:3) is not defined; it has the C++ function `_Z7manglediPKv`: declare it extern "C", or include the component's header
        demo.so: codel `kill` (demo.gen:4) is not defined; libc.so.6 has a function of that name, which is no codel"#]]
    .assert_eq(&errors.to_string().replace(&format!("{directory}/"), ""));
}

#[test]
fn a_component_in_another_language_is_refused() {
    let (gen_, ..) = one_function();
    let errors = try_load(gen_.lang("ada"), "int x;").err().unwrap();
    let text = errors.to_string();
    assert!(
        text.contains("component `demo` (demo.gen:1) has lang \"ada\": codels are called by the C")
    );
}

#[test]
fn a_type_without_place_in_memory_names_who_has_it() {
    let mut gen_ = Gen::new();
    let any = gen_.ty(Kind::Any);
    gen_.ids(&[("x", any)]);
    let errors = try_load(gen_, "int x;").err().unwrap().to_string();
    assert!(errors.contains("the ids (demo.gen:1): "), "{errors}");
}

#[test]
fn a_component_loads_and_unloads_200_times() {
    for round in 0..200 {
        let (gen_, service, codel) = one_function();
        // Compiled once in the first round; each load makes a copy with its own static variables.
        let c = "#include <stdint.h>\n#include <genom3/c/context.h>
            static int calls;
            __attribute__((constructor)) static void made(void) { calls = 10; }
            genom_event f(int32_t x, const genom_context self)
            { return ++calls == 11 ? \"::demo::start\" : \"::demo::stop\"; }";
        let path = COMPILED.get_or_init(|| {
            let scratch = support::Scratch::new();
            let path = scratch.library("demo.so", c);
            (scratch, path)
        });
        let loaded = try_load_with(gen_, |_| path.1.clone()).unwrap();
        let (event, _) = loaded.run(service, codel, json!({ "x": 0 }));
        assert_eq!(event, "::demo::start", "round {round}: a fresh copy");
    }
    let maps = std::fs::read_to_string("/proc/self/maps").unwrap();
    let left = maps.lines().filter(|line| line.contains("genomd-library-")).count();
    // Other tests of this program load libraries meanwhile; 200 leaked ones would be 1000 lines.
    assert!(left < 200, "{left} mappings left");
}

static COMPILED: std::sync::OnceLock<(support::Scratch, std::path::PathBuf)> =
    std::sync::OnceLock::new();
