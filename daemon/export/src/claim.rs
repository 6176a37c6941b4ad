//! Formulas of users as claims of a Promela model.

use genom_description::model::{CodelIx, Ix as _};

use genom_formal::{Atom, Formula, Join, System, Term};

use crate::tables::{executed, most_pending, runs_of_task};

/// The claim `user`; `None` if the formula speaks of the past, which Promela's do not.
pub(crate) fn claim(system: &System, formula: &Formula, model: &str) -> Option<String> {
    let name = &system.plan().component().name;
    Some(format!(
        "\n/* {formula}\n   Checked for all runs in which no process waits for ever though it could go \
         on; errors: 0 if it holds:\n     spin -a {name}.pml && cc -O2 -DNFAIR={} -DVECTORSZ=4096 -o pan \
         pan.c && ./pan -a -f -m1000000 -N user */\nltl user {{ {} }}\n",
        fairness(model),
        term(system, formula.term())?
    ))
}

/// What Spin's program is compiled with (`-DNFAIR`) to be fair to all processes of a model.
#[must_use]
pub fn fairness(model: &str) -> usize {
    // It counts four to a byte, two of which it takes for itself.
    model.matches("run ").count() / 4 + 2
}

fn term(system: &System, of: &Term) -> Option<String> {
    let one = |part: &Term| term(system, part);
    Some(match of {
        Term::Const(value) => value.to_string(),
        Term::Atom(atom) => fact(system, *atom),
        Term::Not(a) => format!("!({})", one(a)?),
        Term::Two(join, a, b) => {
            let join = match join {
                Join::And => "&&",
                Join::Or => "||",
                Join::Implies => "->",
                Join::Equal => "<->",
            };
            format!("(({}) {join} ({}))", one(a)?, one(b)?)
        }
        Term::Always(a) => format!("[] ({})", one(a)?),
        Term::Eventually(a) => format!("<> ({})", one(a)?),
        Term::Until(a, b) => format!("(({}) U ({}))", one(a)?, one(b)?),
        Term::Once(_) | Term::Historically(_) | Term::Since(..) | Term::Previous(_) => return None,
    })
}

fn fact(system: &System, atom: Atom) -> String {
    let any = |all: Vec<String>| if all.is_empty() { "false".into() } else { all.join(" || ") };
    let of_service = |service: u16, what: &dyn Fn(usize, usize) -> String| -> Vec<String> {
        let machine = system.services()[usize::from(service)].machine;
        let Some(machine) = machine else { return Vec::new() };
        let task = usize::from(system.machines()[usize::from(machine)].task);
        let places = 0..runs_of_task(system, task);
        let own = |at: usize| format!("T[{task}].r[{at}].machine == {machine}");
        places.map(|at| format!("({} && {})", own(at), what(task, at))).collect()
    };
    let all = match atom {
        Atom::Codel(codel) => executed(system, CodelIx::new(codel.into())),
        Atom::Run(service) => of_service(service, &|t, x| {
            format!(
                "{x} < T[{t}].nr && T[{t}].r[{x}].end == 0 && \
                 (T[{t}].r[{x}].life == RUN || T[{t}].r[{x}].life == STOP)"
            )
        }),
        Atom::Pending(service) => {
            let mut all = of_service(service, &|t, x| {
                format!("{x} < T[{t}].nr + T[{t}].ni && T[{t}].r[{x}].life == INIT")
            });
            let places = 0..most_pending(system);
            all.extend(places.map(|at| format!("({at} < np && pending[{at}] == {service})")));
            all
        }
        Atom::Late(task) => vec![format!("OVERRUN({task})")],
    };
    format!("({})", any(all))
}
