//! Generates descriptions of any length: one component with thousands of structs, attributes and
//! activities.

use std::fmt::Write as _;

/// A legal description of about `lines` lines.
pub(crate) fn description(lines: usize) -> String {
    // Lines of one block: its structs, members, attribute, function and activity.
    const BLOCK: usize = 24;
    let blocks = (lines / BLOCK).max(1);
    let mut text = String::from("const long size = 4;\ncomponent big {\n  version \"1.0\";\n");
    let mut put = |line: std::fmt::Arguments<'_>| _ = writeln!(text, "{line}");
    put(format_args!("  exception failed {{ string<64> why; }};"));
    for n in 0..blocks {
        put(format_args!("  struct s{n} {{"));
        put(format_args!("    long a, b[size];"));
        put(format_args!("    double c;"));
        put(format_args!("    sequence<long, {}> d;", n % 7 + 1));
        put(format_args!("  }};"));
        put(format_args!("  port out s{n} p{n};"));
    }
    put(format_args!("  ids {{"));
    for n in 0..blocks {
        put(format_args!("    s{n} m{n};"));
    }
    put(format_args!("  }};"));
    for n in 0..8 {
        put(format_args!("  task t{n} {{ period {} ms; }};", n + 1));
    }
    for n in 0..blocks {
        put(format_args!("  attribute set_{n}(in m{n}.a = {n} : \"value {n}\", out m{n}.c) {{"));
        put(format_args!("    doc \"Sets {n}\";"));
        put(format_args!("    validate check_{n}(local in a);"));
        put(format_args!("  }};"));
        put(format_args!("  function calc_{n}(in long x = {n}, out double y) {{"));
        put(format_args!("    codel calc_one_{n}(in x, out y, ids in m{n}.a::z);"));
        put(format_args!("  }};"));
        put(format_args!(
            "  activity run_{n}(in s{n} goal = {{ .a = 1, .b = {{1, 2}} }}, out long r) {{"
        ));
        put(format_args!("    task t{};", n % 8));
        put(format_args!("    codel<start> start_{n}(in goal, out m{n}.c::speed) yield main;"));
        put(format_args!("    codel<main> main_{n}(inout m{n}, out p{n}, out r)"));
        put(format_args!("      yield pause::main, ether, step_{n};"));
        put(format_args!("    codel<step_{n}> step_{n}(in m{n}) yield main;"));
        put(format_args!("    codel<stop> stop_{n}() yield ether;"));
        put(format_args!("    interrupts run_{n};"));
        put(format_args!("    throws failed;"));
        put(format_args!("  }};"));
    }
    put(format_args!("}};"));
    text
}
