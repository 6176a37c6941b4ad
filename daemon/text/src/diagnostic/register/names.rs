//! E02xx: names, scopes and types (rows N of genom3.md 3.2).

use super::row::{Explanation, row};

pub(super) const ROWS: &[Explanation] = &[
    row(
        "E0201",
        "N1",
        "a name is already taken in its scope",
        "Types, constants, enumerators, ports, remotes, states and `ids` of one component share \
         one name space; so do the members of one struct.",
        "typedef long t;\ntypedef short t;",
    ),
    row(
        "E0202",
        "N2",
        "a name is that of the enclosing module or component",
        "Inside `m`, the name `m` would hide the module itself.",
        "module m { typedef long m; };",
    ),
    row(
        "E0203",
        "N3",
        "a module or type is named like the scope it is in",
        "Give the inner one another name.",
        "module m { module m { typedef long t; }; };",
    ),
    row(
        "E0204",
        "N4",
        "a type is named like a module",
        "Components are modules too, and every component holds a module `pause`.",
        "module m { typedef long t; };\ntypedef long m;",
    ),
    row(
        "E0205",
        "N5",
        "a struct, union, exception or module is named like a type",
        "Only a forward declaration (`struct s;`) may come before the definition.",
        "typedef long s;\nstruct s { long a; };",
    ),
    row(
        "E0206",
        "N6",
        "a name is unknown",
        "Names are looked up in the current scope, then outwards; `::name` starts from the \
         outermost one. What a name stands for must be declared before it is used. Types of an \
         interface need its name: `i::t`.",
        "typedef lnog distance;",
    ),
    row(
        "E0207",
        "N7",
        "a type is used before it is complete",
        "After `struct s;` only `sequence<s>` may use `s`, until its members are given.",
        "struct s;\nstruct t { s member; };\nstruct s { long a; };",
    ),
    row(
        "E0208",
        "N8",
        "an announced type is never defined",
        "`struct s;` promises a definition in the same specification.",
        "struct s;",
    ),
    row(
        "E0209",
        "N9",
        "a type is defined twice",
        "A struct or union has one definition. Guard files that may be included twice.",
        "struct s;\nstruct s { long a; };\nstruct s { long a; };",
    ),
    row(
        "E0210",
        "N10",
        "a type is announced in one file and defined in another",
        "Both must stand in the same source file.",
        "",
    ),
    row(
        "E0211",
        "N11",
        "an exception without members is no data type",
        "Only an exception with members has a value that can be stored.",
        "exception e;\ntypedef e t;",
    ),
    row(
        "E0212",
        "N12",
        "a declared name holds `::`",
        "Declare the name inside its module instead.",
        "",
    ),
    row(
        "E0213",
        "N13",
        "an enumerator is already taken",
        "Enumerators live in the scope around their enum, not inside it.",
        "enum a { RED };\nenum b { RED };",
    ),
    row(
        "E0216",
        "5.2",
        "a type of a component has no place in memory",
        "It contains itself by value, or is larger than 1 GiB: no daemon could load the component. \
         Use an unbounded sequence.",
        "component demo { ids { demo::ids again; }; };",
    ),
];
