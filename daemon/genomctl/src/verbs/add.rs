//! `genomctl add`: a service, a port or a task in addition to those of a component. No daemon.

use std::io::Write as _;
use std::path::PathBuf;

use genom_description::diagnostic::first;
use genom_description::diagnostic::render::human;
use genom_description::model::ServiceKind;
use genom_description::{Analysis, Options};
use genom_project::add::{AddError, Addition, Parameter, Port, Service, Task, add};
use genom_project::build::description;
use genom_scenario::duration::nanoseconds;
use serde_json::json;

use crate::failure::Failure;
use crate::reading::{Reading, SHOWN};
use crate::session::Session;
use crate::terminal::coloured_errors;

/// Add a service, a port or a task to a component: to its .gen file, where one would write it, and
/// the codels that it asks for to the sources. What was written stays as it is; with a mistake
/// nothing is changed.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    #[command(subcommand)]
    what: What,
    /// The directory of the component, or its .gen file.
    #[arg(
        long,
        short = 'C',
        global = true,
        default_value = ".",
        value_name = "DIRECTORY|FILE.gen"
    )]
    component: PathBuf,
    #[command(flatten)]
    reading: Reading,
}

#[derive(Debug, clap::Subcommand)]
enum What {
    Service(ServiceArgs),
    Port(PortArgs),
    Task(TaskArgs),
}

/// Add a service.
#[derive(Debug, clap::Args)]
#[command(group(
    clap::ArgGroup::new("kind").required(true).args(["attribute", "function", "activity"])
))]
struct ServiceArgs {
    /// Its name.
    name: String,
    /// It sets and tells members of the ids.
    #[arg(long)]
    attribute: bool,
    /// It runs a codel at once.
    #[arg(long)]
    function: bool,
    /// It runs codels in a task until it ends.
    #[arg(long)]
    activity: bool,
    /// An input: goal=double, goal=double=1.0 with a default; of an attribute the member, speed or
    /// speed==0.5. May be repeated.
    #[arg(long = "in", value_name = "NAME=TYPE[=DEFAULT]")]
    inputs: Vec<Parameter>,
    /// An output; may be repeated.
    #[arg(long = "out", value_name = "NAME=TYPE")]
    outputs: Vec<Parameter>,
    /// The task that runs the activity [default: the only one].
    #[arg(long, conflicts_with_all = ["attribute", "function"])]
    task: Option<String>,
    /// A codel validates the inputs.
    #[arg(long)]
    validate: bool,
    /// An exception that it may throw; may be repeated.
    #[arg(long, value_name = "EXCEPTION")]
    throw: Vec<String>,
    /// A service that it interrupts; may be repeated.
    #[arg(long, value_name = "SERVICE")]
    interrupt: Vec<String>,
    /// What it does.
    #[arg(long, value_name = "TEXT")]
    doc: Option<String>,
}

/// Add a port.
#[derive(Debug, clap::Args)]
struct PortArgs {
    /// Whether the component reads or writes it.
    direction: Direction,
    /// Its name and type: pose=Pose.
    #[arg(value_name = "NAME=TYPE")]
    of: Parameter,
    /// It has elements, which come and go.
    #[arg(long)]
    multiple: bool,
    /// What it tells.
    #[arg(long, value_name = "TEXT")]
    doc: Option<String>,
}

#[derive(Clone, Copy, Debug, clap::ValueEnum)]
enum Direction {
    In,
    Out,
}

/// Add a task.
#[derive(Debug, clap::Args)]
struct TaskArgs {
    /// Its name.
    name: String,
    /// Time between two ticks: 10ms. Without it, the task runs when there is something to do.
    #[arg(long, value_name = "TIME", value_parser = nanoseconds)]
    period: Option<u64>,
    /// What it does.
    #[arg(long, value_name = "TEXT")]
    doc: Option<String>,
}

impl What {
    fn addition(self) -> Addition {
        match self {
            Self::Service(given) => Addition::Service(Service {
                kind: match (given.attribute, given.function) {
                    (true, _) => ServiceKind::Attribute,
                    (_, true) => ServiceKind::Function,
                    _ => ServiceKind::Activity,
                },
                name: given.name,
                inputs: given.inputs,
                outputs: given.outputs,
                task: given.task,
                validate: given.validate,
                throws: given.throw,
                interrupts: given.interrupt,
                doc: given.doc,
            }),
            Self::Port(given) => Addition::Port(Port {
                out: matches!(given.direction, Direction::Out),
                multiple: given.multiple,
                of: given.of,
                doc: given.doc,
            }),
            Self::Task(TaskArgs { name, period, doc }) => {
                Addition::Task(Task { name, period, doc })
            }
        }
    }
}

pub(super) fn run(args: Args, session: &Session) -> Result<(), Failure> {
    let file = match args.component.is_dir() {
        true => description(&args.component)
            .map_err(|error| Failure::usage(error.to_string(), "name the .gen file with -C"))?,
        false => args.component.clone(),
    };
    // `./arm.gen` of the current directory is told as `arm.gen`.
    let file = file.strip_prefix(".").map_or(file.clone(), ToOwned::to_owned);
    let options: Options = args.reading.options();
    let added = add(&file, &options, &args.what.addition()).map_err(refused)?;
    print_diagnostics(&added.analysis)?;
    added.write().map_err(refused)?;
    if session.json {
        let files: Vec<_> = added.files.iter().map(|(path, _)| path).collect();
        let codels: Vec<_> = added
            .functions
            .iter()
            .map(|(name, path)| json!({ "name": name, "source": path }))
            .collect();
        let reply = json!({ "files": files, "codels": codels, "advice": added.advice });
        return session.print(&format!("{reply}\n"));
    }
    let mut text = format!("changed {}\n", file.display());
    for (name, path) in &added.functions {
        text.push_str(&format!("added {name} to {}\n", path.display()));
    }
    for advice in &added.advice {
        text.push_str(&format!("left to you: {advice}\n"));
    }
    session.print(&text)
}

fn print_diagnostics(analysis: &Analysis) -> Result<(), Failure> {
    let (said, rest) = first(&analysis.diagnostics, &analysis.sources, SHOWN);
    let mut told = human(&said, &analysis.sources, coloured_errors());
    if !rest.is_empty() {
        told.push_str(&format!("{rest}\n"));
    }
    std::io::stderr().lock().write_all(told.as_bytes())?;
    Ok(())
}

fn refused(error: AddError) -> Failure {
    let help = match &error {
        AddError::Refused(_) => {
            "nothing was changed; lines are those of the text with the addition"
        }
        _ => "nothing was changed",
    };
    if let AddError::Mistakes(analysis) | AddError::Refused(analysis) = &error
        && let Err(failure) = print_diagnostics(analysis)
    {
        return failure;
    }
    Failure::refused_with("add", error.to_string(), help.to_owned())
}
