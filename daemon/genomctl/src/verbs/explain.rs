//! `genomctl explain`: explains the code of a diagnostic. No daemon.

use clap_complete::engine::ArgValueCompleter;
use genom_description::diagnostic::{Explanation, explain, explanations};

use crate::complete::Names;
use crate::failure::Failure;
use crate::session::Session;

/// Explain a code that `check` shows, such as E0301.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// The code; all codes if left out.
    #[arg(add = ArgValueCompleter::from(Names::Codes))]
    code: Option<String>,
}

pub(super) fn run(args: &Args, session: &Session) -> Result<(), Failure> {
    let Some(code) = &args.code else {
        if session.json {
            let codes: Vec<_> = explanations().map(data).collect();
            return session.print(&format!("{}\n", serde_json::json!({ "codes": codes })));
        }
        let line = |one: &Explanation| format!("{}  {}\n", one.code, one.title);
        return session.print(&explanations().map(line).collect::<String>());
    };
    match explain(code) {
        Some(explanation) if session.json => session.print(&format!("{}\n", data(explanation))),
        Some(explanation) => session.print(&render(explanation)),
        None => Err(Failure::usage(
            format!("there is no code `{code}`"),
            "`genomctl explain` lists them",
        )),
    }
}

fn data(explanation: &Explanation) -> serde_json::Value {
    let Explanation { code, title, rule, text, example } = explanation;
    serde_json::json!({
        "code": code, "title": title, "rule": rule, "text": text.trim(), "example": example,
    })
}

fn render(explanation: &Explanation) -> String {
    let Explanation { code, title, rule, text, example } = explanation;
    let rule = if rule.is_empty() { String::new() } else { format!(" (rule {rule})") };
    let example: String = example.lines().map(|line| format!("    {line}\n")).collect();
    format!("{code}: {title}{rule}\n\n{}\n\nFor instance:\n\n{example}", text.trim())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_code_is_explained_with_an_example() {
        for explanation in explanations() {
            let shown = render(explanation);
            assert!(shown.starts_with(explanation.code) && shown.contains("For instance:"));
        }
    }
}
