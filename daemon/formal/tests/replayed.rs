//! Runs to overruns are played on the real runtime, with codels that take and yield what the run
//! says: the same task is late, at the same date.

#![allow(clippy::unwrap_used, clippy::panic)]

use std::collections::HashMap;
use std::sync::Arc;

use genom_description::{Options, read_text};
use genom_formal::{Bounds, Duration, Event, Happening, Limits, System, TaskReport, Times};
use genom_runtime::Plan;
use genom_stage::{Component, Move, NotPlayed, Script, Step, play};

#[path = "conformance/components.rs"]
mod components;
#[path = "conformance/random.rs"]
mod random;

const MS: u64 = 1_000_000;

/// Two tasks and one exclusion: `fast` waits for `slow` at times.
const DUO: &str = "component duo { ids { long shared; };
  task fast { period 10 ms; codel<start> fa(inout shared) yield pause::start wcet 3 ms; };
  task slow { period 40 ms; codel<start> sb(inout shared) yield work wcet 8 ms;
    codel<work> sw() yield pause::start wcet 20 ms; }; };";

fn system(text: &str, bounds: Bounds) -> System {
    let analysis = read_text("c.gen", text, &Options::default());
    assert!(!analysis.has_errors(), "{text}\n{:#?}", analysis.diagnostics);
    System::new(&Arc::new(Plan::new(&Arc::new(analysis.specification), 0).unwrap()), bounds)
}

fn bounds() -> Bounds {
    Bounds { kill: false, ..Bounds::default() }
}

/// However slow the machine is.
fn limits(states: usize) -> Limits {
    Limits { states, time: std::time::Duration::MAX, ..Limits::default() }
}

fn script(happenings: &[Happening]) -> Script {
    let step = |one: &Happening| {
        let what = match &one.event {
            Event::Pass(task) => Move::Pass(task.clone()),
            Event::Returns(call, yields) => Move::Returns {
                codel: call.codel.clone(),
                task: call.task.clone(),
                yields: yields.clone(),
            },
            Event::Request(service) => Move::Request(service.clone()),
            Event::Abort(activity) => Move::Abort(*activity),
            Event::Fire(event) => Move::Fire(event.clone()),
            Event::Control => Move::Control,
            Event::Late(task) => Move::Late(task.clone()),
            _ => return None,
        };
        Some(Step { at: one.date, what })
    };
    Script { steps: happenings.iter().filter_map(step).collect() }
}

/// Plays the run in which a task is late.
fn replay(
    system: &System,
    times: &Times,
    task: &TaskReport,
) -> Result<Script, (Script, NotPlayed)> {
    let script = script(&system.happenings(times, &task.course));
    let slots = Bounds::default().slots;
    let component = Component { plan: Arc::clone(system.plan()), tasks: HashMap::new(), slots };
    match play(&component, &script) {
        Ok(_) => Ok(script),
        Err(error) => Err((script, error)),
    }
}

fn duo() -> (System, Times) {
    let system = system(DUO, bounds());
    let mut times = system.declared_times();
    for (codel, most) in [("fa", 3), ("sb", 8), ("sw", 20)] {
        let duration = Duration { least: MS, most: Some(most * MS) };
        assert!(times.set(system.plan().component(), codel, duration));
    }
    (system, times)
}

#[test]
fn the_overrun_of_two_tasks_is_one_of_the_runtime_at_the_same_date() {
    let (system, times) = duo();
    let report = system.check_times(&times, &limits(10_000));
    let script = replay(&system, &times, &report.tasks[0]).unwrap();
    let last = script.steps.last().unwrap();
    assert_eq!((last.at, &last.what), (50 * MS, &Move::Late("fast".to_owned())));
}

#[test]
fn a_script_that_asks_for_what_the_runtime_does_not_do_is_refused() {
    let (system, times) = duo();
    let report = system.check_times(&times, &limits(10_000));
    let happenings = system.happenings(&times, &report.tasks[0].course);
    let slots = Bounds::default().slots;
    let component = Component { plan: Arc::clone(system.plan()), tasks: HashMap::new(), slots };
    let good = script(&happenings);
    let steps = good.steps.len();
    // A pass before its tick; an overrun that does not come; a codel that nobody executes.
    let early = |at: usize| {
        let mut script = good.clone();
        script.steps.truncate(at);
        script
    };
    let mut overrun = early(steps);
    overrun.steps.last_mut().unwrap().at -= 1;
    let mut idle = early(steps - 1);
    idle.steps.push(Step { at: 50 * MS, what: Move::Late("slow".to_owned()) });
    let mut pass = early(4);
    pass.steps.push(Step { at: pass.steps[3].at, what: Move::Pass("fast".to_owned()) });
    let mut codel = early(steps - 1);
    let yields = "pause::start".to_owned();
    let what = Move::Returns { codel: "sb".to_owned(), task: Some("slow".to_owned()), yields };
    codel.steps.push(Step { at: 49 * MS, what });
    for script in [overrun, idle, pass, codel] {
        let error = play(&component, &script).unwrap_err();
        assert!(error.is_elsewhere(), "{error}");
        assert_eq!(error.step(), Some(script.steps.len() - 1), "{error}");
    }
}

#[test]
fn overruns_of_random_components_are_overruns_of_the_runtime() {
    let (mut replayed, mut wrong) = (0, Vec::new());
    for seed in 0..400 {
        let mut random = random::Random(seed);
        let text = components::component(&mut random);
        let bounds = Bounds { instances: 1, ..bounds() };
        let system = system(&text, bounds);
        let mut times = system.declared_times();
        let component = system.plan().component();
        let names: Vec<String> = component.codels.iter().map(|one| one.name.clone()).collect();
        for name in names {
            let least = u64::try_from(random.below(3)).unwrap() * MS / 4;
            let most = least + u64::try_from(random.below(8)).unwrap() * MS / 2;
            times.set(component, &name, Duration { least, most: Some(most) });
        }
        // As `genomctl verify` does: of tasks apart the run of all tasks is played.
        let report = system.check_ticks(&times, &limits(2000));
        for task in report.tasks.iter().filter(|task| !task.course.is_empty()) {
            replayed += 1;
            if let Err((script, error)) = replay(&system, &times, task) {
                let steps =
                    script.steps.iter().map(|step| format!("{} {:?}\n", step.at, step.what));
                wrong.push(format!("seed {seed}: {error}\n{text}\n{}", steps.collect::<String>()));
            }
        }
    }
    assert!(wrong.is_empty(), "{} of {replayed}:\n{}", wrong.len(), wrong.join("\n"));
    assert!(replayed > 100, "{replayed}");
}
