//! The services of `composition_interfaces`.

use genom_middleware::ServiceType;
use genom_types::{Kind, LayoutError, TypeId};

use crate::offer::Kind as Offered;
use crate::table::Table;

/// The package of all of them.
const PACKAGE: &str = "composition_interfaces";

/// The services of a container.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Service {
    LoadNode,
    UnloadNode,
    ListNodes,
}

impl Service {
    pub(crate) const ALL: [Self; 3] = [Self::LoadNode, Self::UnloadNode, Self::ListNodes];
}

impl Offered for Service {
    fn name(self) -> &'static str {
        match self {
            Self::LoadNode => "_container/load_node",
            Self::UnloadNode => "_container/unload_node",
            Self::ListNodes => "_container/list_nodes",
        }
    }

    fn masquerade(self) -> (String, String) {
        let ros = match self {
            Self::LoadNode => "LoadNode",
            Self::UnloadNode => "UnloadNode",
            Self::ListNodes => "ListNodes",
        };
        (format!("::{PACKAGE}::{ros}"), format!("{PACKAGE}/srv/{ros}"))
    }

    fn types(self) -> Result<ServiceType, LayoutError> {
        let mut table = Table::of(PACKAGE);
        let (text, number) = (table.string(), table.add(Kind::UnsignedLongLong));
        let success = table.add(Kind::Boolean);
        match self {
            Self::LoadNode => {
                let (level, texts) = (table.add(Kind::Octet), table.several(text));
                let parameter = parameter(&mut table);
                let parameters = table.several(parameter);
                let input = vec![
                    ("package_name", text),
                    ("plugin_name", text),
                    ("node_name", text),
                    ("node_namespace", text),
                    ("log_level", level),
                    ("remap_rules", texts),
                    ("parameters", parameters),
                    ("extra_arguments", parameters),
                ];
                let output = vec![
                    ("success", success),
                    ("error_message", text),
                    ("full_node_name", text),
                    ("unique_id", number),
                ];
                table.service("LoadNode", input, output)
            }
            Self::UnloadNode => {
                let output = vec![("success", success), ("error_message", text)];
                table.service("UnloadNode", vec![("unique_id", number)], output)
            }
            Self::ListNodes => {
                let (texts, numbers) = (table.several(text), table.several(number));
                let output = vec![("full_node_names", texts), ("unique_ids", numbers)];
                table.service("ListNodes", vec![], output)
            }
        }
    }
}

/// `rcl_interfaces/msg/Parameter`.
fn parameter(table: &mut Table) -> TypeId {
    let (octet, boolean) = (table.add(Kind::Octet), table.add(Kind::Boolean));
    let (long, double) = (table.add(Kind::LongLong), table.add(Kind::Double));
    let text = table.string();
    let value = vec![
        ("type", octet),
        ("bool_value", boolean),
        ("integer_value", long),
        ("double_value", double),
        ("string_value", text),
        ("byte_array_value", table.several(octet)),
        ("bool_array_value", table.several(boolean)),
        ("integer_array_value", table.several(long)),
        ("double_array_value", table.several(double)),
        ("string_array_value", table.several(text)),
    ];
    let value = table.foreign("rcl_interfaces", "ParameterValue", value);
    table.foreign("rcl_interfaces", "Parameter", vec![("name", text), ("value", value)])
}
