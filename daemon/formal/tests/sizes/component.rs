//! Descriptions of components of real size: control loops with activities of a few states.

use std::fmt::Write as _;

use super::random::Random;

/// How large a component is.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Size {
    pub(crate) tasks: usize,
    pub(crate) activities: usize,
    pub(crate) functions: usize,
}

/// A component: each task has a permanent activity of two codels, each activity three codels and at
/// times a validation; all share ten members of the IDS.
pub(crate) fn component(random: &mut Random, size: Size) -> String {
    // Some are too slow for their periods.
    let scale = *random.one(&[1, 1, 4, 8]);
    let mut text = String::from("component big {\n  ids { long ");
    text.push_str(&(0..10).map(|at| format!("m{at}")).collect::<Vec<_>>().join(", "));
    text.push_str("; };\n  exception E;\n");
    for task in 0..size.tasks {
        let period = match random.below(6) {
            0 => String::new(),
            _ => format!("period {} ms; ", [5, 10, 20][task % 3]),
        };
        writeln!(
            text,
            "  task t{task} {{ {period}codel<start> t{task}_start({}) yield main wcet 100 us;\n    \
             codel<main> t{task}_main({}) yield pause::main wcet {} us; }};",
            parameters(random),
            parameters(random),
            wcet(random, scale),
        )
        .unwrap();
    }
    for function in 0..size.functions {
        writeln!(
            text,
            "  function f{function}() {{ codel f{function}_run({}) wcet {} us; }};",
            parameters(random),
            wcet(random, scale),
        )
        .unwrap();
    }
    writeln!(text, "  attribute set(in m0); attribute get(out m1);").unwrap();
    for activity in 0..size.activities {
        let task = activity % size.tasks;
        let others: Vec<String> = (0..size.activities)
            .filter(|other| *other == activity || random.percent(20))
            .map(|other| format!("a{other}"))
            .collect();
        let validate = if random.percent(25) {
            format!(" validate a{activity}_check() wcet 50 us;")
        } else {
            String::new()
        };
        writeln!(
            text,
            "  activity a{activity}() {{ task t{task};{validate}\n    \
             codel<start> a{activity}_start({}) yield main, ether wcet {} us;\n    \
             codel<main> a{activity}_main({}) yield pause::main, stop wcet {} us;\n    \
             codel<stop> a{activity}_stop({}) yield ether wcet {} us;\n    \
             interrupts {}; throw E; }};",
            parameters(random),
            wcet(random, scale),
            parameters(random),
            wcet(random, scale),
            parameters(random),
            wcet(random, scale),
            others.join(", "),
        )
        .unwrap();
    }
    text.push_str("};\n");
    text
}

fn parameters(random: &mut Random) -> String {
    let first = random.below(10);
    let access = random.one(&["in", "out", "inout"]);
    if random.percent(40) { format!("{access} m{first}") } else { String::new() }
}

/// In microseconds.
fn wcet(random: &mut Random, scale: usize) -> usize {
    scale * (50 + 50 * random.below(6))
}
