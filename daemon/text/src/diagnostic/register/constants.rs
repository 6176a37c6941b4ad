//! E03xx: constants and unions (rows C of genom3.md 3.3).

use super::row::{Explanation, row};

pub(super) const ROWS: &[Explanation] = &[
    row(
        "E0301",
        "C1",
        "an operator does not apply",
        "`+ - * /` take numbers; `% | & ^ << >>` integers; `~` also takes a boolean. Booleans, \
         characters, strings and enumerators take no binary operator.",
        "const long n = 1 + TRUE;",
    ),
    row(
        "E0302",
        "C2",
        "a name in an expression is no constant",
        "Constants and enumerators may be used in expressions.",
        "typedef long t;\nconst long n = t;",
    ),
    row(
        "E0303",
        "C3",
        "a size is not a positive integer",
        "Sizes, indices, priorities and stacks are integers from 0 on (`2.0` counts as 2).",
        "typedef long t[-1];",
    ),
    row(
        "E0304",
        "C4",
        "a time or size is not a number",
        "Write a number and a unit: `s`, `ms` or `us` for times (seconds without unit), `k` or \
         `M` for sizes.",
        "component demo { clock-rate \"fast\"; };",
    ),
    row(
        "E0305",
        "C5",
        "a value cannot become the type wanted",
        "Booleans only come from booleans, integers from exact numbers of fitting sign, enums \
         from their enumerators, strings from strings.",
        "const boolean b = 1;",
    ),
    row(
        "E0306",
        "C6",
        "there are no constants of this type",
        "Constants are booleans, characters, numbers, strings and enums.",
        "struct s { long a; };\nconst s c = 1;",
    ),
    row(
        "E0307",
        "C7",
        "a union cannot switch on this type",
        "A union switches on a boolean, a character, an integer or an enum.",
        "union u switch (double) { case 1: long a; };",
    ),
    row(
        "E0308",
        "C8",
        "a case label does not fit the switch",
        "Each label is a value of the type that the union switches on.",
        "union u switch (long) { case TRUE: long a; };",
    ),
    row(
        "E0310",
        "C10",
        "a case label selects two members",
        "Each label, and `default`, stands before one member only.",
        "union u switch (long) { case 1: long a; case 1: long b; };",
    ),
    row(
        "E0311",
        "C11",
        "a union member is named like the switch type",
        "Give it another name; define the enum before the union.",
        "enum e { A };\nunion u switch (e) { case A: long e; };",
    ),
    row(
        "E0312",
        "",
        "a constant expression divides by zero",
        "GenoM3's tool crashes here.",
        "const long n = 1 / 0;",
    ),
];
