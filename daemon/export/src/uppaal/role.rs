//! A role: the steps that some part of the component takes, and the parts that do.

use std::fmt::Write as _;

use crate::xml::{self, Edge, Place};

/// A template with its processes.
pub(super) struct Role {
    name: &'static str,
    parameters: &'static str,
    invariant: String,
    /// Assignments of the only step of the location in which it begins, if it begins in one of its own:
    /// before anything else happens.
    first: Option<String>,
    steps: Vec<Step>,
    /// Names and arguments.
    processes: Vec<(String, String)>,
}

/// A step, from the location of its role to the same.
#[derive(Default)]
pub(super) struct Step {
    /// Parameters that any values are taken for.
    pub(super) select: String,
    pub(super) guard: String,
    /// No time passes while it is possible.
    pub(super) urgent: bool,
    pub(super) assign: String,
}

impl Step {
    /// A step that may be taken, or not.
    pub(super) fn new(guard: &str, assign: &str) -> Self {
        Self { guard: guard.into(), assign: assign.into(), ..Self::default() }
    }

    /// One that the runtime takes at once.
    pub(super) fn at_once(guard: &str, assign: &str) -> Self {
        Self { urgent: true, ..Self::new(guard, assign) }
    }

    /// The same, for any values of these.
    pub(super) fn any(self, select: impl Into<String>) -> Self {
        Self { select: select.into(), ..self }
    }
}

impl Role {
    /// A role of which there is one for each of some values.
    pub(super) fn new(name: &'static str, parameters: &'static str, steps: Vec<Step>) -> Self {
        let (invariant, processes) = (String::new(), Vec::new());
        Self { name, parameters, invariant, first: None, steps, processes }
    }

    /// One of which there is one.
    pub(super) fn only(name: &'static str, steps: Vec<Step>) -> Self {
        let mut role = Self::new(name, "", steps);
        role.processes.push((name.into(), String::new()));
        role
    }

    pub(super) fn within(mut self, invariant: String) -> Self {
        self.invariant = invariant;
        self
    }

    pub(super) fn beginning(mut self, first: String) -> Self {
        self.first = Some(first);
        self
    }

    pub(super) fn of(mut self, processes: impl IntoIterator<Item = (String, String)>) -> Self {
        self.processes.extend(processes);
        self
    }

    /// Whether the component has such a part.
    pub(super) fn is_there(&self) -> bool {
        !self.processes.is_empty()
    }

    /// Names of its processes.
    pub(super) fn names(&self) -> impl Iterator<Item = &str> {
        self.processes.iter().map(|(name, _)| name.as_str())
    }

    /// How its processes are made of the template.
    pub(super) fn made(&self) -> String {
        let parameterised = self.processes.iter().filter(|_| !self.parameters.is_empty());
        let one = |(name, given): &(String, String)| format!("{name} = {}({given});\n", self.name);
        parameterised.map(one).collect()
    }

    /// The template.
    pub(super) fn template(&self) -> String {
        let mut text = format!("<template><name>{}</name>", self.name);
        if !self.parameters.is_empty() {
            let _ = write!(text, "<parameter>{}</parameter>", xml::escaped(self.parameters));
        }
        text.push('\n');
        let id = self.name.to_lowercase();
        let before = format!("{id}_before");
        if self.first.is_some() {
            let kind = "committed";
            xml::place(&mut text, &Place { id: &before, kind, ..Place::default() });
        }
        let invariant = &self.invariant;
        xml::place(&mut text, &Place { id: &id, invariant, ..Place::default() });
        let init = if self.first.is_some() { &before } else { &id };
        let _ = writeln!(text, "<init ref=\"{init}\"/>");
        if let Some(assign) = &self.first {
            xml::edge(&mut text, &Edge { from: &before, to: &id, assign, ..Edge::default() });
        }
        for Step { select, guard, urgent, assign } in &self.steps {
            let sync = if *urgent { "now!" } else { "" };
            let (from, to) = (id.as_str(), id.as_str());
            let comment = "";
            xml::edge(&mut text, &Edge { from, to, select, guard, sync, assign, comment });
        }
        text.push_str("</template>\n");
        text
    }
}
