//! Calls one codel in three ways, in the same run: directly, through libffi, and as the runtime
//! dispatches it (exclusion entered and left, arguments bound, event identified, transition looked
//! up). Prints the median of each and the overhead over a direct call; and the dispatch of the same
//! codel in a C++ component.

#![allow(missing_docs, unsafe_code, clippy::unwrap_used, clippy::print_stdout)]

#[path = "../tests/support/mod.rs"]
mod support;

use std::ffi::{c_char, c_void};
use std::hint::black_box;
use std::process::Command;
use std::sync::Arc;
use std::time::Instant;

use genom_description::model::{CodelIx, Owner};
use genom_host::{Component, Library};
use genom_runtime::Plan;
use genom_runtime::body::{Body, Frame, Returned};
use genom_runtime::exclusion::Exclusion;
use genom_types::Record;
use libffi::middle::{Arg, Cif, CodePtr, Type};
use serde_json::json;

const GEN: &str = "component demo {
    struct state { double position; double velocity; };
    ids { double velocity; state current; boolean halted; };
    typedef double gain;
    port in gain parameter;
    port out state position;
    task main { period 5 ms; };
    attribute set_speed(in velocity);
    activity goto(in double goal) {
        task main;
        codel<start> servo(in goal, in velocity, in halted, inout current, in parameter,
                           out position) yield pause::start, ether;
    };
};";

const C: &str = r#"
#include <stdbool.h>
const char demo_pause_start[] = "::demo::pause::start", demo_ether[] = "::demo::ether";
typedef struct { double position, velocity; } demo_state;
const char *servo(double goal, double velocity, bool halted, demo_state *current,
                  const void *parameter, const void *position, const void *self)
{
  if (halted) return demo_ether;
  current->velocity = velocity;
  current->position += (goal - current->position) * 1e-3;
  return demo_pause_start;
}
"#;

const CXX: &str = "
genom::event servo(double goal, double velocity, bool halted, demo::state &current,
                   demo::parameter &, demo::position &)
{
  if (halted) return demo::ether;
  current.velocity = velocity;
  current.position += (goal - current.position) * 1e-3;
  return demo::pause::start;
}
";

type Servo = unsafe extern "C" fn(
    f64,
    f64,
    bool,
    *mut [f64; 2],
    *const c_void,
    *const c_void,
    *const c_void,
) -> *const c_char;

const CALLS: u32 = 100_000;
const ROUNDS: usize = 41;

/// Nanoseconds per call, over many calls.
fn time(mut call: impl FnMut()) -> f64 {
    let start = Instant::now();
    for _ in 0..CALLS {
        call();
    }
    start.elapsed().as_secs_f64() * 1e9 / f64::from(CALLS)
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

/// Runs a codel as a task does, without reading the clock.
fn dispatch(plan: &Plan, exclusion: &Exclusion, frame: &mut dyn Frame, codel: CodelIx) {
    let permit = exclusion.enter(0, plan.nodes().codel(codel));
    let returned = frame.call(codel, 0);
    drop(permit);
    let Returned::Event(event) = returned else { return };
    black_box(plan.transitions(codel).get(usize::from(event.0)));
}

fn main() {
    let directory = tempfile::tempdir().unwrap();
    let (source, path) = (directory.path().join("demo.c"), directory.path().join("demo.so"));
    std::fs::write(&source, C).unwrap();
    let mut cc = Command::new("cc");
    cc.args(["-O2", "-shared", "-fPIC", "-o"]).arg(&path).arg(&source);
    assert!(cc.status().unwrap().success());

    let analysis = genom_description::read_text("demo.gen", GEN, &Default::default());
    assert!(!analysis.has_errors(), "{:?}", analysis.diagnostics);
    let plan = Plan::new(&Arc::new(analysis.specification), 0).unwrap();
    let library = Library::open(&path).unwrap();
    let component = Component::load(library, &plan, &|_| String::new()).unwrap();
    let goto = plan.service("goto").unwrap();
    let codel = plan.component().services[goto].codels[0];
    let mut frame = component.frame(Owner::Service(goto));
    frame.begin(&Record::new(&plan.services()[goto].input));
    let exclusion = Exclusion::new(plan.nodes(), plan.contexts());

    // SAFETY: compiled above, with this prototype.
    let direct = unsafe { libloading::Library::new(&path) }.unwrap();
    // SAFETY: as above.
    let servo: Servo = unsafe { *direct.get::<Servo>("servo").unwrap() };
    let mut state = [0.0; 2];
    let nothing: *const c_void = std::ptr::null();
    let address = state.as_mut_ptr();
    let values = (1.0_f64, 0.5_f64, 0_u8, address, nothing);
    let types = [Type::f64(), Type::f64(), Type::u8()].into_iter();
    let pointers = (0..4).map(|_| Type::pointer());
    let cif = Cif::new(types.chain(pointers).collect::<Vec<_>>(), Type::pointer());
    let arguments = [
        Arg::new(&values.0),
        Arg::new(&values.1),
        Arg::new(&values.2),
        Arg::new(&values.3),
        Arg::new(&values.4),
        Arg::new(&values.4),
        Arg::new(&values.4),
    ];

    let text = GEN.replacen('{', "{ lang \"c++\";", 1);
    let cpp = support::cxx::load(&support::cxx::compile(&text, CXX, &["-O2"]), &text);
    let mut cpp_frame = cpp.begin("goto", json!({ "goal": 1.0 }));
    let cpp_codel = cpp.plan.component().services[goto].codels[0];
    let cpp_exclusion = Exclusion::new(cpp.plan.nodes(), cpp.plan.contexts());
    assert!(matches!(cpp_frame.call(cpp_codel, 0), Returned::Event(_)));

    let mut rounds: [Vec<f64>; 5] = Default::default();
    for _ in 0..ROUNDS {
        rounds[0].push(time(|| {
            let servo = black_box(servo);
            // SAFETY: the arguments match the prototype, and point to data that lives.
            black_box(unsafe { servo(1.0, 0.5, false, address.cast(), nothing, nothing, nothing) });
        }));
        rounds[1].push(time(|| {
            let function = CodePtr::from_ptr(black_box(servo) as *const c_void);
            // SAFETY: as above; the interface is that of the prototype.
            black_box(unsafe { cif.call::<*const c_char>(function, &arguments) });
        }));
        rounds[2].push(time(|| {
            black_box(frame.call(codel, 0));
        }));
        rounds[3].push(time(|| dispatch(&plan, &exclusion, &mut *frame, codel)));
        rounds[4].push(time(|| dispatch(&cpp.plan, &cpp_exclusion, &mut *cpp_frame, cpp_codel)));
    }
    let names = ["direct C call", "libffi call", "codel call", "codel dispatch", "in C++"];
    let medians = rounds.map(median);
    for (name, ns) in names.iter().zip(medians) {
        println!("{name:16} {ns:6.1} ns  {:6.1} ns above direct", ns - medians[0]);
    }
    println!("dispatch / libffi {:.2}", medians[3] / medians[1]);
}
