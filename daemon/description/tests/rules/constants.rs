//! 3.3: constants and unions.

use crate::{accepted, rules, warned};

rules! {
    c1_booleans_do_not_add "E0301" 1 "const long a = TRUE + 1;";
    c1_floats_have_no_bits "E0301" 1 "const long a = 1.5 & 1;";
    c1_a_boolean_has_no_sign "E0301" 1 "const boolean a = +TRUE;";
    c1_division_by_zero_is_an_error "E0312" 1 "const long a = 1/0;";
    c1_so_is_the_rest_of_it "E0312" 1 "const long a = 1 % (2 - 2);";
    c2_a_type_is_no_value "E0302" 1 "typedef long t; const long a = t;";
    c3_a_size_is_a_non_negative_integer "E0303" 1 "typedef long b[-1];";
    c3_a_size_is_whole "E0303" 1 "typedef sequence<long, 2.5> v;";
    c3_a_priority_too "E0303" 1 "component c { task t { priority \"high\"; }; };";
    c4_a_time_is_a_number "E0304" 1 "component c { task t { period \"1\" s; }; };";
    c5_a_value_fits_its_type "E0305" 1 "const boolean a = 1;";
    c5_a_float_is_no_integer "E0305" 1 "const long a = 1.5;";
    c5_a_negative_value_is_not_unsigned "E0305" 1 "const octet a = -1;";
    c5_a_number_is_no_enumerator "E0305" 1 "enum e { A }; const e x = 0;";
    c5_nor_is_one_of_another_enum "E0305" 1 "enum e { A }; enum f { B }; const e x = B;";
    c6_a_struct_is_no_constant "E0306" 1 "struct s { long a; }; const s x = 1;";
    c7_an_octet_does_not_select "E0307" 1 "typedef octet o; union w switch(o) { case 1: long a; };";
    c7_nor_written_out "E0307" 1 "union w switch(octet) { case 1: long a; };";
    c8_a_label_fits_the_switch "E0308" 1 "union u switch(boolean) { case 1: long a; };";
    c10_a_label_selects_one_member "E0310" 1
        "union u switch(long) { case 1: long a; case 2 - 1: long b; };";
    c10_there_is_one_default "E0310" 1 "union u switch(long) { default: long a; default: long b; };";
    c11_a_member_differs_from_the_type_of_the_switch "E0311" 1
        "enum e { A, B }; union u switch(e) { case A: long e; };";
    c11_an_enum_in_the_switch_clashes_with_itself "E0311" 1
        "union u switch(enum e { A }) { case A: long x; };";
}

#[test]
fn c9_a_label_repeated_for_one_member_is_a_warning() {
    warned("W0309", "union u switch(long) { case 1: case 1: long a; };");
}

#[test]
fn zero_sizes_and_whole_floats_are_sizes() {
    accepted("typedef sequence<long, 0> s; typedef long a[0]; typedef sequence<long, 2.0> u;");
}
