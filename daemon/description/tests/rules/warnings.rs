//! 3.10: what GenoM3 accepts silently.

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
fn an_activity_may_keep_something_in_an_in_parameter() {
    let activity = |codels: &str| {
        format!(
            "component c {{ struct s {{ long a, b; }}; task t; activity f(in s n) {{ task t; {codels} \
             codel<stop> z() yield ether; }}; }};"
        )
    };
    // Read by the codel itself, when it runs again.
    accepted(&activity("codel<start> x(inout n) yield pause::start, ether;"));
    // Read by the next codel, and by the one after that.
    accepted(&activity("codel<start> x(out n) yield main; codel<main> y(in n) yield ether;"));
    accepted(&activity(
        "codel<start> x(out n.a) yield main; codel<main> y() yield last; codel<last> w(in n.a) yield ether;",
    ));
    // Read by `stop`, after an interruption.
    let stops =
        "component c { task t; activity f(in long n) { task t; codel<start> x(out n) yield ether;
         codel<stop> z(in n) yield ether; }; };";
    accepted(stops);
    accepted("component c { function f(in long a) { codel x(out a); codel y(in a); }; };");
    // Nobody reads it: not later, not this member, not as an input.
    warned("W0902", &activity("codel<start> x(inout n) yield ether;"));
    warned(
        "W0902",
        &activity("codel<start> x(in n) yield main; codel<main> y(out n) yield ether;"),
    );
    warned(
        "W0902",
        &activity("codel<start> x(out n.a) yield main; codel<main> y(in n.b) yield ether;"),
    );
    warned("W0902", &activity("codel<start> x(out n) yield pause::start, ether;"));
    warned("W0902", "component c { function f(in long a) { codel y(in a); codel x(out a); }; };");
}

#[test]
fn a_member_that_is_given_two_values_is_told() {
    let text = |value: &str| {
        format!(
            "struct s {{ double dp, dq; long v[3]; }};
             component c {{ function f(in s a = {value}) {{ codel x(in a); }}; }};"
        )
    };
    warned("W0907", &text("{ .dq = 5, .dp = 1, .dq = 20 }"));
    warned("W0907", &text("{ .dq = 5, .dp = 1, 20 }"));
    warned("W0907", &text("{ .v = { [0] = 1, [2] = 2, [0] = 3 } }"));
    accepted(&text("{ .dq = 5 : \"gain\", .dp = 1, .v = { 1, 2, 3 } }"));
    accepted(&text("{ .dq =: \"gain\", .dq = 5 }"));
    let both = "component c { struct s { long a; }; ids { s x; };
         attribute g(in x.a = 1); attribute h(in x = { .a = 1 }, in x.a::y = 2); };";
    accepted(both);
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
