//! Arguments of codels: every row of genom3.md 5.5, called with checked values.

mod support;

use genom_description::model::Direction::{In, InOut, Out};
use genom_description::model::{Owner, PathStep, ServiceKind, Source};
use genom_types::{Kind, Label, ScopedName, UnionMember};
use serde_json::{Value, json};
use support::generator::Gen;
use support::load::load;

/// Runs `c`, a codel `f` with an `in` and an `out` parameter of this kind; returns the output.
#[track_caller]
fn through(kind: Kind, c: &str, input: Value) -> Value {
    let mut gen_ = Gen::new();
    let ty = gen_.ty(kind);
    let (service, codel) = gen_.function("f", &[(In, "x", ty), (Out, "y", ty)]);
    let c = format!(
        "#include <stdbool.h>\n#include <stdint.h>\n#include <stdlib.h>\n#include <string.h>\n\
         #include <genom3/c/context.h>\n{c}"
    );
    let (event, output) = load(gen_, &c).run(service, codel, json!({ "x": input }));
    assert_eq!(event, "");
    output["y"].clone()
}

/// The codel that doubles a number of this C type.
fn twice(ty: &str) -> String {
    format!("genom_event f({ty} x, {ty} *y, const genom_context self) {{ *y = 2 * x; return 0; }}")
}

#[test]
fn numbers_are_passed_by_value_with_sign_and_width() {
    let rows: [(Kind, &str, Value, Value); 10] = [
        (Kind::Char, "int8_t", json!("\u{3}"), json!("\u{6}")),
        (Kind::Octet, "uint8_t", json!(100), json!(200)),
        (Kind::Short, "int16_t", json!(-300), json!(-600)),
        (Kind::UnsignedShort, "uint16_t", json!(30000), json!(60000)),
        (Kind::Long, "int32_t", json!(-1_000_000_000), json!(-2_000_000_000)),
        (Kind::UnsignedLong, "uint32_t", json!(2_000_000_000), json!(4_000_000_000_u32)),
        (Kind::LongLong, "int64_t", json!(-4e18 as i64), json!(-8e18 as i64)),
        (Kind::UnsignedLongLong, "uint64_t", json!(5e18 as u64), json!(10e18 as u64)),
        (Kind::Float, "float", json!(0.25), json!(0.5)),
        (Kind::Double, "double", json!(-1e300), json!(-2e300)),
    ];
    for (kind, ty, input, output) in rows {
        assert_eq!(through(kind, &twice(ty), input), output, "{ty}");
    }
}

#[test]
fn a_boolean_is_a_c_bool() {
    let c = "genom_event f(bool x, bool *y, const genom_context self) { *y = !x; return 0; }";
    assert_eq!(through(Kind::Boolean, c, json!(true)), json!(false));
    assert_eq!(through(Kind::Boolean, c, json!(false)), json!(true));
}

#[test]
fn an_enum_counts_from_0() {
    let name = ScopedName::new(["m", "col"]);
    let kind = Kind::Enum { name, enumerators: ["RED", "GREEN"].map(String::from).into() };
    let c = "genom_event f(uint32_t x, uint32_t *y, const genom_context self)
             { *y = x == 0 ? 1 : 7; return 0; }";
    assert_eq!(through(kind, c, json!("RED")), json!("GREEN"));
}

#[test]
fn a_string_is_a_pointer_and_its_codel_replaces_it() {
    let c = "genom_event f(const char *x, char **y, const genom_context self)
             { if (*y) abort(); *y = malloc(32); strcpy(*y, x); strcat(*y, \"!\"); return 0; }";
    assert_eq!(through(Kind::String { bound: None }, c, json!("hello")), json!("hello!"));
}

#[test]
fn a_bounded_string_is_the_address_of_its_bytes() {
    let c = "genom_event f(const char x[8], char y[8], const genom_context self)
             { strncpy(y, x + 1, 8); return 0; }";
    assert_eq!(through(Kind::String { bound: Some(8) }, c, json!("hello")), json!("ello"));
}

#[test]
fn an_array_is_the_address_of_its_elements() {
    let mut gen_ = Gen::new();
    let long = gen_.ty(Kind::Long);
    let row = gen_.ty(Kind::Array { element: long, length: 3 });
    let arr2 = gen_.ty(Kind::Array { element: row, length: 2 });
    let (service, codel) = gen_.function("f", &[(In, "l", arr2), (Out, "m", arr2)]);
    let c = "#include <stdint.h>\n#include <genom3/c/context.h>
        typedef int32_t demo_arr2[2][3];
        genom_event f(const demo_arr2 l, demo_arr2 m, const genom_context self) {
          for (int i = 0; i < 2; i++) for (int j = 0; j < 3; j++) m[i][j] = 10 * i + j + l[i][j];
          return 0;
        }";
    let input = json!({ "l": [[100, 100, 100], [200, 200, 200]] });
    let (_, output) = load(gen_, c).run(service, codel, input);
    assert_eq!(output, json!({ "m": [[100, 101, 102], [210, 211, 212]] }));
}

#[test]
fn sequences_optionals_structs_and_unions_are_addresses() {
    let mut gen_ = Gen::new();
    let long = gen_.ty(Kind::Long);
    let double = gen_.ty(Kind::Double);
    let text = gen_.string(None);
    let sequence = gen_.sequence(long, None);
    let bounded = gen_.sequence(double, Some(4));
    let optional = gen_.ty(Kind::Optional { element: long });
    let structure = gen_.structure("s", &[("a", long), ("b", text)]);
    let members = vec![
        UnionMember { name: "i".into(), ty: long, labels: vec![Label::Value(1)] },
        UnionMember { name: "d".into(), ty: double, labels: vec![Label::Default] },
    ];
    let union = gen_.union("u", long, members);
    let types =
        [("sq", sequence), ("bs", bounded), ("op", optional), ("st", structure), ("un", union)];
    let parameters: Vec<_> = types.iter().flat_map(|(n, t)| [(In, *n, *t)]).collect();
    let outs = ["osq", "obs", "oop", "ost", "oun"];
    let parameters: Vec<_> =
        parameters.into_iter().chain(outs.iter().zip(types).map(|(n, t)| (Out, *n, t.1))).collect();
    let (service, codel) = gen_.function("f", &parameters);
    let c = r#"
        #include <stdbool.h>
        #include <genom3/c/idlsequence.h>
        #include <genom3/c/context.h>
        typedef struct { uint32_t _maximum, _length; int32_t *_buffer; void (*_release)(void *); } sq;
        typedef struct { const uint32_t _maximum; uint32_t _length; double _buffer[4]; } bs;
        typedef struct { bool _present; int32_t _value; } op;
        typedef struct { int32_t a; char *b; } st;
        typedef struct { int32_t _d; union { int32_t i; double d; } _u; } un;
        genom_event f(const sq *s, const bs *b, const op *o, const st *t, const un *u,
                      sq *os, bs *ob, op *oo, st *ot, un *ou, const genom_context self) {
          if (genom_sequence_reserve(os, s->_length)) return "::demo::memory";
          os->_length = s->_length;
          for (uint32_t i = 0; i < s->_length; i++) os->_buffer[i] = -s->_buffer[i];
          if (ob->_maximum != 4) return "::demo::maximum";
          ob->_length = b->_length + 1;
          ob->_buffer[b->_length] = 0.5;
          oo->_present = !o->_present;
          oo->_value = 5;
          ot->a = t->a + 1;
          ot->b = strdup(t->b);
          ou->_d = 1 - u->_d;
          ou->_u.d = u->_u.i / 2.;
          return 0;
        }"#;
    let loaded = load(gen_, c);
    let input = json!({
        "sq": [1, 2, 3], "bs": [], "op": null, "st": { "a": 41, "b": "text" },
        "un": { "d": 1, "u": { "i": 3 } },
    });
    let (event, output) = loaded.run(service, codel, input);
    assert_eq!(event, "");
    let expected = json!({
        "osq": [-1, -2, -3], "obs": [0.5], "oop": 5, "ost": { "a": 42, "b": "text" },
        "oun": { "d": 0, "u": { "d": 1.5 } },
    });
    assert_eq!(output, expected);
}

#[test]
fn a_native_is_a_pointer_of_the_codels() {
    let mut gen_ = Gen::new();
    let native = gen_.ty(Kind::Native { name: ScopedName::new(["demo", "opaque"]) });
    let long = gen_.ty(Kind::Long);
    gen_.ids(&[("nat", native)]);
    let service = gen_.service(ServiceKind::Function, "s", &[(Out, "y", long)], &[("lo", native)]);
    let owner = Owner::Service(service);
    let ids = |step| Source::Ids { path: vec![PathStep::Member(step)] };
    let lo = Source::Local { index: 0, path: vec![] };
    let out = Source::Parameter { index: 0, path: vec![] };
    let make =
        gen_.codel(owner, "make", &[(Out, "nat", native, ids(0)), (Out, "lo", native, lo.clone())]);
    let read = gen_.codel(
        owner,
        "read_",
        &[(In, "nat", native, ids(0)), (In, "lo", native, lo), (Out, "y", long, out)],
    );
    let c = "#include <stdint.h>\n#include <genom3/c/context.h>
        typedef struct demo_opaque { int32_t v; } demo_opaque;
        static demo_opaque one = { 40 }, two = { 2 };
        genom_event make(demo_opaque **n, demo_opaque **l, const genom_context self)
        { *n = &one; *l = &two; return 0; }
        genom_event read_(const demo_opaque *n, const demo_opaque *l, int32_t *y,
                          const genom_context self)
        { *y = n->v + l->v; return 0; }";
    let loaded = load(gen_, c);
    let mut frame = loaded.begin(service, json!({}));
    assert_eq!(loaded.call(&mut *frame, make), "");
    assert_eq!(loaded.call(&mut *frame, read), "");
    assert_eq!(frame.output().to_json(), json!({ "y": 42 }));
}

#[test]
fn members_of_the_ids_are_passed_in_place() {
    // genom3.md 5.10: `in st.b::stb, in sq[0].a::sqa, out bsq`, and the whole ids.
    let mut gen_ = Gen::new();
    let long = gen_.ty(Kind::Long);
    let double = gen_.ty(Kind::Double);
    let text = gen_.string(None);
    let st = gen_.structure("s", &[("a", long), ("b", text)]);
    let sq = gen_.sequence(st, None);
    let bsq = gen_.sequence(double, Some(4));
    let ids = gen_.ids(&[("v", long), ("st", st), ("sq", sq), ("bsq", bsq)]);
    let service = gen_.service(ServiceKind::Function, "s", &[(Out, "y", long)], &[]);
    let owner = Owner::Service(service);
    use PathStep::{Index, Member};
    let at = |path: &[PathStep]| Source::Ids { path: path.to_vec() };
    let init = gen_.codel(owner, "init", &[(Out, "ids", ids, at(&[]))]);
    let read = gen_.codel(
        owner,
        "use_",
        &[
            (In, "stb", text, at(&[Member(1), Member(1)])),
            (In, "sqa", long, at(&[Member(2), Index(1), Member(0)])),
            (InOut, "b", double, at(&[Member(3), Index(0)])),
            (Out, "y", long, Source::Parameter { index: 0, path: vec![] }),
        ],
    );
    let c = r#"
        #include <genom3/c/idlsequence.h>
        #include <genom3/c/context.h>
        typedef struct { int32_t a; char *b; } demo_s;
        typedef struct { uint32_t _maximum, _length; demo_s *_buffer; void (*_release)(void *); } many;
        typedef struct { uint32_t _maximum, _length; double _buffer[4]; } four;
        typedef struct { int32_t v; demo_s st; many sq; four bsq; } demo_ids;
        genom_event init(demo_ids *ids, const genom_context self) {
          ids->st.b = strdup("four");
          genom_sequence_reserve(&ids->sq, 2);
          ids->sq._length = 2;
          ids->sq._buffer[1].a = 38;
          ids->bsq._length = 1;
          ids->bsq._buffer[0] = 1;
          return 0;
        }
        genom_event use_(const char *stb, int32_t sqa, double *b, int32_t *y,
                         const genom_context self) {
          *b += 1;
          *y = strlen(stb) + sqa - (*b - 2);
          return 0;
        }"#;
    let loaded = load(gen_, c);
    let mut frame = loaded.begin(service, json!({}));
    let missing = loaded.call(&mut *frame, read);
    assert_eq!(missing, "::genom::unkex", "the sequence is still empty");
    let detail = frame.detail().unwrap();
    assert_eq!(detail["what"], "argument `sqa` of codel use_: the sequence has no such element");
    assert_eq!(loaded.call(&mut *frame, init), "");
    assert_eq!(loaded.call(&mut *frame, read), "");
    assert_eq!(frame.output().to_json(), json!({ "y": 42 }));
    assert_eq!(loaded.call(&mut *frame, read), "");
    assert_eq!(frame.output().to_json(), json!({ "y": 41 }), "the ids were changed in place");
}

#[test]
fn inout_parameters_are_seen_among_the_outputs_and_locals_start_empty() {
    // genom3.md 7.3.4, 7.5: codels see `in` in the inputs, `inout` and `out` in the outputs, into
    // which `inout` was copied; locals are new for each run, and everything is zero (7.9).
    let mut gen_ = Gen::new();
    let long = gen_.ty(Kind::Long);
    let service = gen_.service(
        ServiceKind::Activity,
        "act",
        &[(In, "x", long), (Out, "y", long), (InOut, "z", long)],
        &[("l", long)],
    );
    let parameter = |index| Source::Parameter { index, path: vec![] };
    let codel = gen_.codel(
        Owner::Service(service),
        "act_start",
        &[
            (In, "x", long, parameter(0)),
            (Out, "y", long, parameter(1)),
            (InOut, "z", long, parameter(2)),
            (InOut, "l", long, Source::Local { index: 0, path: vec![] }),
        ],
    );
    let c = "#include <stdint.h>\n#include <genom3/c/context.h>
        genom_event act_start(int32_t x, int32_t *y, int32_t *z, int32_t *l,
                              const genom_context self)
        { *y = x; *z *= 10; *l += 1; if (*l > 1) *y = -1; return 0; }";
    let loaded = load(gen_, c);
    let (_, output) = loaded.run(service, codel, json!({ "x": 1, "z": 2 }));
    assert_eq!(output, json!({ "y": 1, "z": 20 }));
    let mut frame = loaded.begin(service, json!({ "x": 1, "z": 2 }));
    loaded.call(&mut *frame, codel);
    loaded.call(&mut *frame, codel);
    assert_eq!(frame.output().to_json(), json!({ "y": -1, "z": 200 }));
    let ty = loaded.specification.components[0].services[service].input;
    frame.begin(&support::generator::record(&loaded.specification, ty, json!({ "x": 5 })));
    assert_eq!(frame.output().to_json(), json!({ "y": 0, "z": 0 }), "a new run starts anew");
    loaded.call(&mut *frame, codel);
    assert_eq!(frame.output().to_json(), json!({ "y": 5, "z": 0 }), "with empty locals");
}

#[test]
fn an_attribute_stores_into_the_ids_and_fetches_from_there() {
    // genom3.md 7.3.6: `in` sets, `out` gets, `inout` sets and then reads back; copies are deep.
    // Changes by validation to an `in` are stored, those to an `inout` are lost.
    let mut gen_ = Gen::new();
    let text = gen_.string(None);
    let long = gen_.ty(Kind::Long);
    gen_.ids(&[("a", text), ("b", long), ("c", long)]);
    let given = [(In, "a", text), (InOut, "b", long), (In, "c", long)];
    let set = gen_.service(ServiceKind::Attribute, "set", &given, &[]);
    let told = [(Out, "a", text), (Out, "b", long), (Out, "c", long)];
    let get = gen_.service(ServiceKind::Attribute, "get", &told, &[]);
    for service in [set, get] {
        (0..3).for_each(|member| gen_.target(service, member, &[PathStep::Member(member)]));
    }
    let parameter = |index| Source::Parameter { index, path: vec![] };
    let check = gen_.codel(
        Owner::Service(set),
        "check",
        &[(InOut, "b", long, parameter(1)), (InOut, "c", long, parameter(2))],
    );
    let c = "#include <stdint.h>\n#include <genom3/c/context.h>
        genom_event check(int32_t *b, int32_t *c, const genom_context self)
        { *b = 99; *c += 1; return 0; }";
    let loaded = load(gen_, c);
    let mut frame = loaded.begin(set, json!({ "a": "text", "b": 3, "c": 6 }));
    loaded.call(&mut *frame, check);
    frame.store();
    frame.fetch();
    assert_eq!(frame.output().to_json(), json!({ "b": 3 }), "the request's value, not validate's");
    drop(frame);
    let mut frame = loaded.begin(get, json!({}));
    frame.fetch();
    assert_eq!(frame.output().to_json(), json!({ "a": "text", "b": 3, "c": 7 }));
}

/// A component with a codel that adds `count` doubles, longs and string lengths; returns the sum.
fn many(count: usize) -> f64 {
    let mut gen_ = Gen::new();
    let types =
        [gen_.ty(Kind::Float), gen_.ty(Kind::Short), gen_.string(None), gen_.ty(Kind::Double)];
    let c_types = ["float", "int16_t", "const char *", "double"];
    let names: Vec<String> = (0..count).map(|i| format!("x{i}")).collect();
    let inputs = names.iter().enumerate().map(|(i, name)| (In, name.as_str(), types[i % 4]));
    let parameters: Vec<_> = inputs.chain([(Out, "y", types[3])]).collect();
    let (service, codel) = gen_.function("f", &parameters);
    let declared = (0..count).map(|i| format!("{} x{i}, ", c_types[i % 4])).collect::<String>();
    let summed = (0..count).map(|i| match i % 4 {
        2 => format!("*y += {} * atoi(x{i});", i + 1),
        _ => format!("*y += {} * x{i};", i + 1),
    });
    let c = format!(
        "#include <stdint.h>\n#include <stdlib.h>\n#include <genom3/c/context.h>
        genom_event f({declared}double *y, const genom_context self) {{ {} return 0; }}",
        summed.collect::<String>()
    );
    let value = |i: usize| match i % 4 {
        2 => json!(format!("{i}")),
        1 => json!(-(i as i64)),
        _ => json!(i as f64 + 0.5),
    };
    let input: Value = names.iter().enumerate().map(|(i, n)| (n.clone(), value(i))).collect();
    let (event, output) = load(gen_, &c).run(service, codel, input);
    assert_eq!(event, "");
    output["y"].as_f64().unwrap_or(f64::NAN)
}

#[test]
fn any_number_of_arguments_arrives_in_order() {
    // In registers only, also on the stack, and more of each kind than the call without libffi
    // supports.
    for count in [0, 1, 2, 5, 9, 13, 14, 17, 18, 24, 25, 26, 40] {
        let expected: f64 = (0..count)
            .map(|i| {
                let x = i as f64;
                (x + 1.0) * [x + 0.5, -x, x, x + 0.5][i % 4]
            })
            .sum();
        assert_eq!(many(count), expected, "{count} arguments");
    }
}
