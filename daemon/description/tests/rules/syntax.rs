//! 3.1: the rows of the parser.

use crate::{accepted, rules};

rules! {
    the_ids_of_a_component_have_no_name "E0103" 1 "component c { ids state { long a; }; };";
    l3_a_token_out_of_place_is_a_syntax_error "E0103" 2 "component c {\n  remote r;\n};";
    l3_the_end_of_the_file_may_come_too_early "E0105" 1 "component c { version \"1\";";
    l3_a_bare_semicolon_is_an_error "E0103" 1 "component c { ; };";
    l3_nested_templates_need_a_blank "E0103" 1 "typedef sequence<sequence<long>> s;";
    l3_only_one_sign_stands_before_a_value "E0103" 1 "const long a = --1;";
    l3_a_reserved_word_is_no_name "E0103" 1 "struct FALSE { long a; };";
    l4_a_statement_begins_with_a_known_word "E0104" 1 "templat c { version \"1\"; };";
    l5_without_a_semicolon_the_rest_is_passed_over "E0104" 1 "template c { version \"1\"; }";
    l6_a_missing_semicolon_is_reported_and_tolerated "E0106" 1
        "component c { version \"1\" };";
    l6_also_before_the_next_statement "E0106" 2
        "component c { typedef long a\n typedef long b; port in b p; };";
    l7_an_unknown_property_is_an_error "E0107" 1 "component c { task t { perod 1 s; }; };";
    l8_a_state_machine_codel_says_what_it_yields "E0108" 1
        "component c { task t { codel<start> a(); }; };";
    l9_there_are_no_fixed_point_types "E0109" 1 "typedef fixed<3,2> f; struct s { f x; };";
    l9_nor_fixed_point_numbers "E0109" 1 "const double a = 1.5d;";
    l10_an_error_in_a_struct_drops_the_member "E0110" 1 "struct s { long object; }; typedef s t;";
    l10_a_struct_has_members "E0110" 1 "struct s { };";
    l11_an_error_in_the_ids_drops_the_member "E0111" 1
        "component c { ids { long; long b; }; attribute a(in b); };";
    l12_an_error_in_a_parameter_drops_the_service "E0112" 1
        "component c { function f(long a); task t; activity b() { task t; interrupts f;
         codel<start> x() yield ether; }; };";
    l12_documentation_needs_an_equal_sign "E0112" 1 "component c { function f(in long a : \"doc\"); };";
    too_many_nested_parentheses_are_refused "E0113" 1
        &format!("const long a = {}1{};", "(".repeat(101), ")".repeat(101));
    too_many_nested_structs_are_refused "E0113" 1
        &format!("{} long x; {}", "struct s { ".repeat(101), "} m;".repeat(101));
    too_many_types_in_types_are_refused "E0113" 1 &chain(150);
    too_many_dimensions_are_refused "E0113" 1 &format!("typedef long a{};", "[1]".repeat(150));
}

fn chain(length: usize) -> String {
    let link = |n: usize| format!("struct s{n} {{ s{} x; }};", n - 1);
    let links: String = (1..length).map(link).collect();
    // Only the first that is too deep is reported: later ones contain a refused type.
    let first = 101;
    let cut = links.find(&format!("struct s{first} ")).unwrap();
    format!("typedef long s0;{}", &links[..cut])
}

#[test]
fn nesting_up_to_the_stated_depth_is_accepted() {
    accepted(&format!("const long a = {}1{};", "(".repeat(99), ")".repeat(99)));
}

#[test]
fn a_sum_of_any_length_is_accepted() {
    accepted(&format!("const long a = 0{};", " + 0".repeat(50_000)));
}

#[test]
fn ten_mistakes_make_ten_messages() {
    let text = "component c {\n\
        port in nope p;\n\
        typedef lng l;\n\
        task t { period 1 hz; };\n\
        ids { long a; long a; };\n\
        attribute set(in b);\n\
        function f(in long x) { codel g(in y); };\n\
        activity a() { task u; codel<start> h(in p) yield next; };\n\
        exception e\n\
        function k() { throw ee; interrupts ff; };\n\
        port out l q;\n};\n";
    let analysis = crate::analyse(text);
    let lines: Vec<u32> =
        analysis.diagnostics.iter().map(|d| analysis.sources.location(d.span).line).collect();
    let codes: Vec<_> = analysis.diagnostics.iter().map(|d| d.code).collect();
    assert_eq!(lines, [2, 3, 4, 5, 6, 7, 8, 8, 10, 10, 10], "{codes:?}");
}
