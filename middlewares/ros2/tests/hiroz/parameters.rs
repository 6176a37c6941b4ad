//! Parameters of a node: what `ros2 param dump` and `ros2 param load` do, by hiroz's own client.

#[path = "../parameters/attribute.rs"]
mod attribute;

use std::sync::Mutex;

use attribute::{Attribute, Ids};

use super::*;
use crate::services::{BOOLEAN, DOUBLE, LONGS, Make, SHORT};

#[test]
#[ignore = "hiroz takes minutes to compile: .ci/release runs it"]
fn what_hiroz_dumped_of_a_node_it_loads_into_it_again() {
    let place = Place::new();
    let ros2 = place.open();
    let before = json!({"count": -3, "gain": 0.25, "on": true, "row": [1, 2]});
    let before = before.as_object().unwrap().clone();
    let ids: Ids = Arc::new(Mutex::new(before.clone()));
    let kinds: [(&str, Make); 4] =
        [("count", SHORT), ("gain", DOUBLE), ("on", BOOLEAN), ("row", LONGS)];
    let _served = kinds.map(|(name, kind)| Attribute::serve(&ros2, &ids, name, kind));
    let mut node = node(&place);
    let dump = node.ask(&json!(["dump", "/", "robot"]));
    assert_eq!(
        dump,
        json!([
            ["count", -3],
            ["gain", 0.25],
            ["on", true],
            ["row", [1, 2]],
            ["use_sim_time", false]
        ])
    );

    let change = || {
        let changed = json!({"count": 5, "gain": 7.5, "on": false, "row": []});
        ids.lock().unwrap().clone_from(changed.as_object().unwrap());
    };
    let now = || ids.lock().unwrap().clone();
    change();
    let done = json!([true, ""]);
    let loaded = node.ask(&json!(["load", "/", "robot", dump]));
    assert_eq!(loaded, json!(vec![&done; 5]));
    assert_eq!(now(), before);

    // Some of them: the others stay as they were changed.
    change();
    let some = &dump.as_array().unwrap()[1..3];
    assert_eq!(node.ask(&json!(["load", "/", "robot", some])), json!(vec![&done; 2]));
    assert_eq!(Value::Object(now()), json!({"count": 5, "gain": 0.25, "on": true, "row": []}));

    // Atomically: one at a time.
    change();
    let whole = node.ask(&json!(["load", "/", "robot", dump, true]));
    assert_eq!(whole, json!([false, "attributes are set one by one: use set_parameters"]));
    assert_eq!(now()["count"], 5);
    for one in dump.as_array().unwrap() {
        assert_eq!(node.ask(&json!(["load", "/", "robot", [one], true])), done, "{one}");
    }
    assert_eq!(now(), before);
}
