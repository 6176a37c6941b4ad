//! What ports of genomd say of themselves at the name server, in the property `genomd`: other
//! daemons refuse other types by it. YARP itself knows no types.

use genom_middleware::describe::type_of_port;
use genom_types::DataType;

/// Name of the property.
pub(crate) const PROPERTY: &str = "genomd";

/// What a port is.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Mark {
    /// An out port.
    Out(Type),
    /// An in port.
    In(Type),
    /// The services of a component.
    Rpc(Vec<String>),
}

/// Type of a port.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Type {
    pub(crate) digest: String,
    /// As errors name it.
    pub(crate) spelled: String,
    /// Its name alone.
    pub(crate) name: String,
}

impl Type {
    pub(crate) fn of(ty: &DataType) -> Self {
        let (digest, name) = (ty.digest().to_owned(), ty.name().to_owned());
        Self { digest, spelled: type_of_port(ty), name }
    }

    /// In the form of a property: without blanks, commas and brackets.
    fn property(&self, ty: &DataType) -> String {
        let size = if ty.is_fixed_size() { ty.size().to_string() } else { String::new() };
        let name = self.name.replace(' ', "+").replace(',', ";");
        format!("{}|{size}|{name}", self.digest)
    }

    fn parse(text: &str) -> Option<Self> {
        let mut parts = text.splitn(3, '|');
        let (digest, size, name) = (parts.next()?, parts.next()?, parts.next()?);
        let name = name.replace('+', " ").replace(';', ",");
        let spelled = match size {
            "" => format!("{name} (variable size, digest {digest})"),
            size => format!("{name} ({size} bytes, digest {digest})"),
        };
        Some(Self { digest: digest.to_owned(), spelled, name })
    }
}

/// The property of an out port or, if `reads`, of an in port.
pub(crate) fn of_port(ty: &DataType, reads: bool) -> String {
    let kind = if reads { "in" } else { "out" };
    format!("{kind}|{}", Type::of(ty).property(ty))
}

/// The property of services.
pub(crate) fn of_services(names: &[String]) -> String {
    format!("rpc|{}", names.join("|"))
}

impl Mark {
    pub(crate) fn parse(property: &str) -> Option<Self> {
        let (kind, rest) = property.split_once('|')?;
        match kind {
            "out" => Type::parse(rest).map(Self::Out),
            "in" => Type::parse(rest).map(Self::In),
            "rpc" => {
                let names = rest.split('|').filter(|name| !name.is_empty());
                Some(Self::Rpc(names.map(str::to_owned).collect()))
            }
            _ => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use genom_conformance::samples::{note, state};

    use super::*;

    #[test]
    fn a_port_says_its_type_as_errors_spell_it() {
        for ty in [state(), note()] {
            let property = of_port(&ty, true);
            assert!(!property.contains([' ', ',', '(', '"']), "{property}");
            assert_eq!(Mark::parse(&property), Some(Mark::In(Type::of(&ty))));
            assert!(matches!(Mark::parse(&of_port(&ty, false)), Some(Mark::Out(_))));
        }
        let services = ["goto".to_owned(), "stop".to_owned()];
        assert_eq!(Mark::parse(&of_services(&services)), Some(Mark::Rpc(services.to_vec())));
        assert_eq!(Mark::parse("tcp fast_tcp"), None);
    }
}
