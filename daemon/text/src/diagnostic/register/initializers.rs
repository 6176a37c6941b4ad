//! E08xx: default values (rows V of genom3.md 3.8).

use super::row::{Explanation, row};

pub(super) const ROWS: &[Explanation] = &[
    row(
        "E0801",
        "V1",
        "braces around the value of a scalar",
        "Braces initialise structs, unions, arrays and sequences.",
        "component demo { function f(in long a = {1}) { }; };",
    ),
    row(
        "E0802",
        "V2",
        "a scalar for a compound value",
        "Structs, unions, arrays and sequences want `{ ... }`.",
        "struct s { long a; };\ncomponent demo { function f(in s x = 1) { }; };",
    ),
    row(
        "E0803",
        "V3",
        "a default value has the wrong type",
        "The value must convert as for a constant of the type.",
        "component demo { function f(in long a = \"one\") { }; };",
    ),
    row(
        "E0804",
        "V4",
        "too many values",
        "There are more values than members.",
        "struct s { long a; };\ncomponent demo { function f(in s x = {1, 2}) { }; };",
    ),
    row(
        "E0805",
        "V5",
        "a value past the end of an array",
        "Indices count from 0.",
        "component demo { function f(in long a[2] = {[2] = 1}) { }; };",
    ),
    row(
        "E0806",
        "V6",
        "a value for an unknown member",
        "The message names the type and its nearest member.",
        "struct s { long a; };\ncomponent demo { function f(in s x = {.b = 1}) { }; };",
    ),
    row(
        "E0807",
        "V7",
        "an index in a struct",
        "Members of structs are initialised by name: `.a = 1`.",
        "struct s { long a; };\ncomponent demo { function f(in s x = {[0] = 1}) { }; };",
    ),
];
