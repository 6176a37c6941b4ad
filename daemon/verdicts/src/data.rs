//! What was found, as JSON.

use genom_description::model::Span;
use genom_description::source::SourceMap;
use genom_formal::{Dated, Finding, Line, Longest, Response, TaskReport, Verdict};
use serde_json::{Value, json};

use crate::found::{Found, Ticks};

pub(crate) fn data(found: &Found, sources: &SourceMap) -> Value {
    let verdicts = found.report.verdicts.iter();
    let verdicts = verdicts.map(|(one, is)| verdict("property", one.name(), is, sources));
    let verdicts: Vec<Value> = verdicts.collect();
    let formulas = found.report.formulas.iter();
    let formulas = formulas.map(|(one, is)| verdict("formula", &one.to_string(), is, sources));
    let formulas: Vec<Value> = formulas.collect();
    let responses = match &found.ticks {
        Ticks::Seen(times) => times.responses.iter().map(response).collect(),
        Ticks::Unknown(..) | Ticks::Unasked => Vec::new(),
    };
    let (tasks, undecided) = match &found.ticks {
        Ticks::Unasked => (Value::Null, Value::Null),
        Ticks::Unknown(_, why) => (Value::Null, json!(why)),
        Ticks::Seen(times) => {
            let all: Vec<Value> = times.tasks.iter().map(|one| task(one, sources)).collect();
            (json!(all), json!(times.limit().map(|limit| limit.to_string())))
        }
    };
    let bounds = found.system.bounds();
    json!({
        "component": found.system.plan().component().name,
        "assumed": {
            "requests": bounds.requests, "activities": bounds.instances,
            "aborts": bounds.abort, "events": bounds.fire, "shutdown": bounds.kill,
        },
        "verdicts": verdicts,
        "formulas": formulas,
        "states": found.report.explored.as_ref().map(|explored| explored.states),
        "tasks": tasks,
        "responses": responses,
        "times_undecided": undecided,
    })
}

/// Whether a property or a formula, by its name, holds.
fn verdict(kind: &str, name: &str, verdict: &Verdict, sources: &SourceMap) -> Value {
    match verdict {
        Verdict::Holds => json!({ kind: name, "verdict": "holds" }),
        Verdict::Undecided(why) => json!({ kind: name, "verdict": "undecided", "why": why }),
        Verdict::Violated(all) => {
            let all: Vec<Value> = all.iter().map(|one| finding(one, sources)).collect();
            json!({ kind: name, "verdict": "violated", "findings": all })
        }
    }
}

fn response(response: &Response) -> Value {
    let one = |longest: &Longest| match longest {
        Longest::Never => json!({ "verdict": "never" }),
        Longest::Most(most) => json!({ "verdict": "bounded", "most_ns": most }),
        Longest::More(more) => json!({ "verdict": "unbounded", "above_ns": more }),
        Longest::Unbounded(why) => json!({ "verdict": "unbounded", "why": why }),
        Longest::Undecided(why) => json!({ "verdict": "undecided", "why": why }),
    };
    json!({
        "service": response.service,
        "begins": one(&response.begins),
        "ends": one(&response.ends),
    })
}

fn finding(finding: &Finding, sources: &SourceMap) -> Value {
    let run: Vec<Value> = finding.run.iter().map(|one| line(one, sources)).collect();
    json!({ "what": finding.what, "where": place(finding.span, sources), "run": run })
}

fn task(task: &TaskReport, sources: &SourceMap) -> Value {
    let dated = |Dated { date, line }: &Dated| {
        json!({
            "who": line.who, "what": line.what, "where": place(line.span, sources),
            "date_ns": date,
        })
    };
    let overrun: Vec<Value> = task.overrun.iter().map(dated).collect();
    json!({
        "task": task.name,
        "period_ns": task.period,
        "response_ns": task.response,
        "overrun": overrun,
        "spent": task.spent.iter().map(|spent| json!({
            "codel": spent.codel, "waits_for": spent.awaited, "ns": spent.ns,
        })).collect::<Vec<_>>(),
        "needed": task.needed.iter().map(|(codel, below)| json!({
            "codel": codel, "below_ns": below,
        })).collect::<Vec<_>>(),
    })
}

pub(crate) fn line(line: &Line, sources: &SourceMap) -> Value {
    json!({ "who": line.who, "what": line.what, "where": place(line.span, sources) })
}

fn place(span: Option<Span>, sources: &SourceMap) -> Value {
    span.map_or(Value::Null, |span| {
        let location = sources.location(span);
        json!({ "file": location.path, "line": location.line })
    })
}
