//! 3.4: components, interfaces, inclusion.

use crate::{accepted, rules};

rules! {
    i1_a_component_is_no_interface "E0401" 1 "interface i; component i;";
    i1_an_interface_is_no_component "E0401" 1 "component i; interface i { doc \"x\"; };";
    i2_what_is_provided_exists "E0402" 1 "component c { provides nope; };";
    i2_what_is_used_exists "E0402" 1 "component c { uses nope; };";
    i3_a_component_cannot_be_provided "E0403" 1 "component a; component b { provides a; };";
    i4_an_interface_is_listed_once "E0404" 1 "interface i; component c { provides i, i; };";
    i5_a_version_is_given_once "E0405" 1
        "interface i { version \"1\"; }; component c { version \"2\"; provides i; };";
    i5_a_period_is_given_once "E0405" 1
        "interface i { task t { period 1ms; }; };\ncomponent d { task t { period 2ms; }; provides i; };";
    i5_a_codel_is_used_once "E0702" 1
        "interface i { function f() { codel x(); }; };\ncomponent c { function f() { codel x(); }; provides i; };";
    i6_a_pragma_provides_what_exists "E0406" 1 "#pragma provides nope\ncomponent c;";
    i6_a_pragma_provides_no_component "E0406" 2 "component a;\n#pragma provides a\ncomponent c;";
    i7_a_member_of_the_ids_is_declared_once "E0407" 1 "component c { ids { long a; }; ids { long a; double b; }; };";
    i7_also_when_an_interface_brings_it "E0407" 1
        "interface i { ids { long a; }; };\ncomponent c { ids { double a; }; provides i; };";
}

#[test]
fn i4_an_interface_may_be_named_in_two_statements() {
    accepted("interface i { function f(); }; component c { provides i; provides i; };");
}

#[test]
fn i8_a_component_may_extend() {
    accepted("interface i { function f(); }; component c { extends i; };");
}

#[test]
fn a_pragma_concerns_the_components_after_it() {
    let analysis = crate::analyse(
        "interface i { function f(); };\ncomponent a;\n#pragma provides i\ncomponent b;",
    );
    let counts: Vec<_> =
        analysis.specification.components.iter().map(|c| c.services.len()).collect();
    assert_eq!(counts, [0, 1]);
}
