//! Foreign names of a component's types.

use genom_supervisor::LoadRequest;

use crate::support::{Scratch, load};

const THING: &str = "
module thing { struct place { double x; double y; double z; }; };
#pragma masquerade ros2 thing::place geometry_msgs/msg/Point
component thing { version \"1\"; lang \"c\"; ids { octet unused; };
  port out thing::place where;
  attribute set_unused(in unused = 0) { validate thing_check(local in unused); };
};
";

const CODELS: &str = "
genom_event
thing_check(uint8_t unused, const genom_context self)
{
  (void)self;
  return unused > 9 ? genom_unkex(NULL, self) : genom_ok;
}
";

#[test]
fn nothing_is_shown_under_a_foreign_name_for_a_component_that_was_refused() {
    let scratch = Scratch::new();
    let supervisor = scratch.supervisor();
    let library = scratch.component("thing", THING, CODELS);
    // The name of its codel is wrong: it does not match the description.
    let other =
        scratch.component("other", &THING.replace("component thing", "component other"), "");
    let refused = |library, attribute: Option<(&str, i32)>| {
        let attributes = attribute
            .map(|(name, value)| (name.to_owned(), serde_json::json!({ "unused": value })));
        let attributes = attributes.into_iter().collect();
        let request = LoadRequest { library, attributes, ..LoadRequest::default() };
        supervisor.load(&request).err().expect("it is refused");
        assert_eq!(supervisor.backends.disguised(), []);
    };
    refused(other, None);
    refused(library.clone(), Some(("set_unused", 10)));
    let thing = load(&supervisor, library);
    assert_eq!(supervisor.backends.disguised().len(), 1);
    drop(thing);
    supervisor.unload("thing").unwrap();
    assert_eq!(supervisor.backends.disguised(), []);
}
