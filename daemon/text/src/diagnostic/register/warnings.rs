//! Wxxxx: descriptions that are accepted but probably not meant so.

use super::row::{Explanation, row};

pub(super) const ROWS: &[Explanation] = &[
    row(
        "W0101",
        "2.1",
        "GenoM3 reads `5us` as five seconds",
        "GenoM3 2.99 takes the `u` as the suffix of an unsigned integer; genomd reads \
         microseconds. Put a blank between number and unit: both then agree.",
        "component demo { task main { period 500us; }; };",
    ),
    row(
        "W0102",
        "1.2",
        "the description says `#warning`",
        "Whoever wrote the description wants you to read this.",
        "#warning not tested on the robot",
    ),
    row(
        "W0103",
        "1.2",
        "a macro is defined twice",
        "The second definition holds from there on. Write `#undef` before it if this is meant.",
        "#define N 1\n#define N 2",
    ),
    row(
        "W0104",
        "",
        "a file is not UTF-8",
        "It is read as Latin-1, so that nothing is lost. Save it as UTF-8.",
        "",
    ),
    row(
        "W0105",
        "1.2",
        "a directive is unknown",
        "It is ignored, as by GenoM3.",
        "#inlcude \"types.gen\"",
    ),
    row(
        "W0106",
        "1.3",
        "a required package is not found, and `-I` is given",
        "The files of the package are looked for in the directories given with `-I`.",
        "",
    ),
    row(
        "W0309",
        "C9",
        "a case label is repeated",
        "The second one changes nothing.",
        "union u switch (long) { case 1: case 1: long a; default: long b; };",
    ),
    row(
        "W0507",
        "P7",
        "a package is required twice",
        "The second one changes nothing.",
        "component demo { require \"a\", \"a\"; };",
    ),
    row(
        "W0901",
        "3.10",
        "an activity cannot end by itself",
        "No way leads from `start` to `ether`: it ends only when it is interrupted. If that is \
         meant, nothing needs to be done.",
        "component demo { task main; activity run() { task main; \
         codel<start> c() yield pause::start; codel<stop> d() yield ether; }; };",
    ),
    row(
        "W0902",
        "3.10",
        "a codel writes what the service only takes in",
        "No codel reads it afterwards: what it writes is lost. Make the parameter of the service \
         `inout` or `out`, or that of the codel `in`. An activity that keeps something from one \
         codel to the next does so in a `local`.",
        "component demo { function f(in long a) { codel c(out a); }; };",
    ),
    row(
        "W0903",
        "3.10",
        "no codel uses a port",
        "Nobody will read or write it.",
        "component demo { typedef long level; port in level battery; };",
    ),
    row(
        "W0904",
        "3.10",
        "a value does not fit its type",
        "GenoM3 does not look: the value is cut to the size of the type.",
        "const octet a = 300;",
    ),
    row(
        "W0905",
        "3.10",
        "nothing runs in a task",
        "It has no codel of its own, and no activity names it.",
        "component demo { task main; };",
    ),
    row(
        "W0906",
        "3.10",
        "an activity loops and has no codel for `stop`",
        "Interrupted, it ends where it stands, with the exception `genom::interrupted`. With a \
         `codel<stop>` it ends in good order, and successfully.",
        "component demo { task main; activity run() { task main; \
         codel<start> c() yield pause::start, ether; }; };",
    ),
    row(
        "W0907",
        "3.10",
        "a member is given two values",
        "The last one holds. Remove the other.",
        "struct gains { double p, d; };\ncomponent demo { function set(in gains g = { .p = 1, \
         .p = 2 }); };",
    ),
    row(
        "W0908",
        "5.1",
        "a name is a word of C or C++",
        "Keywords and macros such as `errno` name nothing else in C: the header that codels are \
         compiled against does not compile. GenoM3 has the same header.",
        "struct state { long errno; };",
    ),
    row(
        "W0909",
        "5.1",
        "two names become one in C",
        "Scopes are joined by `_`: `a::b_c` and `a_b::c` are both `a_b_c`. GenoM3 drops the second \
         in silence; `genomctl header` refuses.",
        "module a { struct b_c { long x; }; };\nmodule a_b { struct c { double y; }; };",
    ),
];
