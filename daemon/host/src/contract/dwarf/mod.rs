//! The debug information of a C or C++ library, compared with a component.

mod compare;
mod info;
mod node;

use genom_description::model::Span;
use genom_runtime::plan::Plan;

use super::{Difference, declare};
use crate::library::Library;
use compare::Comparison;
use info::DebugInfo;

/// Compares every codel that the debug information tells about; tells how many, and what differs.
/// `None` without readable debug information.
pub(super) fn compare(
    library: &Library,
    plan: &Plan,
    locate: &dyn Fn(Span) -> String,
) -> Option<(usize, Vec<Difference>)> {
    let model = plan.component();
    let names: Vec<&str> = model.codels.iter().map(|codel| codel.name.as_str()).collect();
    let info = match DebugInfo::new(library.bytes()) {
        Ok(info) => info?,
        Err(why) => {
            tracing::warn!("{}: debug information: {why}", library.path().display());
            return None;
        }
    };
    let functions = info.functions(&names);
    let mut comparison = Comparison::new(&info, plan);
    let (mut compared, mut differences) = (0, Vec::new());
    for codel in &model.codels {
        let Some(function) = functions.get(codel.name.as_str()) else { continue };
        compared += 1;
        if let Err(why) = comparison.codel(codel, function) {
            differences.push(Difference {
                subject: format!("codel `{}`", codel.name),
                place: locate(codel.span),
                why,
                description: declare::codel(model, &plan.specification().types, codel),
                library: info.declaration(&codel.name, function),
            });
        }
    }
    (compared > 0).then_some((compared, differences))
}
