//! `genomctl reference`: prints docs/cli.md, from the definitions of `--help`.

use crate::failure::Failure;
use crate::session::Session;

/// Print the reference of genomctl in Markdown: the help of every verb.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {}

/// Width of the page in columns, whatever the terminal.
const WIDTH: usize = 100;

pub(super) fn run(_: &Args, session: &Session, genomctl: clap::Command) -> Result<(), Failure> {
    let cli = genomctl.term_width(WIDTH);
    let mut verbs = String::new();
    let mut whole = cli.clone();
    for verb in cli.get_subcommands().filter(|verb| !verb.is_hide_set()) {
        let name = verb.get_name();
        // Without the options common to all verbs, which are listed at the top.
        let mut verb = verb.clone().term_width(WIDTH).bin_name(format!("genomctl {name}"));
        verb = verb.disable_help_flag(true);
        verbs.push_str(&format!("\n## {name}\n\n```text\n{}\n```\n", trimmed(&mut verb)));
    }
    session.print(&format!("# genomctl\n\n```text\n{}\n```\n{verbs}", trimmed(&mut whole)))
}

fn trimmed(command: &mut clap::Command) -> String {
    let help = command.render_long_help().to_string();
    let lines: Vec<&str> = help.trim().lines().map(str::trim_end).collect();
    lines.join("\n")
}
