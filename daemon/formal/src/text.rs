//! What was found, as text.

use std::fmt::Write as _;

use genom_description::model::Span;
use genom_description::source::SourceMap;

use crate::found::{Found, Ticks};
use crate::property::{Finding, Verdict};
use crate::timed::{Dated, Longest, Response, TaskReport};

/// Steps shown at the end of a run with dates.
const LAST: usize = 20;

/// What was found, for people; with places in the description.
#[must_use]
pub fn text(found: &Found, sources: &SourceMap) -> String {
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
            times.responses.iter().for_each(|one| response(&mut text, one));
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
    text
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
            let from = task.overrun.len().saturating_sub(LAST);
            if from > 0 {
                let _ = writeln!(text, "    {from} steps before");
            }
            task.overrun[from..].iter().for_each(|one| dated(text, one, sources));
            let _ = writeln!(text, "    {} is still at work at its tick", task.name);
            for (codel, below) in &task.needed {
                let below = duration(*below);
                let _ = writeln!(text, "    holds if {codel} takes less than {below}");
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

fn dated(text: &mut String, dated: &Dated, sources: &SourceMap) {
    let line = &dated.line;
    let at = place(line.span, sources);
    let _ = writeln!(text, "  {:>12}  {}: {}{at}", duration(dated.date), line.who, line.what);
}

/// A time in nanoseconds, in milliseconds.
pub(crate) fn duration(ns: u64) -> String {
    format!("{}.{:03} ms", ns / 1_000_000, ns / 1_000 % 1_000)
}

/// ` (demo.gen:12)`.
fn place(span: Option<Span>, sources: &SourceMap) -> String {
    span.map_or_else(String::new, |span| {
        let location = sources.location(span);
        format!(" ({}:{})", location.path.display(), location.line)
    })
}
