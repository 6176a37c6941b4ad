//! Descriptions that follow the grammar but not the rules.

use proptest::prelude::*;

fn pick(words: &'static [&'static str]) -> BoxedStrategy<String> {
    prop::sample::select(words).prop_map(str::to_owned).boxed()
}

fn name() -> BoxedStrategy<String> {
    pick(&["a", "b", "c", "s", "t", "p", "start", "stop", "ether", "main", "task", "in", "pause"])
}

fn type_spec() -> BoxedStrategy<String> {
    let leaf = prop_oneof![
        pick(&["long", "octet", "double", "boolean", "string", "string<8>", "char", "any"]),
        name(),
    ];
    leaf.prop_recursive(3, 8, 2, |inner| {
        prop_oneof![
            inner.clone().prop_map(|t| format!("sequence<{t} >")),
            inner.clone().prop_map(|t| format!("sequence<{t}, 3>")),
            inner.clone().prop_map(|t| format!("optional<{t} >")),
            (name(), inner.clone(), name())
                .prop_map(|(s, t, m)| format!("struct {s} {{ {t} {m}, b[2]; }}")),
            (name(), name(), inner)
                .prop_map(|(u, m, t)| format!("union {u} switch (long) {{ case 1: {t} {m}; }}")),
        ]
    })
    .boxed()
}

fn value() -> BoxedStrategy<String> {
    let leaf = prop_oneof![pick(&["0", "1", "2.5", "\"x\"", "'c'", "TRUE", "-1", "0xff"]), name()];
    leaf.prop_recursive(3, 8, 3, |inner| {
        prop_oneof![
            (inner.clone(), pick(&["+", "-", "*", "/", "%", "<<", ">>", "|", "&"]), inner.clone())
                .prop_map(|(a, op, b)| format!("({a} {op} {b})")),
            inner.prop_map(|v| format!("~({v})")),
        ]
    })
    .boxed()
}

fn initial() -> BoxedStrategy<String> {
    value()
        .prop_recursive(3, 8, 3, |inner| {
            prop_oneof![
                prop::collection::vec(inner.clone(), 0..3)
                    .prop_map(|list| format!("{{ {} }}", list.join(", "))),
                (name(), inner.clone()).prop_map(|(m, v)| format!("{{ .{m} = {v} : \"doc\" }}")),
                inner.prop_map(|v| format!("{{ [1] = {v} }}")),
            ]
        })
        .boxed()
}

fn property() -> BoxedStrategy<String> {
    let source = pick(&["", "ids", "local", "port", "remote"]);
    let way = pick(&["in", "out", "inout"]);
    let parameter =
        (source, way, name(), name()).prop_map(|(s, w, n, m)| format!("{s} {w} {n}::{m}"));
    let codel = (name(), prop::collection::vec(parameter, 0..3))
        .prop_map(|(n, list)| format!("{n}({})", list.join(", ")));
    let list = prop::collection::vec(name(), 1..4).prop_map(|list| list.join(", "));
    prop_oneof![
        (pick(&["throws", "interrupts", "before", "after", "uses", "provides"]), list.clone())
            .prop_map(|(w, l)| format!("{w} {l};")),
        (pick(&["period", "delay", "clock-rate", "priority", "stack"]), value())
            .prop_map(|(w, v)| format!("{w} {v};")),
        name().prop_map(|t| format!("task {t};")),
        codel.clone().prop_map(|c| format!("validate {c};")),
        codel.clone().prop_map(|c| format!("codel {c};")),
        (list.clone(), codel, list).prop_map(|(a, c, b)| format!("codel<{a}> {c} yield {b};")),
        (type_spec(), name()).prop_map(|(t, n)| format!("local {t} {n};")),
    ]
    .boxed()
}

fn export() -> BoxedStrategy<String> {
    let body = prop::collection::vec(property(), 0..4).prop_map(|list| list.join(" "));
    let parameter = (pick(&["in", "out", "inout"]), type_spec(), name(), initial())
        .prop_map(|(w, t, n, v)| format!("{w} {t} {n} = {v}"));
    let parameters = prop::collection::vec(parameter, 0..3).prop_map(|list| list.join(", "));
    prop_oneof![
        (type_spec(), name()).prop_map(|(t, n)| format!("typedef {t} {n};")),
        (type_spec(), name(), value()).prop_map(|(t, n, v)| format!("const {t} {n} = {v};")),
        (type_spec(), name()).prop_map(|(t, n)| format!("ids {{ {t} {n}; }};")),
        (type_spec(), name()).prop_map(|(t, n)| format!("port out {t} {n};")),
        (name(), body.clone()).prop_map(|(n, b)| format!("task {n} {{ {b} }};")),
        (name(), name()).prop_map(|(n, v)| format!("attribute {n}(in {v}, out {v}.a::x);")),
        (pick(&["function", "activity"]), name(), parameters, body)
            .prop_map(|(k, n, p, b)| format!("{k} {n}({p}) {{ {b} }};")),
        name().prop_map(|n| format!("exception {n} {{ long a; }};")),
        name().prop_map(|n| format!("struct {n};")),
        name().prop_map(|n| format!("event {n};")),
        property(),
    ]
    .boxed()
}

pub(crate) fn specification() -> BoxedStrategy<String> {
    let exports = prop::collection::vec(export(), 0..8).prop_map(|list| list.join("\n  "));
    let statement = prop_oneof![
        (pick(&["component", "interface"]), name(), exports)
            .prop_map(|(k, n, e)| format!("{k} {n} {{\n  {e}\n}};")),
        export(),
        name().prop_map(|n| format!("#pragma provides {n}")),
    ];
    prop::collection::vec(statement, 0..5).prop_map(|list| list.join("\n")).boxed()
}
