//! E04xx: components and interfaces (rows I of genom3.md 3.4).

use super::row::{Explanation, row};

pub(super) const ROWS: &[Explanation] = &[
    row(
        "E0401",
        "I1",
        "a component is reopened as an interface, or the reverse",
        "A name stands for one of them.",
        "interface i { };\ncomponent i { };",
    ),
    row(
        "E0402",
        "I2",
        "an interface is unknown",
        "It must be declared before, often in an included file.",
        "component demo { provides nothing; };",
    ),
    row(
        "E0403",
        "I3",
        "a component is no interface",
        "`provides`, `uses` and `extends` take interfaces.",
        "component a { };\ncomponent b { provides a; };",
    ),
    row(
        "E0404",
        "I4",
        "an interface is named twice",
        "Name it once in each list.",
        "interface i { };\ncomponent demo { provides i, i; };",
    ),
    row(
        "E0405",
        "I5",
        "an interface brings a property that is already given",
        "Properties such as `version`, `period` or a codel have one value, wherever it comes \
         from.",
        "interface i { version \"1\"; };\ncomponent demo { version \"2\"; provides i; };",
    ),
    row(
        "E0406",
        "I6",
        "`#pragma provides` names no interface",
        "The interface must be declared before the pragma.",
        "#pragma provides nothing\ncomponent demo { };",
    ),
    row(
        "E0407",
        "I7",
        "the ids already have this member",
        "`ids` may be given in several pieces, and interfaces may add members: their names must \
         differ.",
        "component demo { ids { long a; }; ids { short a; }; };",
    ),
    row(
        "E0408",
        "",
        "a description takes too much memory",
        "Types, values, services and codels may take 128 MiB. Interfaces that extend each other, \
         or that many components provide, hand on all that they have each time.",
        "",
    ),
];
