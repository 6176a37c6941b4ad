//! UPPAAL: states and steps.

use std::fmt::Write as _;

use genom_formal::{Flat, FlatTo, System};

use crate::xml::{self, Edge, Place};

pub(crate) fn uppaal_flat(system: &System, flat: &Flat) -> String {
    let name = &system.plan().component().name;
    let unit = flat.unit;
    let mut text = xml::head(&format!(
        "Component {name}, with its clocks in units of {unit} ns. Checked by: verifyta {name}.xml"
    ));
    let _ = writeln!(text, "<declaration>clock {};</declaration>", flat.clocks.join(", "));
    let _ = writeln!(text, "<template><name>Component</name>");
    for (at, (clock, most, _)) in flat.before.iter().enumerate() {
        place(&mut text, &format!("b{at}"), "", &[(clock.clone(), *most)], "");
    }
    for (at, one) in flat.states.iter().enumerate() {
        let kind = if one.urgent { "urgent" } else { "" };
        place(&mut text, &format!("s{at}"), "", &one.most, kind);
    }
    for (task, task_name) in &flat.late {
        place(&mut text, &format!("l{task}"), &format!("late_{task_name}"), &[], "urgent");
    }
    place(&mut text, "u", "unreachable", &[], "urgent");
    let first = if flat.before.is_empty() { "s0" } else { "b0" };
    let _ = writeln!(text, "<init ref=\"{first}\"/>");
    for (at, (clock, most, begins)) in flat.before.iter().enumerate() {
        let to = if at + 1 == flat.before.len() { "s0".into() } else { format!("b{}", at + 1) };
        let begins: Vec<String> =
            Some(begins.clone()).filter(|one| !one.is_empty()).into_iter().collect();
        let guard = format!("{clock} == {most}");
        edge(&mut text, (&format!("b{at}"), &to), &guard, &begins, "");
    }
    for step in &flat.steps {
        let (to, begins) = match step.to {
            FlatTo::State(to) => (format!("s{to}"), &step.begins),
            FlatTo::Unreachable => ("u".into(), &flat.clocks),
            FlatTo::Late(task) => (format!("l{task}"), &flat.clocks),
        };
        let least = step.least.as_ref().map(|(clock, least)| format!("{clock} >= {least}"));
        let guard = least.unwrap_or_default();
        edge(&mut text, (&format!("s{}", step.from), &to), &guard, begins, &step.what);
    }
    let _ = writeln!(text, "</template>\n<system>c = Component();\nsystem c;</system>\n<queries>");
    for (_, task) in &flat.late {
        let comment = format!("task {task} is never late");
        xml::query(&mut text, &format!("A[] not c.late_{task}"), &comment);
    }
    xml::query(&mut text, "A[] not c.unreachable", "genomctl has found all states");
    text.push_str("</queries>\n</nta>\n");
    text
}

fn place(text: &mut String, id: &str, name: &str, most: &[(String, u64)], kind: &str) {
    let all: Vec<String> = most.iter().map(|(clock, most)| format!("{clock} <= {most}")).collect();
    xml::place(text, &Place { id, name, invariant: &all.join(" && "), kind });
}

fn edge(text: &mut String, (from, to): (&str, &str), guard: &str, begins: &[String], what: &str) {
    let all: Vec<String> = begins.iter().map(|clock| format!("{clock} = 0")).collect();
    let assign = all.join(", ");
    xml::edge(text, &Edge { from, to, guard, assign: &assign, comment: what, ..Edge::default() });
}
