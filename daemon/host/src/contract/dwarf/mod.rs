//! The debug information of a C or C++ library, compared with a component.

mod compare;
mod info;
mod node;

use genom_description::model::Span;
use genom_runtime::plan::Plan;
use genom_types::TypeId;

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
    let types = &plan.specification().types;
    // `struct comp_X_detail` of genom3.md 5.4.
    let throws = model.throws.iter().filter(|id| !types.members(**id).is_empty());
    let throws: Vec<(TypeId, String)> = throws.map(|id| (*id, types.c_name(*id))).collect();
    let details: Vec<&str> = throws.iter().map(|(_, detail)| detail.as_str()).collect();
    let found = info.find(&names, &details);
    let mut comparison = Comparison::new(&info, plan);
    let (mut compared, mut differences) = (0, Vec::new());
    for codel in &model.codels {
        let Some(function) = found.functions.get(codel.name.as_str()) else { continue };
        compared += 1;
        if let Err(why) = comparison.codel(codel, function) {
            differences.push(Difference {
                subject: format!("codel `{}`", codel.name),
                place: locate(codel.span),
                why,
                description: declare::codel(model, types, codel),
                library: info.declaration(&codel.name, function),
            });
        }
    }
    for (id, detail) in &throws {
        let Some(&at) = found.typedefs.get(detail.as_str()) else { continue };
        if let Err(why) = comparison.memory(*id, Some(at)) {
            differences.push(Difference {
                subject: format!("exception `{}`", types.spelling(*id)),
                place: locate(model.span),
                why,
                description: declare::members(types, *id),
                library: info.layout(at),
            });
        }
    }
    (compared > 0).then_some((compared, differences))
}
