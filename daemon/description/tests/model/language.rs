//! Everything that genom3.md section 2 allows is accepted.

use genom_description::model::{Ix as _, ServiceIx};
use serde_json::json;

use super::{component, plain};

#[test]
fn every_production_of_the_grammar_reads() {
    plain(include_str!("everything.gen"));
}

#[test]
fn contextual_keywords_name_anything() {
    plain(
        "struct task { long period, delay, ids; string doc; };
         component component { struct interface { long validate; };
           typedef long port;
           ids { port in; interface out; task inout; sequence<task> local; };
           port in port data; task task { period 1 s; };
           attribute attribute(in in, out out.validate::async);
           function function(in port in, out task codel) {
             local port local; codel yield(local in in, local out local, ids out inout); };
           activity activity(in port s, in port ms, in port us) { task task;
             codel<start> throws(in s, in ms) yield pause, pause::pause, ether;
             codel<pause> yields(in us) yield ether;
             after function; before attribute; interrupts activity; }; };",
    );
}

#[test]
fn constants_are_computed_as_written() {
    let specification = plain(
        "const long a = 2 + 3 * 4 - (1 << 3) / 2; const boolean b = ~FALSE;
         const unsigned long c = 0x10 | 010 ^ 1 & 3; const double d = 1 / 2.0;
         enum e { A, B }; module m { const e x = ::B; const long y = -a % 4; };
         const string s = \"a\" \"b\"; const char ch = \"x\"; const float f = -1;
         const long long big = 9223372036854775807; const octet o = compl 0 bitand 255;
         const long back = m::y;",
    );
    let value = |name: &str| {
        let found = specification.constants.iter().find(|c| c.name.to_string() == name);
        found.unwrap().value.clone()
    };
    assert_eq!(value("::a"), json!(10));
    assert_eq!(value("::b"), json!(true));
    assert_eq!(value("::c"), json!(0x10 | (0o10 ^ 1)));
    assert_eq!(value("::d"), json!(0.5));
    assert_eq!(value("::m::x"), json!("B"));
    assert_eq!(value("::m::y"), json!(-2));
    assert_eq!(value("::s"), json!("ab"));
    assert_eq!(value("::ch"), json!("x"));
    assert_eq!(value("::f"), json!(-1.0));
    assert_eq!(value("::big"), json!(i64::MAX));
    assert_eq!(value("::o"), json!(255));
    assert_eq!(value("::back"), json!(-2));
}

#[test]
fn wraps_like_the_tool() {
    let specification = plain("const unsigned long long a = 1 - 2; const long long b = -1 + 0;");
    assert_eq!(specification.constants[0].value, json!(u64::MAX));
    assert_eq!(specification.constants[1].value, json!(-1));
}

#[test]
fn recursion_goes_through_sequences_of_announced_types() {
    let specification = plain(
        "struct tree; union leaf; typedef sequence<tree> trees; typedef tree shrub;
         struct tree { trees kids; sequence<leaf, 2> leaves; };
         union leaf switch (boolean) { case TRUE: long a; default: trees b; };
         component c { ids { tree root; shrub other; }; port out tree p; };",
    );
    assert_eq!(component(&specification, "c").ports.len(), 1);
}

#[test]
fn several_validates_run_in_order_and_attributes_may_have_codels() {
    let specification = plain(
        "component c { ids { long x; };
           attribute at(in x) { validate a(local in x); validate b(ids in x); codel d(ids in x); };
           codels-require \"a\"; codels-requires \"b\"; };",
    );
    let c = component(&specification, "c");
    let names: Vec<_> = c.services[ServiceIx::new(0)]
        .validates
        .iter()
        .map(|rank| c.codels[*rank].name.as_str())
        .collect();
    assert_eq!(names, ["a", "b"]);
    assert_eq!(c.codels_requires, ["a", "b"]);
}

#[test]
fn a_component_as_people_write_them_reads() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/model/real/flyer.gen");
    // Requiring this package would need it to be installed: `require` only lists it.
    let specification = super::legal(genom_description::read(&[path], &Default::default()));
    let flyer = component(&specification, "flyer");
    assert_eq!(flyer.remotes.len(), 1);
    assert_eq!(flyer.doc.as_deref(), Some("Flies.\\nOr not."));
    assert_eq!(flyer.tasks.len(), 2);
    assert_eq!(specification.masquerades.len(), 1);
}

#[test]
fn types_and_services_masquerade() {
    let read = |pragma: &str| {
        let text = format!(
            "component c {{ struct pose {{ double x; }}; ids {{ boolean on; }}; \
             attribute enable(in on); }};\n#pragma masquerade ros2 {pragma}\n"
        );
        genom_description::read_text("c.gen", &text, &Default::default())
    };
    for (pragma, name, is_type) in [
        ("c::pose geometry_msgs/msg/Pose", "::c::pose", true),
        ("c::enable std_srvs/srv/SetBool", "::c::enable", false),
    ] {
        let analysis = read(pragma);
        assert!(!analysis.has_errors(), "{:?}", analysis.diagnostics);
        let [one] = &analysis.specification.masquerades[..] else { panic!("{pragma}") };
        assert_eq!((one.name.to_string().as_str(), one.ty.is_some()), (name, is_type));
    }
    // genom3.md 1.3: the type must resolve where the pragma stands. Components of other
    // laboratories have it in the module, after the typedef that it means.
    let text = "module sensor {\n  struct raw { octet byte; };\n  typedef raw Image;\n\
        #pragma masquerade ros Image sensor_msgs/Image\n  module more {\n\
        #pragma masquerade ros2 raw sensor_msgs/msg/Raw\n  };\n};\n";
    let analysis = genom_description::read_text("sensor.idl", text, &Default::default());
    assert!(!analysis.has_errors(), "{:?}", analysis.diagnostics);
    let told: Vec<_> = analysis.specification.masquerades.iter().map(|m| &*m.data).collect();
    assert_eq!(told, ["sensor_msgs/Image", "sensor_msgs/msg/Raw"]);
    for pragma in ["c::pose std_srvs/srv/SetBool", "c::enabel a/srv/B", "d::x a/action/B"] {
        let analysis = read(pragma);
        let codes: Vec<_> = analysis.diagnostics.iter().map(|said| said.code).collect();
        assert!(codes.contains(&"E0206"), "{pragma}: {codes:?}");
    }
}
