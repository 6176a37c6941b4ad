//! 3.2: names, scopes, types.

use crate::{accepted, refused, rules};

rules! {
    n1_a_name_is_declared_once_in_a_scope "E0201" 2 "typedef long a;\nconst long a = 1;";
    n1_members_of_a_struct_have_their_own_names "E0201" 1 "struct s { long a, b; double a; };";
    n1_states_share_the_scope_of_types "E0201" 1 "component c { typedef long start; };";
    n2_a_name_differs_from_the_module_around_it "E0202" 1 "module m { typedef long m; };";
    n2_a_name_differs_from_the_component_around_it "E0202" 1 "component c { const long c = 1; };";
    n3_a_module_differs_from_the_module_around_it "E0203" 1
        "module m { module m { typedef long a; }; };";
    n3_a_struct_differs_from_the_module_around_it "E0203" 1 "module s { struct s { long a; }; };";
    n4_a_type_differs_from_the_components "E0204" 1 "component c; typedef long c;";
    n4_no_type_of_a_component_is_called_pause "E0204" 1 "component c { typedef long pause; };";
    n4_a_constant_differs_from_the_modules "E0204" 1
        "module m { typedef long a; }; const long m = 1;";
    n4_an_enumerator_differs_from_the_modules "E0204" 1
        "module m { typedef long a; }; enum e { k, m };";
    n4_a_native_differs_from_the_interfaces "E0204" 1 "interface i; native i;";
    n4_a_port_differs_from_the_modules_of_its_component "E0204" 1
        "component c { module m { typedef long a; }; port in m::a m; };";
    n4_a_state_differs_from_the_modules_of_its_component "E0204" 1
        "component c { module m { typedef long a; }; task t { codel<start> x() yield m, ether; }; };";
    n5_a_struct_is_declared_once "E0205" 1 "struct s { long a; }; struct s { long a; };";
    n5_a_module_is_no_type "E0205" 1 "typedef long m; module m { typedef long a; };";
    n5_a_component_is_no_type "E0205" 1 "typedef long c; component c { version \"1\"; };";
    n6_a_type_is_declared_before_it_is_used "E0206" 1 "struct s { nope x; }; typedef s t;";
    n6_members_of_structs_are_no_names "E0206" 1 "struct a { struct b { long x; } y; }; struct c { b w; };";
    n6_scopes_are_tried_as_a_whole "E0206" 1
        "module a { module b { typedef long u; }; }; typedef ::b::u n;";
    n6_an_interface_gives_no_type_names "E0206" 1
        "interface i { struct s { long x; }; }; component d { uses i; port out s q; };";
    n7_an_announced_struct_is_no_value "E0207" 1
        "struct s; typedef sequence<s> t; struct u { s x; }; struct s { long a; };";
    n7_not_even_behind_a_typedef "E0207" 1
        "struct s; typedef s t; struct u { t x; }; struct s { long a; };";
    n8_what_is_announced_is_defined "E0208" 1 "struct s; typedef sequence<s> t;";
    n9_what_is_announced_is_defined_once "E0209" 1
        "struct s; struct s { long a; }; struct s { long b; };";
    n11_an_exception_without_members_is_no_type "E0211" 1 "exception e; struct u { e x; };";
    n13_an_enumerator_is_declared_once "E0213" 1 "enum e { A, B, A };";
    n13_also_among_enums_of_one_scope "E0213" 1 "enum e { A, B }; enum f { B, C };";
}

#[test]
fn what_has_no_place_in_memory_is_refused() {
    for text in [
        "component c { ids { c::ids x; }; };",
        "struct s; struct s { sequence<s, 4> x; }; component c { ids { s y; }; };",
        "struct s; struct s { sequence<s, 4> x; }; component c { function f(in s y); };",
        "typedef octet a[65536]; typedef a b[65536]; component c { port out b p; task t {
         codel<start> x(out p) yield ether; }; };",
        "struct s { octet a[65536][65536]; }; component c { function f() { local s x; codel g(local in x); }; };",
    ] {
        let analysis = crate::analyse(text);
        let codes: Vec<_> = analysis.diagnostics.iter().map(|said| said.code).collect();
        assert_eq!(codes, ["E0216"], "{text}");
    }
    // Recursion through unbounded sequences is fine, and so is a recursive type that no component
    // uses.
    accepted("struct s; struct s { sequence<s> x; }; component c { ids { s y; }; };");
    accepted("struct s { octet a[65536][65536]; };");
}

#[test]
fn names_that_c_has_otherwise_are_told() {
    use crate::warned;
    warned("W0908", "struct s { long errno; };");
    warned("W0908", "component c { ids { struct s { double register; } x; }; };");
    warned("W0908", "module m { union u switch (long) { case 1: long class; }; };");
    warned("W0908", "typedef long new;");
    accepted("module m { typedef long int; }; component c { function f(in long new); };");
    warned(
        "W0909",
        "module a { struct b_c { long x; }; }; module a_b { struct c { double y; }; };",
    );
    warned("W0909", "module m { enum e { RED }; }; const long m_RED = 3;");
    warned("W0909", "struct c_start { long x; }; component c;");
    warned(
        "W0909",
        "struct c_p { long x; }; component c { port out c_p p; task t {
         codel<start> x(out p) yield ether; }; };",
    );
    accepted("module a { struct b { long x; }; }; module b { struct a { long x; }; };");
}

#[test]
fn n2_a_member_may_bear_the_name_of_its_struct() {
    accepted("struct s { long s; }; struct t { struct u { long x; } u2; };");
}

#[test]
fn n6_the_nearest_name_is_suggested() {
    let analysis = crate::analyse("typedef long length; struct s { lenght x; };");
    assert_eq!(analysis.diagnostics[0].help.as_deref(), Some("did you mean `length`?"));
}

#[test]
fn n10_a_type_is_defined_in_the_file_that_announces_it() {
    let folder = tempfile::tempdir().unwrap();
    let other = folder.path().join("other.idl");
    std::fs::write(&other, "struct s { long a; };\n").unwrap();
    refused("E0210", 1, &format!("struct s;\n#include \"{}\"\n", other.display()));
}

#[test]
fn exceptions_with_members_and_constants_are_types() {
    accepted(
        "exception f { long a; }; struct v { f x; }; const long a = 1; const a b = 2; struct s { a x; };",
    );
}
