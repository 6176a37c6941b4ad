//! 3.6: tasks, ports, services.

use crate::{accepted, rules};

rules! {
    s1_no_service_is_called_all "E0601" 1 "component c { function all(); };";
    s2_a_service_differs_from_the_ports "E0602" 1 "component c { typedef long l; port in l p; function p(); };";
    s2_a_port_differs_from_the_services "E0602" 1 "component c { typedef long l; function p(); port in l p; };";
    s2_a_service_differs_from_the_remotes "E0602" 2
        "interface i { function f(); };\ncomponent d { uses i; function f(); };";
    s3_a_service_keeps_its_kind "E0603" 1 "component c { function f(); attribute f(); };";
    s4_a_reopened_service_keeps_its_names "E0604" 1 "component c { function f(in long a); function f(in long b); };";
    s5_a_reopened_service_keeps_its_types "E0605" 1 "component c { function f(in long a); function f(in double a); };";
    s5_a_reopened_service_keeps_its_directions "E0605" 1 "component c { function f(in long a); function f(out long a); };";
    s6_a_reopened_service_has_no_more_parameters "E0606" 1 "component c { function f(in long a); function f(in long a, in long b); };";
    s7_a_reopened_service_has_no_fewer_parameters "E0607" 1 "component c { function f(in long a, in long b); function f(in long a); };";
    s8_a_function_runs_in_no_task "E0608" 1 "component c { task t; function a() { task t; }; };";
    s9_an_activity_has_no_simple_codel "E0609" 1 "component c { task t; activity a() { task t; codel x(); }; };";
    s10_a_function_has_no_state_machine "E0610" 1 "component c { function a() { codel<start> y() yield ether; }; };";
    s11_a_simple_codel_takes_no_port "E0611" 1 "component c { typedef long l; port in l p; function f() { codel g(port in p); }; };";
    s11_a_validate_codel_takes_no_remote "E0611" 2
        "interface i { function r(); };\ncomponent c { uses i; function f() { validate g(remote in r); }; };";
    s12_a_parameter_holds_no_native "E0612" 1 "component c { native n; function f(in sequence<n> a); };";
    s13_an_activity_has_a_task "E0613" 1 "component c { activity a() { codel<start> y() yield ether; }; };";
    s14_an_activity_has_a_codel "E0614" 1 "component c { task t; activity a() { task t; }; };";
    s15_a_parameter_is_declared_once "E0615" 1 "component c { function f(in long a, in long a); };";
    s15_also_in_codels "E0615" 1 "component c { function f(in long a) { codel g(in a, in a); }; };";
    s15_also_with_local_variables "E0615" 1 "component c { function f(in long a) { local long a; }; };";
    s16_local_variables_belong_to_services "E0616" 1 "component c { local long a; };";
    s17_an_attribute_has_no_local_variable "E0617" 1 "component c { ids { long a; }; attribute h(in a) { local long z; }; };";
    s18_a_port_has_a_named_type "E0618" 1 "interface i { port in long p; };";
    s18_also_with_templates "E0618" 1 "component c { port out sequence<long> p; };";
    s19_a_port_holds_no_native "E0619" 1 "component c { native n; struct s { n x; }; port out s p; };";
    s20_a_port_is_declared_once "E0620" 1 "component c { typedef long l; port in l p; port out l p; };";
}

#[test]
fn s2_a_task_may_share_its_name() {
    accepted("component c { task a; activity a() { task a; codel<start> a() yield ether; }; };");
}

#[test]
fn s12_local_variables_and_ids_may_hold_natives() {
    accepted(
        "component c { native n; ids { n x; }; function f() { local n y; codel g(out x, local in y); }; };",
    );
}

#[test]
fn s13_interfaces_need_no_task() {
    accepted("interface i { activity a(in long x); };");
}
