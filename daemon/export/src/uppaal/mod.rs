//! UPPAAL: tables of the component, the rules, which are the same for all, and who takes their steps.

mod declared;
mod queries;
mod role;
mod roles;

use std::fmt::Write as _;

use genom_formal::{System, Times};

use crate::error::ExportError;
use crate::tables::Sizes;
use crate::xml;

pub(crate) fn uppaal(system: &System, times: Option<&Times>) -> Result<String, ExportError> {
    let sizes = Sizes::new(system, "uppaal")?;
    let declared = declared::declared(system, &sizes, times)?;
    let name = &system.plan().component().name;
    let unit = times.map_or_else(String::new, |times| {
        format!(" Clocks count in units of {} ns.", times.unit(system))
    });
    let mut text = xml::head(&format!(
        "Component {name}: what it can do, whatever its codels yield and its clients ask.{unit}\n     \
         Checked by: verifyta {name}.xml"
    ));
    let _ = writeln!(text, "<declaration>{}</declaration>", xml::escaped(&declared));
    let roles = roles::roles(system, &sizes, times.is_some());
    roles.iter().for_each(|role| text.push_str(&role.template()));
    let made: String = roles.iter().map(|role| role.made()).collect();
    let processes: Vec<&str> = roles.iter().flat_map(|role| role.names()).collect();
    let _ = writeln!(text, "<system>{made}system {};</system>\n<queries>", processes.join(", "));
    queries::queries(&mut text, system, times.is_some());
    text.push_str("</queries>\n</nta>\n");
    Ok(text)
}
