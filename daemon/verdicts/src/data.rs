//! What was found, as JSON.

use genom_description::model::Span;
use genom_description::source::SourceMap;
use genom_formal::{Dated, Finding, Found, Line, TaskReport, Ticks, Verdict};
use serde_json::{Value, json};

pub(crate) fn data(found: &Found, sources: &SourceMap) -> Value {
    let verdicts = found.report.verdicts.iter();
    let verdicts: Vec<Value> = verdicts
        .map(|(property, verdict)| match verdict {
            Verdict::Holds => json!({ "property": property.name(), "verdict": "holds" }),
            Verdict::Undecided(why) => {
                json!({ "property": property.name(), "verdict": "undecided", "why": why })
            }
            Verdict::Violated(all) => {
                let all: Vec<Value> = all.iter().map(|one| finding(one, sources)).collect();
                json!({ "property": property.name(), "verdict": "violated", "findings": all })
            }
        })
        .collect();
    let (tasks, undecided) = match &found.ticks {
        Ticks::Unasked => (Value::Null, Value::Null),
        Ticks::Unknown(why) => (Value::Null, json!(why)),
        Ticks::Seen(times) => {
            let all: Vec<Value> = times.tasks.iter().map(|one| task(one, sources)).collect();
            (json!(all), json!(times.limit().map(|limit| limit.to_string())))
        }
    };
    json!({
        "component": found.system.plan().component().name,
        "verdicts": verdicts,
        "states": found.report.explored.as_ref().map(|explored| explored.len()),
        "tasks": tasks,
        "times_undecided": undecided,
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
