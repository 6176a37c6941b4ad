//! E05xx: properties (rows P of genom3.md 3.5).

use super::row::{Explanation, row};

pub(super) const ROWS: &[Explanation] = &[
    row(
        "E0501",
        "P1",
        "a component has no such property",
        "Periods, priorities, codels and the like belong to tasks and services.",
        "component demo { period 5 ms; };",
    ),
    row(
        "E0502",
        "P2",
        "a task has no such property",
        "A task takes `doc`, `period`, `delay`, `priority`, `scheduling`, `stack`, `throw` and \
         state machine codels.",
        "component demo { task main { version \"1\"; }; };",
    ),
    row(
        "E0503",
        "P3",
        "a task has no simple codels",
        "The codels of a task are states of its permanent activity: `codel<start> ...`.",
        "component demo { task main { codel init(); }; };",
    ),
    row(
        "E0504",
        "P4",
        "a port has no such property",
        "A port takes `doc` only.",
        "typedef long t;\ncomponent demo { port in t p { period 5 ms; }; };",
    ),
    row(
        "E0505",
        "P5",
        "a service has no such property",
        "A service takes `doc`, `task`, `interrupts`, `before`, `after`, `throw`, `validate`, \
         codels and `local`.",
        "component demo { function f() { period 5 ms; }; };",
    ),
    row(
        "E0506",
        "P6",
        "a property is given twice",
        "Only `doc`, `require`, `throw`, `interrupts`, `provides`, `uses` and `extends` add up.",
        "component demo { version \"1\"; version \"2\"; };",
    ),
    row(
        "E0508",
        "P8",
        "a time is negative or no number",
        "Periods, delays and clock rates are positive times.",
        "component demo { task main { period -1; }; };",
    ),
    row(
        "E0509",
        "P9",
        "a delay without period",
        "A delay shifts a task within its period. GenoM3's tool crashes here.",
        "component demo { task main { delay 1 ms; }; };",
    ),
    row(
        "E0510",
        "P10",
        "a delay as long as the period",
        "A delay shifts a task within its period.",
        "component demo { task main { period 1 ms; delay 2 ms; }; };",
    ),
    row(
        "E0511",
        "P11",
        "a period is no multiple of the clock rate",
        "Ticks of a task fall on ticks of the clock. Without `clock-rate` a fitting one is \
         computed.",
        "component demo { clock-rate 2 ms; task main { period 3 ms; }; };",
    ),
    row(
        "E0512",
        "P12",
        "no clock rate suits all periods",
        "The greatest common divisor of the periods and of one second is below a microsecond.",
        "component demo { task main { period 0.0000001; }; };",
    ),
    row(
        "E0513",
        "P13",
        "a service names an unknown task",
        "The task must be declared before the service.",
        "component demo { activity a() { task main; codel<start> c() yield ether; }; };",
    ),
    row(
        "E0514",
        "P14",
        "what is thrown is no exception",
        "`throw` lists exceptions declared before.",
        "typedef long t;\ncomponent demo { function f() { throw t; }; };",
    ),
    row(
        "E0515",
        "P15",
        "an exception is listed twice",
        "Name it once in each list.",
        "exception e;\ncomponent demo { function f() { throw e, e; }; };",
    ),
    row(
        "E0516",
        "P16",
        "a service is listed twice",
        "Name it once in each `interrupts`, `before` or `after` list.",
        "component demo { function f() { interrupts f, f; }; };",
    ),
    row(
        "E0517",
        "P17",
        "a list names an unknown service",
        "`interrupts`, `before` and `after` name services of the component, declared anywhere \
         in it, or `all`.",
        "component demo { function f() { after nothing; }; };",
    ),
];
