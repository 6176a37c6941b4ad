//! The language of UPPAAL (flat system 1.6).

use std::fmt::Write as _;

use super::flat::{Flat, To};
use crate::system::System;

pub(super) fn uppaal(system: &System, flat: &Flat) -> String {
    let name = &system.plan().component().name;
    let mut text = String::from(
        "<?xml version=\"1.0\" encoding=\"utf-8\"?>\n<!DOCTYPE nta PUBLIC '-//Uppaal Team//DTD Flat System \
         1.6//EN' 'http://www.it.uu.se/research/group/darts/uppaal/flat-1_6.dtd'>\n",
    );
    let _ = writeln!(
        text,
        "<!-- Component {name}, with its clocks in units of {} ns. Checked by: verifyta {name}.xml -->",
        flat.unit
    );
    let _ = writeln!(text, "<nta>\n<declaration>clock {};</declaration>", flat.clocks.join(", "));
    let _ = writeln!(text, "<template><name>Component</name>");
    for (at, (clock, most, _)) in flat.before.iter().enumerate() {
        location(&mut text, &format!("b{at}"), "", &[(clock.clone(), *most)], false);
    }
    for (at, one) in flat.locations.iter().enumerate() {
        location(&mut text, &format!("s{at}"), "", &one.most, one.urgent);
    }
    for (task, task_name) in &flat.late {
        location(&mut text, &format!("l{task}"), &format!("late_{task_name}"), &[], true);
    }
    location(&mut text, "u", "unreachable", &[], true);
    let first = if flat.before.is_empty() { "s0" } else { "b0" };
    let _ = writeln!(text, "<init ref=\"{first}\"/>");
    for (at, (clock, most, begins)) in flat.before.iter().enumerate() {
        let to = if at + 1 == flat.before.len() { "s0".into() } else { format!("b{}", at + 1) };
        let begins: Vec<String> =
            Some(begins.clone()).filter(|one| !one.is_empty()).into_iter().collect();
        transition(
            &mut text,
            &format!("b{at}"),
            &to,
            Some(format!("{clock} == {most}")),
            &begins,
            "",
        );
    }
    for edge in &flat.edges {
        let (to, begins) = match edge.to {
            To::State(to) => (format!("s{to}"), &edge.begins),
            To::Unreachable => ("u".into(), &flat.clocks),
            To::Late(task) => (format!("l{task}"), &flat.clocks),
        };
        let guard = edge.least.as_ref().map(|(clock, least)| format!("{clock} &gt;= {least}"));
        transition(&mut text, &format!("s{}", edge.from), &to, guard, begins, &edge.what);
    }
    let _ = writeln!(text, "</template>\n<system>c = Component();\nsystem c;</system>\n<queries>");
    let mut query = |formula: String, comment: String| {
        let _ = writeln!(
            text,
            "<query><formula>{formula}</formula><comment>{comment}</comment></query>"
        );
    };
    for (_, task) in &flat.late {
        query(format!("A[] not c.late_{task}"), format!("task {task} is never late"));
    }
    query("A[] not c.unreachable".into(), "genomctl has found all states".into());
    text.push_str("</queries>\n</nta>\n");
    text
}

fn location(text: &mut String, id: &str, name: &str, most: &[(String, u64)], urgent: bool) {
    let _ = write!(text, "<location id=\"{id}\">");
    if !name.is_empty() {
        let _ = write!(text, "<name>{name}</name>");
    }
    if !most.is_empty() {
        let all = most.iter().map(|(clock, most)| format!("{clock} &lt;= {most}"));
        let all: Vec<String> = all.collect();
        let _ = write!(text, "<label kind=\"invariant\">{}</label>", all.join(" &amp;&amp; "));
    }
    text.push_str(if urgent { "<urgent/></location>\n" } else { "</location>\n" });
}

fn transition(
    text: &mut String,
    from: &str,
    to: &str,
    guard: Option<String>,
    begins: &[String],
    what: &str,
) {
    let _ = write!(text, "<transition><source ref=\"{from}\"/><target ref=\"{to}\"/>");
    if let Some(guard) = guard {
        let _ = write!(text, "<label kind=\"guard\">{guard}</label>");
    }
    if !begins.is_empty() {
        let all: Vec<String> = begins.iter().map(|clock| format!("{clock} = 0")).collect();
        let _ = write!(text, "<label kind=\"assignment\">{}</label>", all.join(", "));
    }
    if !what.is_empty() {
        let what = what.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;");
        let _ = write!(text, "<label kind=\"comments\">{what}</label>");
    }
    text.push_str("</transition>\n");
}
