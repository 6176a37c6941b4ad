//! What was found, as text.

use std::fmt::Write as _;

use genom_description::model::Span;
use genom_description::source::SourceMap;

use genom_formal::{Bounds, Finding, Longest, Response, Spent, TaskReport, Verdict, duration};

use crate::columns;
use crate::found::{Found, Ticks};

/// What was found, for people; with places in the description.
#[must_use]
pub(crate) fn text(found: &Found, sources: &SourceMap) -> String {
    let mut text = format!("component {}\n", found.system.plan().component().name);
    let report = &found.report;
    let properties = report.verdicts.iter().map(|(property, one)| (property.name().into(), one));
    let formulas = report.formulas.iter().map(|(formula, one)| (format!("ltl {formula}  "), one));
    for (name, verdict) in properties.chain(formulas) {
        let name: &str = &name;
        match verdict {
            Verdict::Holds => line(&mut text, name, "holds"),
            Verdict::Undecided(why) => line(&mut text, name, &format!("not decided: {why}")),
            Verdict::Violated(all) => {
                line(&mut text, name, "VIOLATED");
                all.iter().for_each(|one| finding(&mut text, one, sources));
            }
        }
    }
    match &found.ticks {
        Ticks::Unasked => {}
        Ticks::Unknown(name, why) => line(&mut text, name, &format!("not decided: {why}")),
        Ticks::Seen(times) => {
            let limit = times.limit().map(|limit| limit.to_string());
            times.tasks.iter().for_each(|one| task(&mut text, one, limit.as_deref(), sources));
            responses(&mut text, &times.responses);
        }
    }
    if let Some(explored) = &found.report.explored {
        let _ = writeln!(text, "{} states, {} steps", explored.states, explored.steps);
    }
    if let Ticks::Seen(times) = &found.ticks
        && !times.tasks.is_empty()
    {
        let (states, zones) = (times.explored.states(), times.explored.zones());
        let _ = writeln!(text, "with times: {states} states, {zones} zones");
    }
    assumed(&mut text, found);
    text
}

/// Under which assumptions all this was found.
fn assumed(text: &mut String, found: &Found) {
    let Bounds { instances, requests, abort, fire, kill, .. } = found.system.bounds();
    let without = [(abort, "aborts"), (fire, "events"), (kill, "shutdown")];
    let without = without.into_iter().filter(|(is_there, _)| !*is_there);
    let without: String = without.map(|(_, what)| format!(", no {what}")).collect();
    let times = match &found.ticks {
        Ticks::Seen(_) => ", take at most the times known of them, and wait for no processor",
        Ticks::Unknown(..) | Ticks::Unasked => "",
    };
    let requests = format!("{requests} request{}", if *requests == 1 { "" } else { "s" });
    let _ = writeln!(
        text,
        "assumed: at most {requests} at a time and {instances} activities of each \
         service{without}; codels yield all that they may{times}"
    );
}

fn line(text: &mut String, name: &str, verdict: &str) {
    let _ = writeln!(text, "{name:9}{verdict}");
}

fn finding(text: &mut String, finding: &Finding, sources: &SourceMap) {
    let _ = writeln!(text, "  {}{}", finding.what, place(finding.span, sources));
    for line in &finding.run {
        let _ = writeln!(text, "    {}: {}{}", line.who, line.what, place(line.span, sources));
    }
}

fn task(text: &mut String, task: &TaskReport, limit: Option<&str>, sources: &SourceMap) {
    let name = format!("task {} ({})", task.name, duration(task.period));
    let took = task.response.map_or_else(
        || "it never ends a cycle".to_owned(),
        |most| format!("at most {} from a tick to the end of its cycle", duration(most)),
    );
    match (task.overrun.is_empty(), limit.filter(|_| task.is_open())) {
        (true, None) => line(text, "overrun", &format!("{name} holds: {took}")),
        (true, Some(limit)) => line(text, "overrun", &format!("{name} not decided: {limit}")),
        (false, _) => {
            line(text, "overrun", &format!("{name} VIOLATED"));
            text.push_str(&columns::late(task, |span| place(span, sources)));
            cycle(text, task);
        }
    }
}

/// What the cycle is made of that is late, and what would have to be shorter.
fn cycle(text: &mut String, task: &TaskReport) {
    let _ = writeln!(text, "    {} is still at work at its tick:", task.name);
    let last = task.spent.len().saturating_sub(1);
    for (at, Spent { codel, awaited, ns }) in task.spent.iter().enumerate() {
        let waits = match awaited.as_slice() {
            [] => String::new(),
            awaited => format!(" waits for {}", awaited.join(", ")),
        };
        let on = if at == last { ", and goes on" } else { "" };
        let _ = writeln!(text, "  {:>12}  {codel}{waits}{on}", duration(*ns));
    }
    let most = task.response.filter(|most| *most > task.period);
    let most = most.map_or_else(String::new, |most| format!("; it may take {}", duration(most)));
    let _ = writeln!(text, "  {:>12}  are there{most}", duration(task.period));
    for (codel, below) in &task.needed {
        let _ = writeln!(text, "    holds if {codel} takes less than {}", duration(*below));
    }
}

/// Activities of which nothing is decided for the same reason share a line.
fn responses(text: &mut String, all: &[Response]) {
    let reason = |one: &Response| match (&one.begins, &one.ends) {
        (Longest::Undecided(begins), Longest::Undecided(ends)) if begins == ends => {
            Some(begins.clone())
        }
        _ => None,
    };
    let (open, known): (Vec<&Response>, Vec<&Response>) =
        all.iter().partition(|one| reason(one).is_some());
    known.into_iter().for_each(|one| response(text, one));
    for same in open.chunk_by(|a, b| reason(a) == reason(b)) {
        match same {
            [one] => response(text, one),
            _ => {
                let names: Vec<&str> = same.iter().map(|one| one.service.as_str()).collect();
                let why = reason(same[0]).unwrap_or_default();
                let what = format!("activities {} not decided: {why}", names.join(", "));
                line(text, "respond", &what);
            }
        }
    }
}

fn response(text: &mut String, response: &Response) {
    let Response { service, begins, ends } = response;
    let begins = longest(begins, "it is never accepted", "begins", "after it was accepted");
    let stops = "after it was asked to stop";
    let ends = longest(ends, "it is never asked to stop", "ends", stops);
    line(text, "respond", &format!("activity {service} {begins}; {ends}"));
}

fn longest(longest: &Longest, never: &str, what: &str, after: &str) -> String {
    match longest {
        Longest::Never => never.into(),
        Longest::Most(most) => format!("{what} at most {} {after}", duration(*most)),
        Longest::More(more) => format!("{what} more than {} {after}, or never", duration(*more)),
        Longest::Unbounded(why) => format!("has no time in which it {what} {after}: {why}"),
        Longest::Undecided(why) => format!("when it {what} {after} is not decided: {why}"),
    }
}

/// ` (demo.gen:12)`.
fn place(span: Option<Span>, sources: &SourceMap) -> String {
    span.map_or_else(String::new, |span| {
        let location = sources.location(span);
        format!(" ({}:{})", location.path.display(), location.line)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn activities_of_which_nothing_is_decided_share_a_line() {
        let open = |why: &str| Longest::Undecided(why.into());
        let one = |service: &str, begins, ends| Response { service: service.into(), begins, ends };
        let all = [
            one("a", open("more than 1.5 s"), open("more than 1.5 s")),
            one("b", Longest::Most(5_000_000), open("more than 1.5 s")),
            one("c", open("more than 1.5 s"), open("more than 1.5 s")),
            one("d", open("more than 9 states"), open("more than 9 states")),
        ];
        let mut text = String::new();
        responses(&mut text, &all);
        let lines: Vec<&str> = text.lines().map(str::trim_end).collect();
        assert_eq!(lines.len(), 3, "{text}");
        assert!(lines[0].contains("activity b begins at most 5.000 ms"), "{text}");
        assert_eq!(lines[1], "respond  activities a, c not decided: more than 1.5 s");
        assert!(lines[2].contains("activity d when it begins"), "{text}");
    }
}
