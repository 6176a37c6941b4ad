//! The debug information of a C or C++ library, compared with a component.

mod classes;
mod compare;
mod info;
mod node;

use genom_description::model::{Codel, Span};
use genom_description::tools;
use genom_runtime::plan::Plan;
use genom_types::TypeId;

use super::{Difference, declare};
use crate::cxx::{self, Function};
use crate::library::Library;
use compare::Comparison;
use info::{DebugInfo, Wanted};

/// Compares every codel that the debug information tells about; tells how many, and what differs.
/// `None` without readable debug information.
pub(super) fn compare(
    library: &Library,
    plan: &Plan,
    locate: &dyn Fn(Span) -> String,
) -> Option<(usize, Vec<Difference>)> {
    let model = plan.component();
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
    let in_cxx = model.lang == "c++";
    let detail = |id: TypeId| match in_cxx {
        true => tools::declaration(types, id, "").trim_end().to_owned(),
        false => types.c_name(id),
    };
    let throws: Vec<(TypeId, String)> = throws.map(|id| (*id, detail(*id))).collect();
    let symbol = |codel: &Codel| match in_cxx {
        true => match cxx::find(library, model, types, codel) {
            Function::Found(symbol) => symbol,
            // What is missing is told elsewhere.
            _ => String::new(),
        },
        false => codel.name.clone(),
    };
    let symbols: Vec<String> = model.codels.iter().map(symbol).collect();
    let found = info.find(&Wanted {
        functions: symbols.iter().map(String::as_str).collect(),
        types: throws.iter().map(|(_, detail)| detail.as_str()).collect(),
    });
    let mut comparison = Comparison::new(&info, plan);
    let (mut compared, mut differences) = (0, Vec::new());
    for (codel, symbol) in model.codels.iter().zip(&symbols) {
        let Some(function) = found.functions.get(symbol.as_str()) else { continue };
        compared += 1;
        if let Err(why) = comparison.codel(codel, function) {
            differences.push(Difference {
                subject: format!("codel `{}`", codel.name),
                place: locate(codel.span),
                why,
                description: match in_cxx {
                    true => tools::prototype(types, model, codel),
                    false => declare::codel(model, types, codel),
                },
                library: info.declaration(&codel.name, function),
            });
        }
    }
    for (id, detail) in &throws {
        let Some(&at) = found.types.get(detail.as_str()) else { continue };
        if let Err(why) = comparison.memory(*id, Some(at)) {
            differences.push(Difference {
                subject: format!("exception `{}`", types.spelling(*id)),
                place: locate(model.span),
                why,
                description: match in_cxx {
                    true => declare::members_in_cxx(types, *id),
                    false => declare::members(types, *id),
                },
                library: info.layout(at),
            });
        }
    }
    (compared > 0).then_some((compared, differences))
}
