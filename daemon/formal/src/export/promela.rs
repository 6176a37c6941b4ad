//! Promela: tables of the component, then the rules, which are the same for all.

use std::fmt::Write as _;

use genom_description::model::{CodelIx, Ix as _};
use genom_runtime::plan::Builtin;

use super::error::ExportError;
use super::unit::unit;
use crate::action::Answer;
use crate::services::Work;
use crate::system::System;
use crate::timed::Times;

/// The rules in Promela.
const RULES: &str = include_str!("rules.pml");
/// What a byte counts, less the numbers with a meaning of their own.
const MOST: usize = 250;

/// Numbers of what the tables are about.
struct Sizes {
    tasks: usize,
    states: usize,
    runs: usize,
    places: usize,
    pending: usize,
}

pub(super) fn promela(system: &System, times: Option<&Times>) -> Result<String, ExportError> {
    let sizes = sizes(system)?;
    let mut text = head(system, times.is_some());
    defines(&mut text, system, &sizes);
    machines(&mut text, system);
    services(&mut text, system);
    codels(&mut text, system);
    if let Some(times) = times {
        clocks(&mut text, system, times);
    }
    text.push_str(RULES);
    properties(&mut text, system);
    processes(&mut text, system, &sizes, times.is_some());
    Ok(text)
}

/// Activities that a task has at the same time, at most: its permanent one, and a place to move others
/// over.
pub(super) fn runs_of_task(system: &System, task: usize) -> usize {
    let machines = system.machines.iter();
    let own = machines.filter(|m| usize::from(m.task) == task && m.service.is_some());
    own.count() * system.bounds.instances + 2
}

fn sizes(system: &System) -> Result<Sizes, ExportError> {
    let tasks = system.periods.len();
    let activities = system.services.iter().filter(|service| service.machine.is_some()).count();
    // With events several states of an activity may be active.
    let several = system.bounds.fire && !system.sinks.is_empty();
    let states = |machine: &crate::machines::Machine| machine.codels.iter().flatten().count();
    let places = system.machines.iter().map(states).max().unwrap_or(0);
    let sizes = Sizes {
        tasks,
        states: system.plan.component().states.len().max(1),
        runs: (0..tasks).map(|task| runs_of_task(system, task)).max().unwrap_or(2),
        places: if several { places.max(1) + 1 } else { 1 },
        pending: (activities * system.bounds.instances).max(1),
    };
    let limits = [
        ("tasks and services", tasks + system.services.len(), MOST),
        ("codels and services", system.plan.nodes().len(), MOST),
        ("states", sizes.states, MOST),
        ("activities at the same time", sizes.pending, MOST),
        ("external events", system.sinks.len(), 31),
    ];
    match limits.into_iter().find(|(_, count, most)| count > most) {
        Some((what, count, most)) => {
            Err(ExportError::TooMany { what, count, most, format: "promela" })
        }
        None => Ok(sizes),
    }
}

fn head(system: &System, timed: bool) -> String {
    let name = &system.plan.component().name;
    let mut text = format!(
        "/* Component {name}: what it can do, whatever its codels yield and its clients ask.\n   \
         Checked by Spin (spinroot.com); save this as {name}.pml:\n\n"
    );
    let one = |text: &mut String, options: &str, claim: &str, what: &str| {
        let _ = writeln!(
            text,
            "     spin {options}-a {name}.pml && cc -O2 -DSAFETY{} -o pan pan.c && ./pan -m1000000{}\n         \
             {what}",
            if claim.is_empty() { " -DNOCLAIM" } else { "" },
            if claim.is_empty() { String::new() } else { format!(" -N {claim}") },
        );
    };
    one(
        &mut text,
        "",
        "",
        "errors: 0 if there always is a next step, and what excludes each other is never at work",
    );
    one(&mut text, "", "start", "errors: 1 if the start-up comes to its end");
    one(&mut text, "", "never_CODEL", "errors: 1 if this codel can run; never_ok_SERVICE likewise");
    if timed {
        one(&mut text, "-DTIME ", "in_time_TASK", "errors: 0 if this task is never late");
    }
    text.push_str("     spin -t -p FILE.pml shows the run of an error. */\n\n");
    text
}

fn defines(text: &mut String, system: &System, sizes: &Sizes) {
    let bounds = &system.bounds;
    let (services, nodes) = (system.services.len().max(1), system.plan.nodes().len().max(1));
    let builtin = |wanted: Builtin| {
        system.services.iter().position(|service| service.builtin == Some(wanted)).unwrap_or(0)
    };
    let first = if sizes.tasks == 0 { "RUNNING" } else { "STARTING" };
    let (start, stop) = system.machines.first().map_or((0, 0), |m| (m.start, m.stop));
    let aperiodic = system.periods.iter().filter(|period| period.is_none()).count();
    let requests = bounds.requests.min(services);
    let slots = bounds.slots.min(MOST);
    let all: &[(&str, usize)] = &[
        ("TASK_COUNT", sizes.tasks),
        ("TASKS", sizes.tasks.max(1)),
        ("SERVICES", services),
        ("CONTEXTS", sizes.tasks + services),
        ("NODES", nodes),
        ("STATES", sizes.states),
        ("SINKS", system.sinks.len()),
        ("RUNS", sizes.runs),
        ("PLACES", sizes.places),
        ("PENDING", sizes.pending),
        ("APERIODIC", aperiodic),
        ("INSTANCES", bounds.instances),
        ("REQUESTS", requests),
        ("SLOTS", slots),
        ("KILL", usize::from(bounds.kill)),
        ("BY_PERIOD", usize::from(system.by_period)),
        ("START_STATE", usize::from(start)),
        ("STOP_STATE", usize::from(stop)),
        ("ABORTS", builtin(Builtin::AbortActivity)),
    ];
    for (name, value) in all {
        let _ = writeln!(text, "#define {name} {value}");
    }
    let _ = writeln!(text, "#define FIRST_PHASE {first}");
    let contexts = sizes.tasks + services;
    let pairs = (0..contexts).flat_map(|a| (a + 1..contexts).map(move |b| (a, b)));
    let together = |(a, b): (usize, usize)| {
        format!("(held[{a}] && held[{b}] && CONFLICT[(held[{a}] - 1) * NODES + held[{b}] - 1])")
    };
    let together: Vec<String> = pairs.map(together).collect();
    let together = if together.is_empty() { "false".into() } else { together.join(" ||\\\n  ") };
    let _ = writeln!(text, "#define TOGETHER ({together})");
    let ended: Vec<String> = (0..sizes.tasks).map(|t| format!("(T[{t}].no > 0)")).collect();
    let ended = if ended.is_empty() { "0".into() } else { ended.join(" + ") };
    let _ = writeln!(text, "#define SEVERAL_ENDED ({ended} > 1)");
    let hears = (0..sizes.runs).map(|x| {
        format!(
            "({x} < T[t].nr && T[t].r[{x}].end == 0 && M_CODEL[T[t].r[{x}].machine * STATES + SINK[k]])"
        )
    });
    let hears: Vec<String> = hears.collect();
    let _ = writeln!(text, "#define HEARS(t, k) ({})\n", hears.join(" ||\\\n  "));
}

fn machines(text: &mut String, system: &System) {
    let all = &system.machines;
    table(text, "M_SERVICE", all.iter().map(|m| m.service.map_or(255, usize::from)));
    table(text, "M_TASK", all.iter().map(|m| usize::from(m.task)));
    table(text, "M_FETCH", all.iter().map(|m| plus_one(m.fetch)));
    note(text, "states", system.plan.component().states.iter().cloned());
    table(text, "M_CODEL", all.iter().flat_map(|m| m.codels.iter().copied()).map(plus_one));
    table(text, "SINK", system.sinks.iter().map(|sink| usize::from(*sink)));
}

fn services(text: &mut String, system: &System) {
    let all = &system.services;
    let count = all.len();
    note(text, "services", (0..count).map(|at| system.service_name(crate::codels::small(at))));
    table(text, "S_MACHINE", all.iter().map(|s| plus_one(s.machine)));
    table(text, "S_ORDERED", all.iter().map(|s| usize::from(s.ordered)));
    let aborts = |work: &[Work]| usize::from(work.first() == Some(&Work::Abort));
    table(text, "S_ABORTS", all.iter().map(|s| aborts(&s.work)));
    let listed = |list: &dyn Fn(usize) -> Vec<u16>| -> Vec<usize> {
        let row = |at: usize| {
            let list = list(at);
            (0..count).map(move |other| usize::from(list.contains(&crate::codels::small(other))))
        };
        (0..count).flat_map(row).collect()
    };
    table(text, "BEFORE", listed(&|at| all[at].before.clone()).into_iter());
    table(text, "AFTER", listed(&|at| all[at].after.clone()).into_iter());
    let interrupts = all.iter().flat_map(|s| s.interrupts.iter().map(|is| usize::from(*is)));
    table(text, "INTERRUPTS", interrupts);
    let nodes = |work: &[Work]| -> Vec<usize> {
        let nodes = work.iter().filter_map(|work| match work {
            Work::Codel(node) | Work::Transfer(node) => Some(usize::from(*node) + 1),
            Work::Abort => None,
        });
        nodes.collect()
    };
    let work: Vec<Vec<usize>> = all.iter().map(|s| nodes(&s.work)).collect();
    let first = |at: usize| work[..at].iter().map(Vec::len).sum::<usize>();
    table(text, "S_FIRST", (0..count).map(first));
    table(text, "S_COUNT", work.iter().map(Vec::len));
    table(text, "WORK", work.iter().flatten().copied());
}

fn codels(text: &mut String, system: &System) {
    let nodes = system.plan.nodes().len();
    note(text, "nodes", (0..nodes).map(|node| system.node_name(crate::codels::small(node))));
    let conflicts = (0..crate::codels::small(nodes)).flat_map(|a| {
        let row = 0..crate::codels::small(nodes);
        row.map(move |b| usize::from(system.conflicts.between(a, b)))
    });
    table(text, "CONFLICT", conflicts);
    let transfer = [Answer::Ok];
    let answers: Vec<&[Answer]> = (0..nodes)
        .map(|node| system.codels.get(node).map_or(&transfer[..], |codel| &codel.answers))
        .collect();
    let first = |at: usize| answers[..at].iter().map(|answers| answers.len()).sum::<usize>();
    table(text, "A_FIRST", (0..nodes).map(first));
    table(text, "A_COUNT", answers.iter().map(|answers| answers.len()));
    let of = |answer: &Answer| match *answer {
        Answer::Go(to) => (0, to),
        Answer::Pause(to) => (1, to),
        Answer::Sleep(to) => (2, to),
        Answer::End => (3, 0),
        Answer::Ok => (4, 0),
        Answer::Fail => (5, 0),
    };
    let all: Vec<(usize, u16)> = answers.iter().flat_map(|list| list.iter().map(of)).collect();
    table(text, "A_KIND", all.iter().map(|(kind, _)| *kind));
    table(text, "A_TO", all.iter().map(|(_, to)| usize::from(*to)));
    note(
        text,
        "tasks",
        (0..system.periods.len()).map(|t| system.task_name(crate::codels::small(t))),
    );
    let periodic = system.periods.iter().map(|period| usize::from(period.is_some()));
    let _ = writeln!(text, "#ifndef TIME");
    table(text, "PERIOD", periodic);
    let _ = writeln!(text, "#endif");
}

/// Times in the greatest unit that all are multiples of.
fn clocks(text: &mut String, system: &System, times: &Times) {
    let nodes = crate::codels::small(system.plan.nodes().len());
    let durations: Vec<_> = (0..nodes).map(|node| times.of(node)).collect();
    let unit = unit(system, times);
    let units = |ns: u64| usize::try_from(ns / unit).unwrap_or(usize::MAX);
    let _ = writeln!(text, "#ifdef TIME /* in units of {unit} ns */");
    let periods = || system.periods.iter().map(|p| p.map_or((0, 0), |p| (p.period, p.delay)));
    numbers(text, "int", "PERIOD", periods().map(|(period, _)| units(period)));
    let since =
        |(period, delay): (u64, u64)| if period == 0 { 0 } else { (period - delay) % period };
    numbers(text, "int", "SINCE_TICK", periods().map(|period| units(since(period))));
    numbers(text, "int", "LEAST", durations.iter().map(|d| units(d.least)));
    numbers(text, "int", "MOST", durations.iter().map(|d| units(d.most.unwrap_or(0))));
    let _ = writeln!(text, "#endif");
}

/// Claims: what they ask is in the comment at the head.
fn properties(text: &mut String, system: &System) {
    let or = |all: &[String]| if all.is_empty() { "false".into() } else { all.join(" || ") };
    let _ = writeln!(text, "\nltl start {{ [] (phase != RUNNING) }}");
    for (ix, codel) in system.plan.component().codels.pairs() {
        let contexts = executors(system, ix);
        if contexts.is_empty() {
            // The runtime implements it.
            continue;
        }
        let executes: Vec<String> =
            contexts.iter().map(|c| format!("held[{c}] == {}", ix.index() + 1)).collect();
        let _ = writeln!(text, "ltl never_{} {{ [] !({}) }}", codel.name, or(&executes));
    }
    for (service, at) in system.services.iter().zip(0u16..) {
        if service.builtin.is_none() {
            let name = system.service_name(at);
            let _ = writeln!(text, "ltl never_ok_{name} {{ [] (pc[{at}] != CONCLUDE) }}");
        }
    }
    let _ = writeln!(text, "#ifdef TIME");
    for (period, task) in system.periods.iter().zip(0u16..) {
        if period.is_some() {
            let name = system.task_name(task);
            let _ = writeln!(text, "ltl in_time_{name} {{ [] !OVERRUN({task}) }}");
        }
    }
    let _ = writeln!(text, "#endif");
}

/// The contexts that may execute a codel.
pub(super) fn executors(system: &System, codel: CodelIx) -> Vec<usize> {
    let codel = crate::codels::small(codel.index());
    let machines = system.machines.iter().filter(|m| m.codels.contains(&Some(codel)));
    let mut all: Vec<usize> = machines.map(|machine| usize::from(machine.task)).collect();
    let services = system.services.iter().enumerate();
    let work = services.filter(|(_, service)| service.work.contains(&Work::Codel(codel)));
    all.extend(work.map(|(at, _)| system.periods.len() + at));
    all.sort_unstable();
    all.dedup();
    all
}

fn processes(text: &mut String, system: &System, sizes: &Sizes, timed: bool) {
    let tasks = 0..sizes.tasks;
    let any = |all: Vec<String>| if all.is_empty() { "false".into() } else { all.join(" || ") };
    let all = |all: Vec<String>| if all.is_empty() { "true".into() } else { all.join(" && ") };
    let services: Vec<usize> = (0..system.services.len()).collect();
    let of_task = |task: usize| [format!("run task({task})"), format!("run collector({task})")];
    let mut run: Vec<String> = tasks.clone().flat_map(of_task).collect();
    run.push("run control()".into());
    let clients = services.iter().filter(|at| system.services[**at].builtin.is_none());
    run.extend(clients.map(|at| format!("run service({at})")));
    let aborts = |at: &usize| system.services[*at].work.first() == Some(&Work::Abort);
    if system.bounds.abort && sizes.tasks > 0 && services.iter().any(aborts) {
        if system.wakes_others(None) {
            run.push("run abort_pending(NONE)".into());
        }
        run.extend((0..sizes.pending).map(|at| format!("run abort_pending({at})")));
        let places = tasks.clone().flat_map(|task| (0..sizes.runs - 1).map(move |at| (task, at)));
        run.extend(places.map(|(task, at)| format!("run abort_run({task}, {at})")));
        run.push("run abort_ends()".into());
    }
    if system.bounds.fire {
        let sinks = 0..system.sinks.len();
        let pairs = tasks.clone().flat_map(|task| sinks.clone().map(move |sink| (task, sink)));
        run.extend(pairs.map(|(task, sink)| format!("run event({task}, {sink})")));
    }
    let _ = writeln!(text, "#ifdef TIME");
    if timed {
        let ticks = tasks.clone().filter(|task| system.periods[*task].is_some());
        let held = 0..sizes.tasks + system.services.len();
        let may = ticks.clone().map(|task| format!("clock[{task}] < PERIOD[{task}]")).chain(
            held.clone().map(|c| format!("(held[{c}] == 0 || since[{c}] < MOST[held[{c}] - 1])")),
        );
        let pass = ticks
            .clone()
            .map(|task| format!("clock[{task}]++;"))
            .chain(held.map(|c| format!("if :: held[{c}] -> since[{c}]++ :: else -> skip fi;")));
        let urgent = tasks
            .clone()
            .map(|t| {
                format!(
                    "T[{t}].at == BEGIN || T[{t}].at == WAKE || (T[{t}].at == SLEEP && \
                     T[{t}].runnable) || (phase != STARTING && T[{t}].no > 0)"
                )
            })
            .chain(services.iter().map(|s| format!("pc[{s}] >= WAKE_OK")));
        let _ = writeln!(
            text,
            "#define URGENT (ADVANCES || (TASK_COUNT > 0 && phase == STARTING && \
             T[step].at == ABSENT) || {})\nproctype time() {{\nend:\n  do\n  :: d_step {{ phase != \
             STOPPED && !URGENT && {} -> {} skip }}\n  od\n}}",
            any(urgent.collect()),
            all(may.collect()),
            pass.collect::<Vec<_>>().join(" ")
        );
    }
    let _ = writeln!(text, "#endif");
    let _ = writeln!(text, "init {{\n  atomic {{\n#ifdef TIME");
    for task in tasks {
        let _ = writeln!(text, "    clock[{task}] = SINCE_TICK[{task}];");
    }
    let clock = if timed { "    run time();\n" } else { "" };
    let _ = writeln!(text, "{clock}#endif\n    {}\n  }}\n}}", run.join(";\n    "));
}

fn plus_one(index: Option<u16>) -> usize {
    index.map_or(0, |index| usize::from(index) + 1)
}

/// A table of constants, which is no part of a state.
fn table(text: &mut String, name: &str, values: impl Iterator<Item = usize>) {
    numbers(text, "short", name, values);
}

fn numbers(text: &mut String, kind: &str, name: &str, values: impl Iterator<Item = usize>) {
    let values: Vec<String> = values.map(|value| value.to_string()).collect();
    if values.is_empty() {
        let _ = writeln!(text, "hidden {kind} {name}[1];");
    } else {
        let (count, list) = (values.len(), values.join(", "));
        let _ = writeln!(text, "hidden {kind} {name}[{count}] = {{ {list} }};");
    }
}

/// What the numbers of a table are.
fn note(text: &mut String, what: &str, names: impl Iterator<Item = String>) {
    let names: Vec<String> = names.enumerate().map(|(at, name)| format!("{at} {name}")).collect();
    let _ = writeln!(text, "/* {what}: {} */", names.join(", "));
}
