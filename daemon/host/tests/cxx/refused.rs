//! Libraries that differ from their description.

use expect_test::expect;
use genom_host::Library;
use genom_host::contract::{self, Checked};

use crate::axis::{AXIS, axis};
use crate::support::Scratch;
use crate::support::cxx::{compile, plan, refusal};

#[test]
fn codels_that_differ_are_refused_with_the_line_and_both_declarations() {
    let small = |parameter: &str| {
        format!(
            "component demo {{\n  lang \"c++\";\n  task main;\n  function f(in {parameter} x, out \
             long y) {{\n    codel f_run(in x, out y);\n  }};\n}};\n"
        )
    };
    let codel = "genom::event f_run(int32_t x, int32_t &y) { y = x; return genom::ok; }";
    let right = compile(&small("long"), codel, &[]);
    let refused = |run: &str| refusal(&right, &small(run));
    expect!["loads"].assert_eq(&refused("long"));
    expect![[r#"
        demo.so: codel `f_run` (demo.gen:5): the C++ function takes other parameters
          .gen:    genom::event f_run(double x, int32_t &y)
          library: f_run(int, int&)"#]]
    .assert_eq(&refused("double"));
    expect![[r#"
        demo.so: codel `f_run` (demo.gen:5): the C++ function takes other parameters
          .gen:    genom::event f_run(const std::vector< std::string > &x, int32_t &y)
          library: f_run(int, int&)"#]]
    .assert_eq(&refused("sequence<string>"));
    let text = small("long").replace("f_run", "g_run");
    expect![[r#"demo.so: codel `g_run` (demo.gen:5) is not defined; a lang "c++" codel is a C++ function that the library exports"#]]
        .assert_eq(&refusal(&right, &text));
    let linkage = "extern \"C\" genom::event f_run(int32_t x, int32_t &y) { y = x; return 0; }";
    let linkage = compile(&text, linkage, &["-g0"]);
    expect![[r#"demo.so: codel `f_run` (demo.gen:5) is not defined; it has a function of that name with C linkage: in a lang "c++" component codels have none (no extern "C"), or say lang "c""#]]
        .assert_eq(&refusal(&linkage, &small("long")));
}

#[test]
fn types_that_cxx_has_not_are_refused_at_load() {
    let text = |member: &str| {
        format!(
            "component demo {{\n lang \"c++\";\n union u switch (long) {{ case 1: long i; case 2: \
             {member} m; }};\n task main;\n ids {{ u x; }};\n}};\n"
        )
    };
    let plain = compile(&text("double"), "", &[]);
    expect![[r#"demo.so: the ids (demo.gen:1): member 'm' of type string not allowed in C++ union ::demo::u: put it beside the union"#]]
        .assert_eq(&refusal(&plain, &text("string")));
    expect!["demo.so: the ids (demo.gen:1): sequence<string<4>> has no C++ type, because string<4> is an array there: put it in a struct"]
        .assert_eq(&refusal(&plain, &text("sequence<string<4> >")));
}

#[test]
fn another_cpp_library_is_refused() {
    let text = "component demo { lang \"c++\"; task main; };";
    let scratch = Scratch::new();
    let soname = ["-shared", "-fPIC", "-Wl,-soname,libc++.so.1"];
    let other = scratch.cxx("libc++.so.1", "int other() { return 1; }", &soname);
    let rpath = format!("-Wl,-rpath,{}", scratch.path().display());
    let other = other.to_str().unwrap();
    let compiled = compile(text, "", &["-Wl,--no-as-needed", other, &rpath]);
    expect!["demo.so: component `demo` is linked with libc++, this daemon with libstdc++: texts and sequences would not fit (leave -stdlib=libc++ away, or give the codels the C interface)"]
        .assert_eq(&refusal(&compiled, text));
}

#[test]
fn types_that_differ_are_refused_by_the_debug_information_of_cxx() {
    let library = Library::open(&axis().library).unwrap();
    let report = contract::check(&library, &plan(AXIS).0, &|_| String::new());
    assert_eq!((report.checked, report.codels), (Checked::DebugInformation, 6));
    assert_eq!(report.differences, []);

    let differs = |from: &str, to: &str| {
        assert!(AXIS.contains(from), "{from}");
        refusal(&axis(), &AXIS.replacen(from, to, 1))
    };
    let told = differs("sequence<double> values; };", "sequence<float> values; };");
    let first = told.lines().take(3).collect::<Vec<_>>().join("\n");
    expect![[r#"
        demo.so: codel `t_start` (demo.gen:16): argument 1 `ids`: `demo::ids.last`: `demo::sample.values`: `std::vector< float >`: its element: `float` is wanted, not `double`
          .gen:    genom::event t_start(demo::ids &ids)
          library: event t_start(struct ids &ids)"#]]
    .assert_eq(&first);
    let told = differs("long count; };", "long count; string more; };");
    expect![[r#"
        demo.so: codel `t_start` (demo.gen:16): argument 1 `ids`: `demo::ids` has members last, all, handle, count, more; `struct ids` has last, all, handle, count
          .gen:    genom::event t_start(demo::ids &ids)
          library: event t_start(struct ids &ids)"#]]
    .assert_eq(&told);
    let told = differs("double limit; string what;", "double limit; string<8> what;");
    expect![[r#"
        demo.so: exception `::demo::TOO_FAR` (demo.gen:2): `demo::TOO_FAR::detail.what`: `char [8]` is wanted, not `string`
          .gen:    { double limit; char what[8]; std::vector< int32_t > tried; }
          library: { double limit; string what; struct vector<int, std::allocator<int> > tried; }"#]]
    .assert_eq(&told);
    let told = differs("port in sample input", "port out sample input");
    assert!(
        told.contains("an object with data, write is wanted, not one with data, read"),
        "{told}"
    );
    let told = differs("port multiple in sample ins", "port in sample ins");
    assert!(told.contains("the port is simple: its methods take nothing"), "{told}");
}
