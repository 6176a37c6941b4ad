//! 3.7: codels and parameters.

use crate::{accepted, refused, rules};

rules! {
    k1_a_codel_has_one_prototype "E0701" 1
        "component c { function f(in long a) { codel x(in a); }; function g(in double a) { codel x(in a); }; };";
    k1_directions_are_part_of_it "E0701" 1
        "component c { ids { long a; }; function f() { codel x(in a); }; function g() { codel x(out a); }; };";
    k1_also_among_components "E0701" 2
        "component c { function f() { codel x(); }; };\ncomponent d { function f(in long a) { codel x(in a); }; };";
    k2_a_codel_is_used_once_in_a_service "E0702" 1 "component c { function f() { validate x(); codel x(); }; };";
    k3_a_state_is_listed_once "E0703" 1 "component c { task t { codel<start> x() yield ether, ether; }; };";
    k4_a_pause_triggers_nothing "E0704" 1 "component c { task t { codel<start, pause::start> x() yield ether; }; };";
    k5_there_is_no_pause_before_the_end "E0705" 1 "component c { task t { codel<start> x() yield ether, pause::ether; }; };";
    k6_a_state_differs_from_the_types "E0706" 1
        "component c { typedef long go; task t { codel<start> x() yield ether, go; }; };";
    k7_a_state_has_one_codel "E0707" 1 "component c { task t { codel<start> x() yield ether; codel<start> y() yield ether; }; };";
    k8_an_activity_starts "E0708" 1 "component c { task t; activity a() { task t; codel<main> y() yield ether; }; };";
    k9_what_is_yielded_has_a_codel "E0709" 1 "component c { task t; activity a() { task t; codel<start> x() yield main; }; };";
    k10_stop_comes_to_the_end "E0710" 1 "component c { task t { codel<stop> x() yield stop; }; };";
    k11_every_codel_is_reached "E0711" 1
        "component c { task t { codel<start> x() yield ether; codel<dead> z() yield ether; }; };";
    k11_a_codel_of_several_states_is_said_once "E0711" 1
        "component c { task t { codel<start> x() yield ether; codel<dead, gone> z() yield ether; }; };";
    k11_an_unreached_codel_reaches_nothing "E0711" 1
        "component c { task t { codel<start> x() yield ether; codel<dead> z() yield dead, ether; }; };";
    k12_a_parameter_comes_from_somewhere "E0712" 1 "component c { function f() { codel g(in nope); }; };";
    k13_a_parameter_comes_from_one_place "E0713" 1
        "component c { ids { long value; }; function f(in long value) { codel g(in value); }; };";
    k13_also_in_attributes "E0713" 1
        "component c { ids { long a; }; attribute h(in a) { validate g2(in a); }; };";
    k14_the_ids_are_declared_before "E0714" 1 "component c { attribute d(in nope); ids { long x; }; };";
    k15_a_member_is_known "E0715" 1 "component c { ids { struct s { long x; } a; }; attribute d(in a.y); };";
    k15_also_at_the_top_of_the_ids "E0715" 1 "component c { ids { long x; }; attribute d(in y); };";
    k16_a_scalar_has_no_elements "E0716" 1 "component c { ids { long x; }; attribute d(in x[0]); };";
    k17_an_element_is_within_bounds "E0717" 1 "component c { ids { long x[2]; }; attribute d(in x[2]); };";
    k18_a_local_parameter_is_known "E0718" 1 "component c { ids { long x; }; function f() { codel g(local in x); }; };";
    k19_only_the_ids_are_passed_whole "E0719" 1 "component c { function f(in long a) { codel g(local in ::b); }; };";
    k20_a_port_is_known "E0720" 1 "component c { task t { codel<start> g(port in p) yield ether; }; };";
    k20_a_remote_is_known "E0720" 1 "component c { task t { codel<start> g(remote in p) yield ether; }; };";
    k21_an_in_port_is_not_written "E0721" 1
        "component c { typedef long l; port in l p; task t { codel<start> g(out p) yield ether; }; };";
    k22_a_port_has_no_members "E0722" 1
        "component c { struct s { long x; }; port in s p; task t { codel<start> g(in p.x) yield ether; }; };";
    k23_a_remote_is_only_in "E0723" 2
        "interface i { function r(); };\ncomponent c { uses i; task t { codel<start> g(inout r) yield ether; }; };";
    k24_an_async_codel_shares_nothing "E0724" 2
        "component c { ids { long v, w; };
         task t { async codel<start> a(out v) yield ether; };
         task u { codel<start> b(in v) yield main; codel<main> b2(in v) yield ether; }; };";
    k24_not_even_with_an_attribute "E0724" 1
        "component c { ids { long v; }; attribute s(in v); task t { async codel<start> a(in v) yield ether; }; };";
}

#[test]
fn k21_an_in_port_may_be_inout() {
    accepted(
        "component c { typedef long l; port in l p; task t { codel<start> g(inout p) yield ether; }; };",
    );
}

#[test]
fn k1_structs_of_like_shape_are_one_type() {
    accepted(
        "struct s1 { long a; double b; }; struct s2 { long x; double y; };
         component c { ids { s1 i; s2 j; }; function f() { codel g(in i); }; function h() { codel g(in j); }; };",
    );
}

#[test]
fn k9_sleep_needs_no_codel_where_there_are_events() {
    let text = |event: &str| {
        format!(
            "component c {{ {event} task t; activity a() {{ task t; codel<start> f() yield sleep, ether;
             codel<stop> h() yield ether; }}; }};"
        )
    };
    accepted(&text("event go;"));
    refused("E0709", 1, &text(""));
}

#[test]
fn k11_a_task_needs_no_start() {
    accepted("component c { task t { codel<stop> x() yield ether; }; };");
}

#[test]
fn k11_a_codel_is_reached_by_any_of_its_states() {
    let machine = |owner: &str, states: &str| {
        let head = if owner == "task" { "task t {" } else { "task t; activity a() { task t;" };
        format!(
            "component c {{ {head} codel<{states}> x() yield main; codel<main> y() yield ether; }}; }};"
        )
    };
    for owner in ["task", "activity"] {
        accepted(&machine(owner, "start, other"));
        accepted(&machine(owner, "other, start"));
    }
    // Reached from `stop` only, through a state that it shares.
    accepted(
        "component c { task t; activity a() { task t; codel<start> x() yield ether;
         codel<stop> y() yield late; codel<early, late, later> z() yield ether; }; };",
    );
}
