//! Descriptions that repeat one construct: checking each must take linear time.

fn rep(n: usize, f: impl Fn(usize) -> String) -> String {
    (0..n).map(f).collect()
}
/// A shape and its text, by number of repetitions.
pub(crate) type Shape = (&'static str, fn(usize) -> String);

pub(crate) fn all() -> Vec<Shape> {
    vec![
        ("codels in function", |n| {
            format!(
                "component c {{ function f() {{ {} }}; }};",
                rep(n, |i| format!("codel x{i}();\n"))
            )
        }),
        ("reopened ids", |n| {
            format!("component c {{ {} }};", rep(n, |i| format!("ids {{ long x{i}; }};\n")))
        }),
        ("reopened ids+attr", |n| {
            format!(
                "component c {{ {} }};",
                rep(n, |i| format!("ids {{ long x{i}; }}; attribute a{i}(in x{i});\n"))
            )
        }),
        ("struct members", |n| format!("struct s {{ {} }};", rep(n, |i| format!("long x{i};\n")))),
        ("enumerators", |n| format!("enum e {{ {} z }};", rep(n, |i| format!("x{i},\n")))),
        ("union cases", |n| {
            format!("union u switch(long) {{ {} }};", rep(n, |i| format!("case {i}: long x{i};\n")))
        }),
        ("reopened component", |n| rep(n, |i| format!("component c {{ function f{i}(); }};\n"))),
        ("states in activity", |n| {
            format!(
                "component c {{ task t; activity a() {{ task t; codel<start> s() yield x0; {} codel<x{n}> e() yield ether; }}; }};",
                rep(n, |i| format!("codel<x{i}> y{i}() yield x{};\n", i + 1))
            )
        }),
        ("states in task", |n| {
            format!(
                "component c {{ task t {{ async codel<start> s() yield x0; {} codel<x{n}> e() yield ether; }}; }};",
                rep(n, |i| format!("codel<x{i}> y{i}() yield x{};\n", i + 1))
            )
        }),
        ("tasks", |n| {
            format!("component c {{ {} }};", rep(n, |i| format!("task t{i} {{ period 1 ms; }};\n")))
        }),
        ("codel params", |n| {
            format!(
                "component c {{ ids {{ {} }}; function f() {{ codel x({} out y); }}; }};",
                rep(n, |i| format!("long x{i};\n")) + "long y;",
                rep(n, |i| format!("in x{i},\n"))
            )
        }),
        ("interfaces", |n| {
            rep(n, |i| format!("interface i{i} {{ function f{i}(); }};\n"))
                + &format!("component c {{ {} }};", rep(n, |i| format!("provides i{i};\n")))
        }),
        ("components", |n| rep(n, |i| format!("component c{i};\n"))),
        ("exceptions thrown", |n| {
            format!(
                "component c {{ {} {} }};",
                rep(n, |i| format!("exception e{i};\n")),
                rep(n, |i| format!("function f{i}() {{ throw e{i}; }};\n"))
            )
        }),
        ("one member", |n| {
            format!(
                "component c {{ ids {{ long x; }}; {} }};",
                rep(n, |i| format!("attribute f{i}(in x);\n"))
            )
        }),
        ("one task one member", |n| {
            format!(
                "component c {{ ids {{ long x; }}; task t; {} }};",
                rep(n, |i| format!(
                    "activity f{i}() {{ task t; codel<start> x{i}(inout x) yield ether; }};\n"
                ))
            )
        }),
        ("unknown types", |n| rep(n, |i| format!("typedef nope{i} x{i};\n"))),
        ("syntax errors", |n| rep(n, |i| format!("typedf nope{i} x{i};\n"))),
        ("typedef chain", |n| {
            "typedef long t0;\n".to_owned() + &rep(n, |i| format!("typedef t{i} t{};\n", i + 1))
        }),
        ("interrupt list", |n| {
            format!(
                "component c {{ {} function g() {{ interrupts f0{}; }}; }};",
                rep(n, |i| format!("function f{i}();\n")),
                rep(n - 1, |i| format!(", f{}\n", i + 1))
            )
        }),
        ("initialiser", |n| {
            format!(
                "component c {{ function f(in sequence<long> x = {{ {} 1 }}); }};",
                rep(n, |i| format!("{i},\n"))
            )
        }),
        ("paper", |n| {
            format!(
                "component c {{ language: \"c\"; }}; ids s {{ {} }}; task t; {}",
                rep(n, |i| format!("long x{i};\n")),
                rep(n, |i| format!(
                    "service f{i}(in x{i}) {{ task: t; codel start: g{i}(in x{i}) yield ether; }}\n"
                ))
            )
        }),
    ]
}
