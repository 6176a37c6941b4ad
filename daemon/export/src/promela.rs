//! Promela: tables of the component, then the rules, which are the same for all.

use std::fmt::Write as _;

use genom_formal::{System, Times};

use crate::error::ExportError;
use crate::tables::{
    Entry, Sizes, durations, executed, is_aborted, listed, periodic, tables, wakes,
};

/// The rules in Promela.
const RULES: &str = include_str!("rules.pml");

/// The model; with clocks if there are times.
pub(crate) fn promela(system: &System, times: Option<&Times>) -> Result<String, ExportError> {
    let sizes = Sizes::new(system, "promela")?;
    let mut text = head(system, times.is_some());
    defines(&mut text, system, &sizes);
    constants(&mut text, "short", &tables(system));
    text.push_str("#ifndef TIME\n");
    constants(&mut text, "short", &[periodic(system)]);
    text.push_str("#endif\n");
    if let Some(times) = times {
        let _ = writeln!(text, "#ifdef TIME /* in units of {} ns */", times.unit(system));
        constants(&mut text, "int", &durations(system, times));
        text.push_str("#endif\n");
    }
    text.push_str(RULES);
    properties(&mut text, system);
    processes(&mut text, system, &sizes, times.is_some());
    Ok(text)
}

fn head(system: &System, timed: bool) -> String {
    let name = &system.plan().component().name;
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
    for (name, value) in sizes.constants(system) {
        let _ = writeln!(text, "#define {name} {value}");
    }
    let _ = writeln!(text, "#define FIRST_PHASE {}", sizes.first_phase());
    let contexts = sizes.contexts();
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

/// Tables of constants, which are no part of a state.
fn constants(text: &mut String, kind: &str, entries: &[Entry]) {
    for entry in entries {
        let (name, values) = match entry {
            Entry::Note(..) => {
                let _ = writeln!(text, "/* {entry} */");
                continue;
            }
            Entry::Table(name, values) => (name, values),
        };
        let _ = if values.is_empty() {
            writeln!(text, "hidden {kind} {name}[1];")
        } else {
            writeln!(text, "hidden {kind} {name}[{}] = {{ {} }};", values.len(), listed(values))
        };
    }
}

/// Claims: what they ask is in the comment at the head.
fn properties(text: &mut String, system: &System) {
    let or = |all: &[String]| if all.is_empty() { "false".into() } else { all.join(" || ") };
    let _ = writeln!(text, "\nltl start {{ [] (phase != RUNNING) }}");
    for (ix, codel) in system.plan().component().codels.pairs() {
        let executes = executed(system, ix);
        if executes.is_empty() {
            continue;
        }
        let _ = writeln!(text, "ltl never_{} {{ [] !({}) }}", codel.name, or(&executes));
    }
    for (service, at) in system.services().iter().zip(0u16..) {
        if service.builtin.is_none() {
            let name = system.service_name(at);
            let _ = writeln!(text, "ltl never_ok_{name} {{ [] (pc[{at}] != CONCLUDE) }}");
        }
    }
    let _ = writeln!(text, "#ifdef TIME");
    for (period, task) in system.periods().iter().zip(0u16..) {
        if period.is_some() {
            let name = system.task_name(task);
            let _ = writeln!(text, "ltl in_time_{name} {{ [] !OVERRUN({task}) }}");
        }
    }
    let _ = writeln!(text, "#endif");
}

fn processes(text: &mut String, system: &System, sizes: &Sizes, timed: bool) {
    let tasks = 0..sizes.tasks;
    let any = |all: Vec<String>| if all.is_empty() { "false".into() } else { all.join(" || ") };
    let all = |all: Vec<String>| if all.is_empty() { "true".into() } else { all.join(" && ") };
    let services: Vec<usize> = (0..system.services().len()).collect();
    let of_task = |task: usize| [format!("run task({task})"), format!("run collector({task})")];
    let mut run: Vec<String> = tasks.clone().flat_map(of_task).collect();
    run.push("run control()".into());
    let clients = services.iter().filter(|at| system.services()[**at].builtin.is_none());
    run.extend(clients.map(|at| format!("run service({at})")));
    if is_aborted(system) {
        if wakes(system) {
            run.push("run abort_pending(NONE)".into());
        }
        run.extend((0..sizes.pending).map(|at| format!("run abort_pending({at})")));
        let places = tasks.clone().flat_map(|task| (0..sizes.runs - 1).map(move |at| (task, at)));
        run.extend(places.map(|(task, at)| format!("run abort_run({task}, {at})")));
        run.push("run abort_ends()".into());
    }
    if system.bounds().fire {
        let sinks = 0..sizes.sinks;
        let pairs = tasks.clone().flat_map(|task| sinks.clone().map(move |sink| (task, sink)));
        run.extend(pairs.map(|(task, sink)| format!("run event({task}, {sink})")));
    }
    let _ = writeln!(text, "#ifdef TIME");
    if timed {
        let ticks = tasks.clone().filter(|task| system.periods()[*task].is_some());
        let held = 0..sizes.tasks + system.services().len();
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
