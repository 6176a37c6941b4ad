//! E01xx: characters and statements (rows L of genom3.md 3.1).

use super::row::{Explanation, row};

pub(super) const ROWS: &[Explanation] = &[
    row(
        "E0101",
        "L1",
        "a character has no meaning",
        "Outside strings and comments only ASCII letters, digits, `_` and the signs of the \
         language may stand. Often a character was pasted from a text processor.",
        "component demo { doc \u{201c}robot\u{201d}; };",
    ),
    row(
        "E0102",
        "L2",
        "a comment is never closed",
        "GenoM3 silently ignores everything after such a comment; genomd refuses it.",
        "/* my robot\ncomponent demo { };",
    ),
    row(
        "E0103",
        "L3",
        "a statement cannot be understood here",
        "The message names what was found and what may stand there. Reading goes on after the \
         statement.",
        "component demo { port long x; };",
    ),
    row(
        "E0104",
        "L4",
        "a file holds components, interfaces and IDL definitions",
        "At the outermost level only `component`, `interface` and definitions of types, \
         constants and modules may stand (and ports, services and tasks in the papers' dialects).",
        "robot demo { };",
    ),
    row(
        "E0105",
        "L5",
        "the file ends in the middle of a statement",
        "A `;` or a closing brace is missing: the message tells where the statement began.",
        "component demo {\n  version \"1.0\";",
    ),
    row(
        "E0106",
        "L6",
        "a semicolon is missing",
        "Every statement ends with `;`, also after a closing brace.",
        "typedef long distance\ntypedef long angle;",
    ),
    row(
        "E0107",
        "L7",
        "a property cannot be understood",
        "Properties are `name value;` inside the braces of a component, task, port or service.",
        "component demo { task main { colour \"red\"; }; };",
    ),
    row(
        "E0108",
        "L8",
        "a codel of a state machine must yield",
        "`codel<event> name(...) yield a, b;` lists every state the codel may go to.",
        "component demo { task main { codel<start> init(); }; };",
    ),
    row(
        "E0109",
        "L9",
        "there are no fixed point numbers",
        "`fixed` and numbers that end in `d` are reserved and have no C mapping: use `double`.",
        "typedef fixed<8,2> money;",
    ),
    row(
        "E0110",
        "L10",
        "the body of a type cannot be understood",
        "Members are `type name, name[3];`.",
        "struct s { long; };",
    ),
    row(
        "E0111",
        "L11",
        "the ids cannot be understood",
        "`ids { ... };` holds at least one member, written as in a struct.",
        "component demo { ids { }; };",
    ),
    row(
        "E0112",
        "L12",
        "a parameter cannot be understood",
        "Parameters of services are `in long x`, those of attributes `in x` and those of codels \
         `in x`, `ids in x.y::name`, `local in x`, `port in p`, `remote in r` or `in ::ids`.",
        "component demo { function f(long x) { codel c(); }; };",
    ),
    row(
        "E0113",
        "",
        "a construction is nested too deeply",
        "Types, expressions and initialisers inside each other have a limit, which the message \
         tells. Name the inner parts with `typedef` or `const`.",
        "",
    ),
    row(
        "E0114",
        "",
        "a string is never closed",
        "A string may go over several lines, so the quote that is missing may stand much \
         earlier: the message points at the first string that does.",
        "const string name = \"robot;",
    ),
    row(
        "E0115",
        "",
        "a character literal is not one character",
        "Write `'x'`, or one of the escapes of C (`'\\n'`, `'\\0'`, `'\\x41'`). A text is \
         written between double quotes.",
        "const char c = 'ab';",
    ),
    row(
        "E0116",
        "",
        "a number cannot be represented",
        "Integers have 64 bits, and those that begin with 0 are octal.",
        "const unsigned long long big = 99999999999999999999;",
    ),
    row(
        "E0117",
        "",
        "a name is too long",
        "Names have at most 1024 characters. Such a name is made by `##`, or by a tool.",
        "",
    ),
];
