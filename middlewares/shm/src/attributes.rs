//! Service attributes that describe types more precisely than iceoryx2's own type details.

use iceoryx2::prelude::*;
use iceoryx2::service::static_config::StaticConfig;
use iceoryx2::service::static_config::message_type_details::TypeDetail;

/// Attribute that holds the spelling of a service's type.
pub(crate) const TYPE_KEY: &str = "genom.type";
pub(crate) const DIGEST_KEY: &str = "genom.digest";

/// The attributes of a service of ours. A spelling that is too long is left out: types are compared
/// by digest.
pub(crate) fn attributes(pairs: [(&str, &str); 2]) -> AttributeSpecifier {
    let mut attributes = AttributeSpecifier::new();
    for (key, value) in pairs {
        if let (Ok(key), Ok(value)) = (key.try_into(), value.try_into())
            && let Ok(more) = attributes.clone().define(&key, &value)
        {
            attributes = more;
        }
    }
    attributes
}

pub(crate) fn attribute(attributes: &AttributeSet, key: &str) -> Option<String> {
    let key = key.try_into().ok()?;
    attributes.key_value(&key, 0).map(ToString::to_string)
}

/// The type of a service, for error messages; also of services that others created.
pub(crate) fn type_of_service(service: &StaticConfig) -> String {
    describe(service.attributes(), service.publish_subscribe().message_type_details().payload)
}

/// Spells a type from a service's attributes and its payload layout.
pub(crate) fn describe(attributes: &AttributeSet, payload: TypeDetail) -> String {
    let layout = format!("{} bytes aligned to {}", payload.size(), payload.alignment());
    match (attribute(attributes, TYPE_KEY), attribute(attributes, DIGEST_KEY)) {
        (Some(ty), Some(digest)) => format!("{ty} ({layout}, digest {digest})"),
        _ => format!("the iceoryx2 type {} ({layout})", payload.type_name()),
    }
}
