//! 3.10: what GenoM3 accepts in silence.

use crate::{accepted, warned};

#[test]
fn an_activity_that_cannot_end_by_itself_is_told() {
    warned(
        "W0901",
        "component c { task t; activity a() { task t; codel<start> x() yield pause::start;
         codel<stop> y() yield ether; }; };",
    );
}

#[test]
fn writing_an_in_parameter_is_told() {
    warned("W0902", "component c { function f(in long a) { codel x(out a); }; };");
    accepted("component c { function f(in long a) { validate x(inout a); }; };");
}

#[test]
fn a_port_that_no_codel_uses_is_told() {
    warned("W0903", "component c { typedef long l; port in l p; };");
}

#[test]
fn a_value_out_of_range_is_told() {
    warned("W0904", "const octet a = 300;");
    warned("W0904", "const short a = -32769;");
    warned("W0904", "const string<3> b = \"toolong\";");
    accepted("const octet a = 255; const short b = -32768; const string<4> c = \"abc\";");
}

#[test]
fn a_task_in_which_nothing_runs_is_told() {
    warned("W0905", "component c { task t { period 1 s; }; };");
}

#[test]
fn an_activity_that_loops_without_stop_is_told() {
    warned(
        "W0906",
        "component c { task t; activity a() { task t; codel<start> x() yield pause::start, ether; }; };",
    );
}
