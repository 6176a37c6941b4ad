//! C declarations of a description's items, as an author would write them (genom3.md 5.5, 5.6).

use genom_description::model::{Codel, CodelParameter, Component, Direction, Source};
use genom_description_tools as tools;
use genom_types::{Kind, TypeId, TypeTable};

/// `genom_event f(int32_t x, demo_s *y, const genom_context self)`.
pub(super) fn codel(component: &Component, types: &TypeTable, codel: &Codel) -> String {
    let parameters = codel.parameters.iter();
    let mut parameters: Vec<_> =
        parameters.map(|parameter| argument(component, types, parameter)).collect();
    parameters.push("const genom_context self".to_owned());
    format!("genom_event {}({})", codel.name, parameters.join(", "))
}

/// `{ double x; char[64] what; }`: the members of a struct or exception.
pub(super) fn members(types: &TypeTable, ty: TypeId) -> String {
    let members = types.members(ty).iter();
    let members = members.map(|member| format!("{} {};", types.c_name(member.ty), member.name));
    format!("{{ {} }}", members.collect::<Vec<_>>().join(" "))
}

/// The members in C++: `{ double x; char what[64]; }`.
pub(super) fn members_in_cxx(types: &TypeTable, ty: TypeId) -> String {
    let member = |member: &genom_types::Member| {
        format!("{};", tools::declaration(types, member.ty, &member.name))
    };
    let members = types.members(ty).iter().map(member);
    format!("{{ {} }}", members.collect::<Vec<_>>().join(" "))
}

fn argument(component: &Component, types: &TypeTable, parameter: &CodelParameter) -> String {
    let name = &parameter.name;
    let object = match parameter.source {
        Source::Port(port) => component.ports.get(port).map(|port| &port.name),
        Source::Remote(remote) => component.remotes.get(remote).map(|remote| &remote.name),
        _ => return datum(types, parameter.ty, name, parameter.direction),
    };
    let object = object.map_or("?", String::as_str);
    format!("const {}_{object} *{name}", component.name)
}

/// A parameter of this type and direction.
fn datum(types: &TypeTable, ty: TypeId, name: &str, direction: Direction) -> String {
    let input = direction == Direction::In;
    let constant = if input { "const " } else { "" };
    let c = types.c_name(ty);
    let named = types.kind(ty).name().is_some();
    match types.resolved(ty) {
        Kind::Array { .. } | Kind::String { bound: Some(_) } => {
            let (base, dimensions) = match c.find('[') {
                Some(at) if !named => c.split_at(at),
                _ => (c.as_str(), ""),
            };
            format!("{constant}{} {name}{dimensions}", base.trim_end())
        }
        Kind::String { bound: None } | Kind::Native { .. } => {
            let c = c.trim_end_matches([' ', '*']);
            let stars = if input { "*" } else { "**" };
            format!("{constant}{c} {stars}{name}")
        }
        Kind::Sequence { .. }
        | Kind::Optional { .. }
        | Kind::Struct { .. }
        | Kind::Union { .. }
        | Kind::Exception { .. } => format!("{constant}{c} *{name}"),
        _ if input => format!("{c} {name}"),
        _ => format!("{c} *{name}"),
    }
}
