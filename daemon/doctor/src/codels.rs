//! Findings about code that does not behave: it does not return, never pauses, or writes where it
//! may not.

use genom_protocol::{
    Component, Diagnosis, LeftBehind, Remedy, RunningCodel, Spin, Unpaused, advice, routes,
};

/// What the code of a component does.
pub(crate) fn of_component(component: &Component) -> Vec<Diagnosis> {
    let name = &component.name;
    let mut found: Vec<Diagnosis> =
        component.stuck.iter().map(|codel| stuck(name, codel)).collect();
    found.extend(component.spins.iter().map(|spin| spins(name, spin)));
    for rule in component.supervision.iter().filter(|rule| rule.violations > 0) {
        let (what, fix) = (advice::broken_rule(name, rule), advice::after_broken_rule(name));
        found.push(Diagnosis::problem("supervision", what, fix).or(Remedy::reload(name)));
    }
    if component.state == "damaged" {
        let what = format!("codels of {name} wrote past the memory they were given");
        let fix = format!(
            "`genomctl logs --level error` says which; mend it, `genomctl unload {name}` and load it"
        );
        found.push(Diagnosis::problem("memory", what, fix).or(Remedy::unload(name)));
    }
    found
}

/// A component that did not stop.
pub(crate) fn left(LeftBehind { was, component, state }: &LeftBehind) -> Diagnosis {
    let what = format!("of {was} ({component}): {state}");
    let fix = "it goes when its codel returns; restart genomd to be rid of it";
    Diagnosis::problem("left behind", what, fix)
}

/// A codel that does not return.
fn stuck(name: &str, running: &RunningCodel) -> Diagnosis {
    let RunningCodel { codel, owner, task, for_ns, .. } = running;
    let whose = task.as_ref().map_or("a request".to_owned(), |task| format!("task {task}"));
    let time = for_ns / 1_000_000_000;
    let what = format!("{whose} of {name} is stuck in {codel} of {owner} for {time} s");
    let fix = format!(
        "look at what the codel waits for (gdb -p); `genomctl unload {name}` leaves it behind"
    );
    Diagnosis::problem("codels", what, fix).or(Remedy::unload(name))
}

/// A task that occupies a processor and never pauses.
fn spins(name: &str, Spin { unpaused, processor }: &Spin) -> Diagnosis {
    let Unpaused { task, codel, owner, for_ns, .. } = unpaused;
    let (time, share) = (for_ns / 1_000_000_000, processor * 100.0);
    let what = format!(
        "task {task} of {name} does not pause: codel {codel} of {owner} yields without pause for \
         {time} s ({share:.0} % of a processor)"
    );
    let abort = Remedy::new(format!("Abort all of {name}"), &routes::abort_all(name));
    Diagnosis::problem("codels", what, advice::unpaused(codel)).or(abort).or(Remedy::reload(name))
}
