//! One mistake, one message: its consequences are not reported.

use crate::{refused, rules};

rules! {
    a_port_of_an_unknown_type_is_not_missed_by_codels "E0206" 1
        "component c { port in nope p; task t { codel<start> x(in p, port in p::q) yield ether; }; };";
    a_struct_that_is_lost_is_not_missed "E0110" 1
        "struct s { long }; typedef s t; component c { ids { s a; }; attribute x(in a); };";
    a_lost_member_is_not_missed "E0206" 1
        "component c { ids { nope a; long b; }; attribute x(in a, in b); function f() { codel g(in a); }; };";
    a_lost_task_is_not_missed "E0103" 1
        "component c { task t { priority ; codel<start> i() yield ether; } ; activity a() { task t; codel<start> x() yield ether; }; };";
    a_lost_service_is_not_missed "E0206" 1
        "component c { function f(in nope a) { codel g(in a); }; function h() { interrupts f; }; };";
    a_lost_exception_is_not_missed "E0206" 1
        "component c { exception e { nope a; long b; }; throw e; function f() { throw e; }; };";
    a_lost_constant_is_not_missed "E0305" 1
        "const long n = 1.5; typedef long a[n]; typedef sequence<a, n * 2> b; const long m = n + 1;";
    a_lost_interface_is_not_missed "E0104" 1
        "interfac i { function f(); }; component c { provides i; };";
    a_service_reopened_wrongly_has_one_error "E0604" 2
        "interface i { activity a(in long x = 2: \"doc\"); };
         component c { provides i; task t; activity a(in long y) { task t; codel<start> s(in y) yield ether; }; };";
    an_enum_that_clashes_does_not_hide_its_use "E0201" 1
        "typedef long e; enum e { A, B }; const long x = 1;";
}

#[test]
fn a_missing_brace_is_one_error() {
    refused("E0105", 4, "component c {\n task t {\n  period 1 s;\n };\n");
}
