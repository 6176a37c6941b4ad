//! E07xx: codels and their parameters (rows K of genom3.md 3.7).

use super::row::{Explanation, row};

pub(super) const ROWS: &[Explanation] = &[
    row(
        "E0701",
        "K1",
        "one codel with two prototypes",
        "A codel is one C function: wherever its name is used, its parameters have the same \
         directions and types.",
        "component demo { ids { long a; short b; }; function f() { codel c(in a); }; \
         function g() { codel c(in b); }; };",
    ),
    row(
        "E0702",
        "K2",
        "a codel is used twice in one service",
        "Give each use its own function.",
        "component demo { function f() { codel c(); codel c(); }; };",
    ),
    row(
        "E0703",
        "K3",
        "an event is listed twice",
        "Name it once in each list.",
        "component demo { task main { codel<start> c() yield ether, ether; }; };",
    ),
    row(
        "E0704",
        "K4",
        "a codel cannot start on a pause",
        "`pause::x` is yielded; the codel that then runs is `codel<x>`.",
        "component demo { task main { codel<pause::start> c() yield ether; }; };",
    ),
    row(
        "E0705",
        "K5",
        "the end cannot be paused",
        "`ether` ends the activity at once.",
        "component demo { task main { codel<start> c() yield pause::ether; }; };",
    ),
    row(
        "E0706",
        "K6",
        "a state is named like something else",
        "States share their names with types, ports and constants of the component.",
        "component demo { typedef long go; task main { codel<start> c() yield go; \
         codel<go> d() yield ether; }; };",
    ),
    row(
        "E0707",
        "K7",
        "a state has two codels",
        "Each state of a state machine runs one codel.",
        "component demo { task main { codel<start> c() yield ether; \
         codel<start> d() yield ether; }; };",
    ),
    row(
        "E0708",
        "K8",
        "an activity has no `codel<start>`",
        "An activity begins in the state `start`.",
        "component demo { task main; activity a() { task main; codel<stop> c() yield ether; }; };",
    ),
    row(
        "E0709",
        "K9",
        "a codel yields to a state without codel",
        "Every state but `ether` runs a codel.",
        "component demo { task main { codel<start> c() yield nowhere; }; };",
    ),
    row(
        "E0710",
        "K10",
        "`codel<stop>` never reaches `ether`",
        "An activity that is asked to stop must be able to end.",
        "component demo { task main { codel<start> c() yield ether; \
         codel<stop> d() yield stop; }; };",
    ),
    row(
        "E0711",
        "K11",
        "a codel is never reached",
        "Neither `start` nor `stop` leads to any of its states. A codel of several states is reached \
         by one of them.",
        "component demo { task main { codel<start> c() yield ether; \
         codel<lost> d() yield ether; }; };",
    ),
    row(
        "E0712",
        "K12",
        "a parameter comes from nowhere",
        "It is looked for among the members of `ids`, the parameters of the service, ports and \
         remotes.",
        "component demo { ids { long speed; }; function f() { codel c(in sped); }; };",
    ),
    row(
        "E0713",
        "K13",
        "a parameter may come from several places",
        "Say which: `ids in x`, `local in x`, `port in x` or `remote in x`.",
        "component demo { ids { long a; }; function f(in long a) { codel c(in a); }; };",
    ),
    row(
        "E0714",
        "K14",
        "a parameter uses ids that are not declared",
        "`ids { ... };` must come before what uses it.",
        "component demo { function f() { codel c(ids in a); }; };",
    ),
    row(
        "E0715",
        "K15",
        "there is no such member",
        "The message names the type and its nearest member.",
        "struct s { long a; };\ncomponent demo { ids { s x; }; function f() { codel c(in x.b); }; };",
    ),
    row(
        "E0716",
        "K16",
        "an index into what is no array",
        "Arrays and sequences are indexed.",
        "component demo { ids { long x; }; function f() { codel c(in x[0]); }; };",
    ),
    row(
        "E0717",
        "K17",
        "an index is out of bounds",
        "Indices count from 0.",
        "component demo { ids { long x[2]; }; function f() { codel c(in x[2]); }; };",
    ),
    row(
        "E0718",
        "K18",
        "`local` names no parameter of the service",
        "`local` means a parameter or local variable of the service.",
        "component demo { ids { long a; }; function f() { codel c(local in a); }; };",
    ),
    row(
        "E0719",
        "K19",
        "a parameter names nothing",
        "`::name` alone is the whole ids; locals, ports and remotes must be named.",
        "component demo { function f(in long a) { codel c(local in ::b); }; };",
    ),
    row(
        "E0720",
        "K20",
        "there is no such port or remote",
        "Ports are declared in the component, remotes come from `uses`.",
        "component demo { task main { codel<start> c(port in p) yield ether; }; };",
    ),
    row(
        "E0721",
        "K21",
        "an in port is written",
        "A codel reads an in port: `in p`.",
        "typedef long t;\ncomponent demo { port in t p; task main { \
         codel<start> c(out p) yield ether; }; };",
    ),
    row(
        "E0722",
        "K22",
        "a member of a port or remote is asked for",
        "A codel gets the whole port: it reads members from `p->data(self)`.",
        "struct s { long a; };\ncomponent demo { port in s p; task main { \
         codel<start> c(in p.a) yield ether; }; };",
    ),
    row(
        "E0723",
        "K23",
        "a remote is written",
        "A codel calls a remote: `in r`.",
        "interface i { function r(); };\ncomponent demo { uses i; task main { \
         codel<start> c(out r) yield ether; }; };",
    ),
    row(
        "E0724",
        "K24",
        "an async codel shares data",
        "It may run for long, so nothing may have to wait for it: give it `local` parameters, \
         or data that nobody else uses.",
        "component demo { ids { long a; }; attribute set(in a); task main; activity f() { \
         task main; async codel<start> c(in a) yield ether; }; };",
    ),
    row(
        "E0725",
        "",
        "too many codels share data",
        "Which codels exclude each other is computed once; four million pairs are the limit. \
         Codels that take the whole ids exclude all others: name the members that they use.",
        "",
    ),
];
