//! A run with dates as text: a column for each task, service and client, in which what repeats is
//! shown once.

use std::fmt::Write as _;

use genom_description::model::Span;
use genom_formal::{Dated, TaskReport, duration};

/// Steps shown, at most: the last ones.
const MOST: usize = 24;

/// The run in which a task is late. `place` says where something is declared.
pub(crate) fn late(task: &TaskReport, place: impl Fn(Option<Span>) -> String) -> String {
    columns(&folded(task), place)
}

/// A run. `place` says where something is declared.
pub(crate) fn run(run: &[Dated], place: impl Fn(Option<Span>) -> String) -> String {
    columns(&run.iter().map(Shown::Step).collect::<Vec<_>>(), place)
}

fn columns(shown: &[Shown<'_>], place: impl Fn(Option<Span>) -> String) -> String {
    let left_out = shown.len().saturating_sub(MOST);
    let shown = &shown[left_out..];
    let mut starts: Vec<(&str, usize)> = Vec::new();
    for step in shown.iter().filter_map(Shown::step) {
        let (who, _) = whose(step);
        if !starts.iter().any(|(known, _)| *known == who) {
            let next = |(name, start): &(&str, usize)| start + name.len().max(6) + 2;
            starts.push((who, starts.last().map_or(0, next)));
        }
    }
    let mut text = String::new();
    let mut row = |date: &str, start: usize, what: &str| {
        let line = format!("  {date:>12}  {:start$}{what}", "");
        let _ = writeln!(text, "{}", line.trim_end());
    };
    let heads = starts
        .iter()
        .fold(String::new(), |heads, (who, start)| format!("{heads:start$}{who}", start = *start));
    row("", 0, &heads);
    if left_out > 0 {
        row("...", 0, &format!("{left_out} steps before"));
    }
    for one in shown {
        match one {
            Shown::Step(step) => {
                let (who, what) = whose(step);
                let start = starts.iter().find(|(known, _)| *known == who);
                let start = start.map_or(0, |(_, start)| *start);
                let what = format!("{what}{}", place(step.line.span));
                row(&duration(step.date), start, &what);
            }
            Shown::Again { until } => {
                let again = format!("the same at its ticks up to {}", duration(*until));
                row("...", 0, &again);
            }
        }
    }
    text
}

/// What is shown of a run.
enum Shown<'a> {
    Step(&'a Dated),
    /// The steps since the last tick come again, with the ticks up to this date.
    Again {
        until: u64,
    },
}

impl<'a> Shown<'a> {
    fn step(&self) -> Option<&'a Dated> {
        match self {
            Self::Step(step) => Some(step),
            Self::Again { .. } => None,
        }
    }
}

/// The column of a step, and what is written there. Activities are in the column of their task.
fn whose(step: &Dated) -> (&str, String) {
    match step.line.who.split_once(": ") {
        Some((task, activity)) => (task, format!("{activity}: {}", step.line.what)),
        None => (&step.line.who, step.line.what.clone()),
    }
}

/// The run, in which of periods of the task that are alike only the first is left.
fn folded(task: &TaskReport) -> Vec<Shown<'_>> {
    let run = task.overrun.as_slice();
    let is_tick = |step: &&Dated| step.line.who == task.name && step.line.what == "tick";
    let mut ticks: Vec<u64> = run.iter().filter(is_tick).map(|step| step.date).collect();
    // Two are at one date if the second is late by no time.
    ticks.dedup();
    // The steps from one tick on to those before the next: all that has a date between.
    let place = |date: u64| run.partition_point(|step| step.date < date);
    let periods: Vec<&[Dated]> = ticks
        .iter()
        .enumerate()
        .map(|(at, date)| {
            let end = ticks.get(at + 1).map_or(run.len(), |next| place(*next));
            &run[place(*date)..end]
        })
        .collect();
    let first = ticks.first().map_or(run.len(), |date| place(*date));
    let mut shown: Vec<Shown<'_>> = run[..first].iter().map(Shown::Step).collect();
    let mut at = 0;
    while let Some(period) = periods.get(at) {
        shown.extend(period.iter().map(Shown::Step));
        let same = periods[at + 1..].iter().take_while(|other| are_alike(period, other)).count();
        if same > 0 {
            shown.push(Shown::Again { until: ticks[at + same] });
        }
        at += same + 1;
    }
    shown
}

/// Whether the same steps come at the same times after the first one.
fn are_alike(period: &[Dated], other: &[Dated]) -> bool {
    let since = |all: &[Dated], step: &Dated| step.date - all.first().map_or(0, |first| first.date);
    period.len() == other.len()
        && period
            .iter()
            .zip(other)
            .all(|(a, b)| a.line == b.line && since(period, a) == since(other, b))
}
