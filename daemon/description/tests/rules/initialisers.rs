//! 3.8: initialisers.

use crate::rules;

rules! {
    v1_a_scalar_takes_one_value "E0801" 1 "component c { function f(in long a = { 3 }); };";
    v2_a_struct_takes_braces "E0802" 1 "component c { struct s { long a; }; function f(in s a = 3); };";
    v2_an_array_takes_braces "E0802" 1 "component c { function f(in long a[2] = 3); };";
    v3_a_default_fits_its_type "E0803" 1 "component c { function f(in long a = 1.5); };";
    v3_also_in_attributes "E0803" 1 "component c { ids { unsigned long a; }; attribute f(in a = -1); };";
    v4_a_struct_takes_no_more_values_than_members "E0804" 1
        "component c { struct s { long a; }; function f(in s a = {1, 2}); };";
    v5_an_element_is_within_bounds "E0805" 1 "component c { function f(in long a[2] = {1, 2, 3}); };";
    v5_also_with_an_index "E0805" 1 "component c { function f(in sequence<long, 2> a = {[2] = 3}); };";
    v6_a_member_is_known "E0806" 1 "component c { struct s { long a; }; function f(in s a = {.b = 2}); };";
    v6_an_array_has_no_members "E0806" 1 "component c { function f(in long a[2] = {.b = 2}); };";
    v7_a_struct_has_no_elements "E0807" 1 "component c { struct s { long a; }; function f(in s a = {[0] = 2}); };";
}
