//! What is asked of `genomctl schedule`.

use genom_verdicts::Subject;

use super::super::verify::{Described, Given, most};

/// Tell how long the cycles of tasks may take: which codels, what each may wait for, and what would
/// have to be shorter.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
The bounds are safe for any number of requests, and found at once; exact ones are found by \
`genomctl verify --property overrun`. docs/verify.md has the formulas, and what is assumed.

Exit status: 0 all tasks are in time; 1 one may not be; 4 none may be late, but one has no bound.")]
pub(crate) struct Args {
    #[command(flatten)]
    pub(super) described: Described,
    /// All components of the daemon, or of a deployment file (TOML), on the processors of one
    /// machine, with the priorities and processors that are configured.
    #[arg(long)]
    pub(super) all: bool,
    #[command(flatten)]
    pub(super) given: Given,
    /// Processors that the tasks share, by priority [default: one for each thread; with --all those
    /// of this machine].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=1024))]
    pub(super) processors: Option<u64>,
    /// How late cycles begin, in milliseconds: `max` of lateness in `genomctl stats`.
    #[arg(long, value_name = "TIME", value_parser = most, default_value = "0")]
    pub(super) lateness: u64,
    /// Requests that clients make at the same time [default: one of each service].
    #[arg(long, value_name = "N")]
    pub(super) requests: Option<usize>,
    /// Activities of one service that there are at the same time.
    #[arg(long, value_name = "N", default_value_t = 2)]
    pub(super) instances: usize,
}

/// How late cycles of a component begin: what is given, and no less than what was measured.
pub(super) fn lateness(args: &Args, subject: &Subject) -> u64 {
    let measured = subject.measured.iter().flat_map(|statistics| &statistics.tasks);
    measured.map(|task| task.lateness.max_ns).chain([args.lateness]).max().unwrap_or(0)
}
