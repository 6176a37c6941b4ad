//! The components that files describe, as plans.

use std::path::PathBuf;
use std::sync::Arc;

use genom_description::source::SourceMap;
use genom_runtime::Plan;

use crate::failure::Failure;
use crate::reading::Reading;

/// Files with descriptions, and which of their components are meant.
#[derive(Debug, clap::Args)]
pub(in crate::verbs) struct Described {
    /// The .gen files, read in order as one specification.
    #[arg(required = true)]
    files: Vec<PathBuf>,
    /// One component [default: all].
    #[arg(long, value_name = "NAME")]
    component: Option<String>,
    #[command(flatten)]
    reading: Reading,
}

impl Described {
    /// Reads the files, which must have no errors.
    pub(in crate::verbs) fn plans(&self) -> Result<(Vec<Arc<Plan>>, SourceMap), Failure> {
        let analysis = self.reading.read_sound(&self.files)?;
        let specification = Arc::new(analysis.specification);
        let names = specification.components.iter().map(|component| component.name.as_str());
        let wanted = |name: &str| self.component.as_deref().is_none_or(|wanted| wanted == name);
        let places: Vec<usize> =
            names.clone().enumerate().filter(|(_, name)| wanted(name)).map(|(at, _)| at).collect();
        if places.is_empty() {
            let known: Vec<_> = names.map(|name| format!("`{name}`")).collect();
            let message = self.component.as_ref().map_or_else(
                || "these files describe no component".to_owned(),
                |name| format!("there is no component `{name}`"),
            );
            return Err(Failure::usage(message, format!("they describe: {}", known.join(", "))));
        }
        let plan = |place: usize| match Plan::new(&specification, place) {
            Ok(plan) => Ok(Arc::new(plan)),
            Err(error) => Err(Failure::refused("plan", error.to_string())),
        };
        let plans = places.into_iter().map(plan).collect::<Result<_, _>>()?;
        Ok((plans, analysis.sources))
    }
}
