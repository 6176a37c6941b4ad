//! `genomctl monitor`: the rules that a component is supervised by, and whether they were broken.

use clap_complete::engine::ArgValueCompleter;
use genom_protocol::{
    Broken, Change, ChangeParameters, Cleared, Component, Kind, Rule, Withheld, routes,
};
use serde_json::json;
use tokio::signal::unix::{SignalKind, signal};

use crate::complete::Names;
use crate::escape;
use crate::failure::Failure;
use crate::session::Session;
use crate::table::Table;
use genom_drawing::units::duration;

/// Show the rules that a component is supervised by, and how often each was broken.
///
/// Rules are written into the configuration as [[component.supervision]]; docs/supervision.md.
/// `genomctl verify FILE --config FILE` says of each whether it can be broken at all.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Exit status: 0 whether rules were broken or not.")]
pub(crate) struct Args {
    /// Instance name of the component.
    #[arg(add = ArgValueCompleter::from(Names::Components))]
    component: String,
    /// Print each violation as it comes, until Ctrl-C: of each rule at most one in a second.
    #[arg(short, long, conflicts_with = "clear")]
    follow: bool,
    /// Give the service manager signs of life again that a rule has withheld (`withhold`).
    #[arg(long)]
    clear: bool,
}

pub(super) async fn run(args: Args, session: &Session) -> Result<(), Failure> {
    if args.clear {
        let reply = session.ask(routes::clear_withheld(&args.component)).await?;
        return session.show(&reply, |cleared: &Cleared| match &cleared.was {
            Some(why) => format!("signs of life are given again; {}\n", escape::line(why)),
            None => format!("no signs of life were withheld because of {}\n", args.component),
        });
    }
    // Opened before the rules are read, so that no violation is missed.
    let only = ChangeParameters { only: Some("supervision_violated".to_owned()) };
    let events = routes::events().with(&only);
    let mut violations = match args.follow {
        true => Some(session.client.stream(&events).await?),
        false => None,
    };
    let mut interrupt = signal(SignalKind::interrupt())?;
    let component = find(session, &args.component).await?;
    let withheld = session.ask(routes::withheld()).await?.content;
    let told = withheld.withheld.iter().find(|one| one.component == component.name);
    if session.json {
        let data = json!({
            "component": component.name,
            "rules": component.supervision,
            "withheld": told.map(|one| one.why.clone()),
        });
        session.print(&format!("{data}\n"))?;
    } else {
        session.print(&text(&component, &withheld, session))?;
    }
    while let Some(stream) = &mut violations {
        let event = tokio::select! {
            event = stream.next() => event?,
            _ = interrupt.recv() => return Ok(()),
        };
        let Some(event) = event else { return Err(session.client.lost()) };
        let Ok(change) = serde_json::from_str::<Change>(&event.data) else { continue };
        if let Some(line) = violation(&change, &component.name) {
            session.print(&if session.json { format!("{}\n", event.data) } else { line })?;
        }
    }
    Ok(())
}

async fn find(session: &Session, name: &str) -> Result<Component, Failure> {
    let all = session.ask(routes::components()).await?.content.components;
    match all.into_iter().find(|component| component.name == name) {
        Some(component) => Ok(component),
        None => {
            // The daemon says what was probably meant.
            session.ask(routes::component(name)).await?;
            Err(Failure::usage(format!("{name} is not listed"), "try again"))
        }
    }
}

fn text(component: &Component, withheld: &Withheld, session: &Session) -> String {
    let (name, rules) = (&component.name, &component.supervision);
    let mut text = match rules.is_empty() {
        true => format!("{name} is supervised by no rule\n"),
        false => table(rules).text(session.terminal),
    };
    for (number, rule) in (1..).zip(rules) {
        if let Some(last) = &rule.last {
            let activity = last.activity.map_or_else(String::new, |id| format!(", activity {id}"));
            let what = escape::line(&last.what);
            text.push_str(&format!("rule {number}: {what}{activity}\n"));
        }
    }
    for one in &withheld.withheld {
        let why = escape::line(&one.why);
        let of = &one.component;
        text.push_str(&format!(
            "the service manager gets no sign of life: {why}; `genomctl monitor {of} --clear`\n"
        ));
    }
    text
}

fn table(rules: &[Rule]) -> Table {
    let row = |(number, rule): (usize, &Rule)| {
        let last = rule.last.as_ref();
        let dash = || "-".to_owned();
        let of = |value: fn(&Broken) -> Option<u64>| {
            let value = last.and_then(value);
            value.map_or_else(dash, |value| match rule.kind {
                Kind::Alive => value.to_string(),
                _ => duration(value),
            })
        };
        vec![
            number.to_string(),
            rule.kind.name().to_owned(),
            match rule.violations {
                0 => "never".to_owned(),
                count => count.to_string(),
            },
            last.map_or_else(dash, |last| date(last.unix_ms)),
            of(|last| last.value),
            of(|last| last.bound),
            rule.rule.clone(),
            rule.reactions.join(", "),
        ]
    };
    let rows = (1..).zip(rules).map(row).collect();
    let header = vec!["RULE", "KIND", "BROKEN", "LAST", "VALUE", "BOUND", "WHEN", "REACTION"];
    Table { header, rows }
}

/// The time of day in UTC: `14:03:07.250`.
fn date(unix_ms: u64) -> String {
    let (ms, seconds) = (unix_ms % 1000, unix_ms / 1000);
    let (hours, minutes) = (seconds / 3600 % 24, seconds / 60 % 60);
    format!("{hours:02}:{minutes:02}:{:02}.{ms:03}Z", seconds % 60)
}

/// A violation by this component as a line.
fn violation(change: &Change, of: &str) -> Option<String> {
    match change {
        Change::SupervisionViolated { component, index, what, violations, .. }
            if component == of =>
        {
            let number = index + 1;
            let line = format!("rule {number}, broken {violations} times: {what}");
            Some(escape::line(&line) + "\n")
        }
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use expect_test::expect;

    use super::*;

    #[test]
    fn a_rule_is_one_line_with_what_was_measured_and_its_bound() {
        let rules = serde_json::from_value(json!([
            {
                "rule": "codel demo_goto takes more than 2 ms", "kind": "deadline",
                "reactions": ["event"], "violations": 3,
                "last": {
                    "what": "codel demo_goto of goto took 2.50 ms", "unix_ms": 45_296_789,
                    "activity": 4, "value": 2_500_000, "bound": 2_000_000,
                },
            },
            {
                "rule": "this does not hold: run(goto)", "kind": "formula",
                "reactions": ["log"], "violations": 0,
            },
            {
                "rule": "task main misses 3 ticks within 1 s", "kind": "alive",
                "reactions": ["interrupt", "fire demo/emergency"], "violations": 1,
                "last": {"what": "task main missed 4 ticks", "unix_ms": 0, "value": 4, "bound": 3},
            },
        ]));
        let rules: Vec<Rule> = rules.unwrap();
        expect![[r#"
            RULE  KIND      BROKEN  LAST           VALUE     BOUND     WHEN                                  REACTION
            1     deadline  3       12:34:56.789Z  2.500 ms  2.000 ms  codel demo_goto takes more than 2 ms  event
            2     formula   never   -              -         -         this does not hold: run(goto)         log
            3     alive     1       00:00:00.000Z  4         3         task main misses 3 ticks within 1 s   interrupt, fire demo/emergency
        "#]]
        .assert_eq(&table(&rules).text(crate::terminal::Terminal::default()));
    }
}
