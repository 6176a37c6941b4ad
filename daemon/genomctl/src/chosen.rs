//! The context that selects the daemon, for messages.

/// The context that selects the daemon.
#[derive(Clone, Debug)]
pub(crate) struct Chosen {
    name: String,
    /// Names of the other contexts.
    others: Vec<String>,
}

impl std::fmt::Display for Chosen {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "context `{}`", self.name)
    }
}

impl Chosen {
    /// The context `name`, among others.
    pub(crate) fn new(name: String, others: Vec<String>) -> Self {
        Self { name, others }
    }

    /// How to select another daemon.
    pub(crate) fn help(&self) -> String {
        let others = match self.others.as_slice() {
            [] => String::new(),
            others => format!(
                "`genomctl context use NAME` or --context NAME takes another one ({}), ",
                others.join(", ")
            ),
        };
        format!("{self} says where: {others}`genomctl context use` goes back to the usual socket")
    }
}
