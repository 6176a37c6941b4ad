//! Descriptions of random components.

use std::fmt::Write as _;

use super::random::Random;

/// Figures of the papers and of the tests of the runtime, beside random components.
const FIXED: &[&str] = &[
    // The 2010 paper: one transition a period, parameters through the IDS, an external event.
    "struct demo_state { double position; double velocity; };
     inport long parameter; outport double position; event emergency;
     component demo { language: \"c\"; ids: demo_state; };
     service goto { task: main; input: position; output: position; throws: SERVO_ERROR;
       codel start: demo_init_velocity(out velocity) yield main;
       codel main: demo_servo(in position, out velocity, outport position) yield main, stop;
       codel stop, emergency: demo_stop() yield ether; };
     task main { period: 5ms; priority: 20; };",
    // All states, several tasks, sleep.
    "component demo {
       ids { long a; };
       event alarm;
       exception E { long code; };
       task p { period 5 ms; codel<start> p1() yield ether; codel<stop> p2() yield ether; };
       task q { };
       attribute set(in a);
       function f() { codel f1(); codel f2(); interrupts one; throw E; };
       activity one() { task p; validate check();
         codel<start> a1() yield main, pause::main, ether, sleep, stop;
         codel<main> a2() yield main, pause::main, ether, start;
         codel<alarm> a3() yield ether, main, sleep;
         codel<stop> a4() yield ether, pause::stop;
         interrupts one; throw E; };
       activity two() { task q; codel<start> b1() yield main, pause::main, ether;
         codel<main> b2() yield pause::main, ether, start; interrupts one, two; after set; };
       activity three() { task q; codel<start> c1() yield pause::start, ether;
         codel<stop> c2() yield ether; };
     };",
];

/// A description.
pub(crate) fn component(random: &mut Random) -> String {
    if random.percent(20) {
        return (*random.one(FIXED)).to_owned();
    }
    let mut text =
        String::from("component demo {\n ids { long a, b, c; };\n exception E { long code; };\n");
    let events = random.some(&["alarm", "alert"], 50);
    events.iter().for_each(|event| writeln!(text, " event {event};").unwrap());
    let tasks = 1 + random.below(3);
    for task in 0..tasks {
        write!(text, " task t{task} {{").unwrap();
        if random.percent(70) {
            let period = random.one(&[2, 5, 7, 10]);
            write!(text, " period {period} ms;").unwrap();
            if random.percent(50) {
                write!(text, " delay {} ms;", 1 + random.below(*period - 1)).unwrap();
            }
        }
        if random.percent(60) {
            machine(&mut text, random, &format!("t{task}"), &[]);
        }
        writeln!(text, " }};").unwrap();
    }
    let activities: Vec<String> = (0..1 + random.below(4)).map(|n| format!("act{n}")).collect();
    writeln!(text, " attribute set(in a) {{ {} }};", order(random, &activities)).unwrap();
    if random.percent(50) {
        let validate = if random.percent(50) { "validate get_check(in c);" } else { "" };
        writeln!(text, " attribute get(out b) {{ {validate} }};").unwrap();
    }
    let interrupts = list("interrupts", &random.some(&activities, 40));
    let (first, second) = (parameters(random), parameters(random));
    writeln!(
        text,
        " function f() {{ codel f1({first}); codel f2({second}); {interrupts} throw E; }};"
    )
    .unwrap();
    for name in &activities {
        write!(text, " activity {name}() {{ task t{};", random.below(tasks)).unwrap();
        if random.percent(40) {
            write!(text, " validate {name}_check({});", parameters(random)).unwrap();
        }
        machine(&mut text, random, name, &events);
        let interrupts = list("interrupts", &random.some(&activities, 40));
        write!(text, " {interrupts} {}", order(random, &activities)).unwrap();
        text.push_str(if random.percent(50) { " throw E; };\n" } else { " };\n" });
    }
    text.push_str("};\n");
    text
}

/// Codels of a state machine.
fn machine(text: &mut String, random: &mut Random, owner: &str, events: &[&str]) {
    let mut states = vec!["start"];
    states.extend(random.some(&["main", "stop"], 60));
    states.extend(random.some(events, 70));
    for state in &states {
        let mut all: Vec<String> =
            states.iter().flat_map(|to| [(*to).to_owned(), format!("pause::{to}")]).collect();
        if !events.is_empty() {
            all.push("sleep".into());
        }
        let mut yields = random.some(&all, 30);
        // A state that nothing leads to is a mistake.
        let missing = *state == "start" && states.contains(&"main");
        if missing && !yields.iter().any(|to| to.ends_with("main")) {
            yields.push((*random.one(&["main", "pause::main"])).into());
        }
        yields.push("ether".into());
        let (parameters, yields) = (parameters(random), yields.join(", "));
        write!(text, " codel<{state}> {owner}_{state}({parameters}) yield {yields};").unwrap();
    }
}

/// Accesses to the IDS, which exclude each other.
fn parameters(random: &mut Random) -> String {
    let mut accesses = Vec::new();
    for datum in ["a", "b", "c"] {
        if random.percent(30) {
            accesses.push(format!("{} {datum}", random.one(&["in", "out", "inout"])));
        }
    }
    accesses.join(", ")
}

/// `before` and `after`, seldom.
fn order(random: &mut Random, activities: &[String]) -> String {
    let (before, after) = (random.some(activities, 6), random.some(activities, 6));
    format!("{} {}", list("before", &before), list("after", &after))
}

fn list(key: &str, names: &[String]) -> String {
    if names.is_empty() { String::new() } else { format!("{key} {};", names.join(", ")) }
}
