//! Compares the debug information of a C or C++ library with a component.

mod classes;
mod compare;
mod untold;

use genom_description::model::{Codel, Component, Owner, Span};
use genom_description_tools as tools;
use genom_elf::Sections;
use genom_elf::debug::{DebugInfo, Wanted};
use genom_runtime::plan::Plan;
use genom_types::TypeId;

use super::declare;
use super::difference::Difference;
use crate::cxx::{self, Function};
use crate::library::Library;
use compare::Comparison;
pub(super) use untold::Untold;

/// Result of the comparison.
pub(super) struct Compared {
    /// Number of codels that were compared.
    pub(super) codels: usize,
    /// The differences.
    pub(super) differences: Vec<Difference>,
    /// Why other codels were not compared.
    pub(super) unchecked: Option<String>,
}

/// Compares every codel that has debug information.
///
/// # Errors
/// No codel has debug information.
pub(super) fn compare(
    library: &Library,
    plan: &Plan,
    locate: &dyn Fn(Span) -> String,
) -> Result<Compared, Untold> {
    let model = plan.component();
    let sections = Sections::new(library.bytes())?;
    let info = DebugInfo::new(&sections)?;
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
            // Missing types are reported elsewhere.
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
    let (mut compared, mut untold, mut differences) = (0, Vec::new(), Vec::new());
    for (codel, symbol) in model.codels.iter().zip(&symbols) {
        let Some(function) = found.functions.get(symbol.as_str()) else {
            if !is_standard(model, codel) {
                untold.push(format!("`{}`", codel.name));
            }
            continue;
        };
        compared += 1;
        if let Err(why) = comparison.codel(codel, function) {
            differences.push(Difference {
                subject: format!("codel `{}`", codel.name),
                place: locate(codel.span),
                why: why.to_string(),
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
                why: why.to_string(),
                description: match in_cxx {
                    true => declare::members_in_cxx(types, *id),
                    false => declare::members(types, *id),
                },
                library: info.layout(at),
            });
        }
    }
    let why = if info.is_split() { Untold::Split } else { Untold::OfOthers };
    if compared == 0 {
        return Err(why);
    }
    let unchecked = (!untold.is_empty()).then(|| format!("codels {}: {why}", untold.join(", ")));
    Ok(Compared { codels: compared, differences, unchecked })
}

/// Whether the runtime supplies the codel.
fn is_standard(model: &Component, codel: &Codel) -> bool {
    match codel.owner {
        Owner::Service(rank) => model.services.get(rank).is_none_or(|service| service.standard),
        Owner::Task(_) => false,
    }
}
