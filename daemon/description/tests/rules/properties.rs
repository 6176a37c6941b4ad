//! 3.5: properties.

use crate::{accepted, rules, warned};

rules! {
    p1_a_component_has_no_codel "E0501" 1 "interface i { codel x(); };";
    p1_nor_a_period "E0501" 1 "component c { period 1 s; };";
    p2_a_task_has_no_validate "E0502" 1 "component c { task t { validate v(); codel<start> x() yield ether; }; };";
    p3_a_task_has_no_simple_codel "E0503" 1 "component c { task t { codel y(); }; };";
    p4_a_port_has_only_a_doc "E0504" 1 "component c { typedef long l; port in l p { period 1 s; }; };";
    p5_a_service_has_no_period "E0505" 1 "component c { function f() { period 1 s; }; };";
    p6_a_property_is_given_once "E0506" 1 "component c { version \"1\"; version \"2\"; };";
    p6_a_task_property_too "E0506" 1 "component c { task t; task t { period 1ms; }; task t { period 2ms; }; };";
    p6_before_is_not_united "E0506" 1 "component c { function f() { before f; before f; }; };";
    p8_a_time_is_not_negative "E0508" 1 "component c { task t { period -1 s; }; };";
    p9_a_delay_needs_a_period "E0509" 1 "component c { task t { delay 1 ms; }; };";
    p10_a_delay_is_less_than_the_period "E0510" 1 "component c { task t { delay 2 ms; period 2 ms; }; };";
    p11_the_clock_divides_the_periods "E0511" 1 "component c { clock-rate 3ms; task t { period 5ms; }; task u { period 6ms; }; };";
    p12_a_clock_can_be_computed "E0512" 1 "component c { task t { period 0.1 us; }; };";
    p13_a_task_is_declared_before_its_services "E0513" 1
        "component c { activity b() { task t; codel<start> x() yield ether; }; task t; };";
    p14_only_exceptions_are_thrown "E0514" 1 "component c { typedef long e; throw e; };";
    p14_an_exception_is_known "E0206" 1 "component c { throw e; exception e; };";
    p15_an_exception_is_listed_once "E0515" 1 "component c { exception e; function f() { throw e, e; throw e; }; };";
    p16_a_service_is_listed_once "E0516" 1 "component c { function f() { interrupts f, f; }; };";
    p17_what_is_interrupted_exists "E0517" 1 "component c { function f() { interrupts g; }; };";
    p17_what_comes_before_exists "E0517" 1 "component c { function f() { after all, g; }; };";
}

#[test]
fn p7_a_string_listed_twice_is_a_warning() {
    warned("W0507", "component c { requires \"a\", \"a\", \"b\"; };");
}

#[test]
fn p6_docs_throws_and_interrupts_are_united() {
    accepted(
        "component c { exception e; doc \"a\"; doc \"b\"; function f() { throw e; throw e;
         interrupts f; interrupts g; interrupts all; }; function g(); };",
    );
}
