//! Wxxxx: what is accepted and surprising.

use super::{Explanation, row};

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
];
