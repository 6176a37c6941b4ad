//! The sources of a component, and the functions that belong in each.

use std::collections::HashSet;
use std::path::PathBuf;

use genom_description::c_names::event_names;
use genom_description::model::{
    Codel, CodelKind, Component, Owner, Specification, StateIx, TaskIx, Yield,
};
use genom_description_tools::signature;
use genom_types::TypeTable;

use super::{Language, header_name};

/// A source: one for the codels of each task, and one for those that have none.
#[derive(Clone, Debug)]
pub struct Sheet {
    /// Where it belongs, below the project's directory.
    pub path: PathBuf,
    /// What comes before the functions.
    pub opening: String,
    /// The functions that belong in it.
    pub functions: Vec<Wanted>,
}

/// A function that a description asks for.
#[derive(Clone, Debug)]
pub struct Wanted {
    /// Its name.
    pub name: String,
    /// Its declaration, without semicolon.
    pub declaration: String,
    /// The whole function, with a body that goes to the first state that it may return.
    pub text: String,
}

impl Sheet {
    /// The source, with all functions.
    #[must_use]
    pub fn text(&self) -> String {
        let functions = self.functions.iter().map(|function| format!("\n{}", function.text));
        self.opening.clone() + &functions.collect::<String>()
    }
}

/// The sources of a component. With `terse`, nothing is said about a function.
#[must_use]
pub fn sheets(
    spec: &Specification,
    component: &Component,
    language: Language,
    terse: bool,
) -> Vec<Sheet> {
    let mut seen = HashSet::new();
    let mut sheet = |task: Option<TaskIx>| {
        let of_task = task.and_then(|task| component.tasks.get(task));
        let name = match of_task {
            Some(task) => format!("{}_{}_codels", component.name, task.name),
            None => format!("{}_codels", component.name),
        };
        let functions = component
            .codels
            .iter()
            .filter(|codel| !is_standard(component, codel) && task_of(component, codel) == task)
            .filter(|codel| seen.insert(codel.name.clone()))
            .map(|codel| wanted(&spec.types, component, codel, terse))
            .collect();
        Sheet {
            path: PathBuf::from("codels").join(name).with_extension(language.extension()),
            opening: format!("#include \"{}\"\n", header_name(component)),
            functions,
        }
    };
    let mut list = vec![sheet(None)];
    list.extend(component.tasks.places().map(|task| sheet(Some(task))));
    list
}

/// Services of interface `genom` have no codels in the library.
pub(crate) fn is_standard(component: &Component, codel: &Codel) -> bool {
    match codel.owner {
        Owner::Service(service) => component.services.get(service).is_some_and(|s| s.standard),
        Owner::Task(_) => false,
    }
}

/// The task whose source the codel belongs in: that which runs its state.
fn task_of(component: &Component, codel: &Codel) -> Option<TaskIx> {
    match (codel.owner, &codel.kind) {
        (Owner::Task(task), _) => Some(task),
        (Owner::Service(service), CodelKind::Fsm { .. }) => component.services.get(service)?.task,
        _ => None,
    }
}

fn wanted(types: &TypeTable, component: &Component, codel: &Codel, terse: bool) -> Wanted {
    let declaration = signature(types, component, codel);
    let about = if terse { String::new() } else { about(types, component, codel) };
    let broken = declaration.replacen(' ', "\n", 1);
    let returned = returned(component, codel);
    let text = format!("{about}{broken}\n{{\n  /* your code */\n  return {returned};\n}}\n");
    Wanted { name: codel.name.clone(), declaration, text }
}

/// What the function may return first: the first state that it yields, else success.
fn returned(component: &Component, codel: &Codel) -> String {
    let cxx = component.lang == "c++";
    match &codel.kind {
        CodelKind::Fsm { yields, .. } => match yields.first() {
            Some(to) if cxx => format!("{}::{}", component.name, state(component, *to)),
            Some(to) => c_event(component, *to),
            None if cxx => format!("{}::ether", component.name),
            None => format!("{}_ether", component.name),
        },
        _ if cxx => "genom::ok".to_owned(),
        _ => "genom_ok".to_owned(),
    }
}

/// The state that a state-machine codel may yield first: `ether`, `pause::main`.
pub(crate) fn first_yield(component: &Component, codel: &Codel) -> String {
    match &codel.kind {
        CodelKind::Fsm { yields, .. } => yields.first().map(|to| state(component, *to)),
        _ => None,
    }
    .unwrap_or_else(|| "ether".to_owned())
}

/// `main` or `pause::main`.
fn state(component: &Component, to: Yield) -> String {
    let name = component.states.get(to.state).map_or("", String::as_str);
    if to.pause { format!("pause::{name}") } else { name.to_owned() }
}

/// The C name of an event, which differs from the usual one where a codel has that name.
fn c_event(component: &Component, to: Yield) -> String {
    let full = format!("::{}::{}", component.name, state(component, to));
    let named = event_names(component).into_iter().find(|(_, text)| *text == full);
    named.map_or_else(String::new, |(symbol, _)| symbol)
}

/// A comment that says when the function runs, and what it may return.
pub(crate) fn about(types: &TypeTable, component: &Component, codel: &Codel) -> String {
    let (owner, throws) = match codel.owner {
        Owner::Task(task) => {
            let task = component.tasks.get(task);
            task.map(|task| (format!("task {}", task.name), task.throws.as_slice()))
        }
        Owner::Service(service) => component.services.get(service).map(|service| {
            let kind = format!("{:?}", service.kind).to_lowercase();
            (format!("{kind} {}", service.name), service.throws.as_slice())
        }),
    }
    .unwrap_or_default();
    let mut text = match &codel.kind {
        CodelKind::Validate => format!("/* Validates the inputs of {owner}. Returns success"),
        CodelKind::Simple => format!("/* Runs when {owner} is called. Returns success"),
        CodelKind::Fsm { triggers, yields } => {
            let name = |state: &StateIx| component.states.get(*state).cloned().unwrap_or_default();
            let from: Vec<_> = triggers.iter().map(name).collect();
            let to: Vec<_> = yields.iter().map(|to| state(component, *to)).collect();
            let states = if from.len() == 1 { "State" } else { "States" };
            format!(
                "/* {states} {} of {owner}. Returns {}",
                listed(&from, "and"),
                listed(&to, "or")
            )
        }
    };
    let thrown: Vec<_> = throws
        .iter()
        .filter_map(|ty| types.kind(*ty).name())
        .map(|name| name.segments().join("::"))
        .collect();
    if !thrown.is_empty() {
        text.push_str(&format!(", or throws {}", listed(&thrown, "or")));
    }
    text + ". */\n"
}

/// `a`, `a and b`, `a, b and c`.
fn listed(words: &[String], last: &str) -> String {
    match words {
        [] => "nothing".to_owned(),
        [one] => one.clone(),
        [rest @ .., end] => format!("{} {last} {end}", rest.join(", ")),
    }
}
