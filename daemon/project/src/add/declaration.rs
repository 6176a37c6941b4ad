//! What is added, as it stands in a description.

use std::str::FromStr;

use genom_description::model::{Component, ServiceKind};

use super::body::Kind;
use super::error::AddError;
use super::place::Block;

/// What is added to a component.
#[derive(Clone, Debug)]
pub enum Addition {
    /// A service.
    Service(Service),
    /// A port.
    Port(Port),
    /// A task.
    Task(Task),
}

/// A service.
#[derive(Clone, Debug)]
pub struct Service {
    /// Its name.
    pub name: String,
    /// Its kind.
    pub kind: ServiceKind,
    /// Inputs, in order.
    pub inputs: Vec<Parameter>,
    /// Outputs, in order.
    pub outputs: Vec<Parameter>,
    /// The task that runs the activity; by default the only one.
    pub task: Option<String>,
    /// Whether a codel validates the inputs.
    pub validate: bool,
    /// Exceptions that it may throw.
    pub throws: Vec<String>,
    /// Services that it interrupts.
    pub interrupts: Vec<String>,
    /// What it does.
    pub doc: Option<String>,
}

/// A port.
#[derive(Clone, Debug)]
pub struct Port {
    /// Whether the component writes it.
    pub out: bool,
    /// Whether it has elements.
    pub multiple: bool,
    /// Name and type.
    pub of: Parameter,
    /// What it tells.
    pub doc: Option<String>,
}

/// A task.
#[derive(Clone, Debug)]
pub struct Task {
    /// Its name.
    pub name: String,
    /// Time between two ticks, in nanoseconds; without it, it runs when there is something to do.
    pub period: Option<u64>,
    /// What it does.
    pub doc: Option<String>,
}

/// `NAME`, `NAME=TYPE` or `NAME=TYPE=DEFAULT`; `TYPE[3]` is an array.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Parameter {
    /// Its name.
    pub name: String,
    /// Its type, with dimensions.
    pub ty: Option<String>,
    /// Its default value.
    pub default: Option<String>,
}

/// The text is no [`Parameter`].
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("expected NAME, NAME=TYPE or NAME=TYPE=DEFAULT, such as goal=double=1.0")]
pub struct ParameterError;

impl FromStr for Parameter {
    type Err = ParameterError;

    fn from_str(text: &str) -> Result<Self, ParameterError> {
        let mut parts = text.splitn(3, '=').map(|part| part.trim().to_owned());
        let name = parts.next().filter(|name| is_name(name)).ok_or(ParameterError)?;
        let (ty, default) = (parts.next(), parts.next());
        if ty.as_ref().is_some_and(String::is_empty) && default.is_none() {
            return Err(ParameterError);
        }
        Ok(Self { name, ty: ty.filter(|ty| !ty.is_empty()), default })
    }
}

impl Parameter {
    /// `double goal[3]`.
    fn declared(&self) -> Result<String, AddError> {
        let ty = self.ty.as_deref().ok_or_else(|| AddError::NoType(self.name.clone()))?;
        let sound = |c: char| c.is_ascii_alphanumeric() || " _:<>,[]".contains(c);
        if !ty.chars().all(sound) {
            return Err(AddError::Word { what: "type", word: ty.to_owned() });
        }
        let (ty, dimensions) = ty.split_at(ty.find('[').unwrap_or(ty.len()));
        Ok(format!("{} {}{dimensions}", ty.trim(), self.name))
    }

    fn default_text(&self) -> String {
        self.default.as_ref().map_or_else(String::new, |value| format!(" = {value}"))
    }
}

/// Whether the word can be a name in a description.
fn is_name(word: &str) -> bool {
    word.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_')
        && word.chars().all(|c| c.is_ascii_alphanumeric() || c == '_')
}

fn named(what: &'static str, word: &str) -> Result<(), AddError> {
    match is_name(word) {
        true => Ok(()),
        false => Err(AddError::Word { what, word: word.to_owned() }),
    }
}

/// `doc "...";`
fn doc(text: Option<&String>) -> Option<(usize, String)> {
    let quoted = text?.replace('\\', "\\\\").replace('"', "\\\"").replace('\n', " ");
    Some((1, format!("doc \"{quoted}\";")))
}

impl Addition {
    pub(super) fn kind(&self) -> Kind {
        match self {
            Self::Service(_) => Kind::Service,
            Self::Port(_) => Kind::Port,
            Self::Task(_) => Kind::Task,
        }
    }

    /// Its lines in the description of `component`.
    pub(super) fn block(&self, component: &Component) -> Result<Block, AddError> {
        match self {
            Self::Service(service) => service.block(component),
            Self::Port(port) => port.block(),
            Self::Task(task) => task.block(component),
        }
    }
}

/// A head with its properties, in one line if it has none.
fn block(head: String, properties: Vec<(usize, String)>) -> Block {
    if properties.is_empty() {
        return vec![(0, format!("{head};"))];
    }
    let mut block = vec![(0, format!("{head} {{"))];
    block.extend(properties);
    block.push((0, "};".to_owned()));
    block
}

impl Port {
    fn block(&self) -> Result<Block, AddError> {
        let direction = if self.out { "out" } else { "in" };
        let multiple = if self.multiple { "multiple " } else { "" };
        if let Some(value) = &self.of.default {
            return Err(AddError::Word { what: "part of a port", word: format!("= {value}") });
        }
        let head = format!("port {multiple}{direction} {}", self.of.declared()?);
        Ok(block(head, doc(self.doc.as_ref()).into_iter().collect()))
    }
}

impl Task {
    fn block(&self, component: &Component) -> Result<Block, AddError> {
        named("name of a task", &self.name)?;
        let codel = format!("{}_{}", component.name, self.name);
        let mut properties: Vec<_> = doc(self.doc.as_ref()).into_iter().collect();
        match self.period {
            Some(period) => {
                properties.push((1, format!("period {};", time(period))));
                properties.push((1, format!("codel<start> {codel}_start() yield main;")));
                properties.push((1, format!("codel<main> {codel}_main() yield pause::main;")));
            }
            None => properties.push((1, format!("codel<start> {codel}_start() yield ether;"))),
        }
        Ok(block(format!("task {}", self.name), properties))
    }
}

/// Nanoseconds in the greatest unit in which they are a whole number, if there is one.
fn time(nanoseconds: u64) -> String {
    match nanoseconds {
        ns if ns.is_multiple_of(1_000_000_000) => format!("{} s", ns / 1_000_000_000),
        ns if ns.is_multiple_of(1_000_000) => format!("{} ms", ns / 1_000_000),
        ns if ns.is_multiple_of(1_000) => format!("{} us", ns / 1_000),
        ns => format!("{} us", ns as f64 / 1e3),
    }
}

impl Service {
    fn block(&self, component: &Component) -> Result<Block, AddError> {
        named("name of a service", &self.name)?;
        let codel = format!("{}_{}", component.name, self.name);
        let (inputs, outputs) = (self.inputs.as_slice(), self.outputs.as_slice());
        let mut properties: Vec<_> = doc(self.doc.as_ref()).into_iter().collect();
        if self.kind == ServiceKind::Activity {
            properties.push((1, format!("task {};", self.task(component)?)));
        }
        if self.validate {
            properties.push((1, format!("validate {codel}_check({});", locals(inputs, &[]))));
        }
        match self.kind {
            ServiceKind::Attribute => {}
            ServiceKind::Function => {
                properties.push((1, format!("codel {codel}({});", locals(inputs, outputs))));
            }
            ServiceKind::Activity => {
                let locals = locals(inputs, outputs);
                // The codel that is written first ends the activity; its author has it go on.
                let start = format!("codel<start> {codel}_start({locals})");
                properties.push((1, format!("{start} yield ether, pause::start;")));
                properties.push((1, format!("codel<stop> {codel}_stop() yield ether;")));
            }
        }
        for (keyword, names) in [("throw", &self.throws), ("interrupt", &self.interrupts)] {
            if !names.is_empty() {
                let scoped =
                    |name: &&String| !name.split("::").all(|part| part.is_empty() || is_name(part));
                if let Some(word) = names.iter().find(scoped) {
                    return Err(AddError::Word { what: "name", word: word.clone() });
                }
                properties.push((1, format!("{keyword} {};", names.join(", "))));
            }
        }
        let keyword = match self.kind {
            ServiceKind::Attribute => "attribute",
            ServiceKind::Function => "function",
            ServiceKind::Activity => "activity",
        };
        let mut list = Vec::new();
        for (direction, parameters) in [("in", inputs), ("out", outputs)] {
            for one in parameters {
                let declared = match (self.kind, &one.ty) {
                    (ServiceKind::Attribute, None) => one.name.clone(),
                    (ServiceKind::Attribute, Some(_)) => {
                        return Err(AddError::Typed(one.name.clone()));
                    }
                    _ => one.declared()?,
                };
                list.push(format!("{direction} {declared}{}", one.default_text()));
            }
        }
        Ok(block(format!("{keyword} {}({})", self.name, list.join(", ")), properties))
    }

    /// The task that runs the activity.
    fn task(&self, component: &Component) -> Result<String, AddError> {
        if let Some(task) = &self.task {
            named("name of a task", task)?;
            return Ok(task.clone());
        }
        let names: Vec<&str> = component.tasks.iter().map(|task| task.name.as_str()).collect();
        match names.as_slice() {
            [only] => Ok((*only).to_owned()),
            [] => Err(AddError::WhichTask("there is none: `genomctl add task` adds one".into())),
            several => Err(AddError::WhichTask(format!("there are: {}", several.join(", ")))),
        }
    }
}

/// Parameters of a codel that are those of its service, whatever the ids have by that name.
fn locals(inputs: &[Parameter], outputs: &[Parameter]) -> String {
    let inputs = inputs.iter().map(|one| format!("local in {}", one.name));
    let outputs = outputs.iter().map(|one| format!("local out {}", one.name));
    inputs.chain(outputs).collect::<Vec<_>>().join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_parameter_has_a_name_and_may_have_type_dimensions_and_default() {
        let read = |text: &str| text.parse::<Parameter>();
        assert_eq!(read("goal=double").unwrap().declared().unwrap(), "double goal");
        let array = read("q = sequence<or::pose, 4>[2][3] = {}").unwrap();
        assert_eq!(array.declared().unwrap(), "sequence<or::pose, 4> q[2][3]");
        assert_eq!(array.default_text(), " = {}");
        assert_eq!(read("speed==0.5").unwrap().default.as_deref(), Some("0.5"));
        assert!(matches!(read("speed").unwrap().declared(), Err(AddError::NoType(_))));
        assert!(matches!(read("a=long; };").unwrap().declared(), Err(AddError::Word { .. })));
        for wrong in ["", "1=long", "a b", "a=", "é=long"] {
            assert_eq!(read(wrong), Err(ParameterError), "{wrong}");
        }
    }

    #[test]
    fn times_have_the_unit_in_which_they_are_whole() {
        let times = [2_000_000_000, 10_000_000, 250_000, 1_500].map(time);
        assert_eq!(times, ["2 s", "10 ms", "250 us", "1.5 us"]);
    }
}
