//! Macros (genom3.md 1.2; C99 6.10.3).

use expect_test::{Expect, expect};

use crate::support::{read, read_with};
use genom_text::preprocess::Options;

#[track_caller]
fn expands(text: &str, tokens: Expect) {
    let read = read(&[("a.gen", text)]);
    assert_eq!(read.messages(), "");
    tokens.assert_eq(&read.tokens());
}

#[track_caller]
fn refuses(text: &str, messages: Expect) {
    messages.assert_eq(&read(&[("a.gen", text)]).messages());
}

#[test]
fn object_macros_are_replaced_and_read_again() {
    expands("#define N M\n#define M 3\nlong a[N];", expect!["LONG a [ 3 ] ;"]);
}

#[test]
fn a_macro_is_not_expanded_inside_itself() {
    expands("#define a b x\n#define b a y\na b", expect!["a y x b x y"]);
    expands("#define f(x) x f(x)\nf(f(1))", expect!["1 f ( 1 ) f ( 1 f ( 1 ) )"]);
}

#[test]
fn arguments_are_expanded_before_they_are_put_in() {
    expands(
        "#define N 4\n#define id(x) x\n#define two(x, y) y x\ntwo(id(N), (a, b))",
        expect!["( a , b ) 4"],
    );
}

#[test]
fn a_function_macro_without_parentheses_stands_for_itself() {
    expands("#define f(x) <x>\nf; f (1) f\n(2)", expect!["f ; < 1 > < 2 >"]);
}

#[test]
fn stringize_keeps_the_spelling_and_one_blank() {
    expands(
        "#define s(x) #x\n#define N 4\ns(N  +  \"a\\n\" ) s()",
        expect![[r#""N + \"a\\\\n\"" """#]],
    );
}

#[test]
fn paste_makes_one_token() {
    expands(
        "#define cat(a, b) a##b\n#define xy 7\ncat(x, y) cat(1, 5ms) cat(, z) cat(z,) cat(:, :) cat(,)",
        expect!["7 15 ms z z ::"],
    );
    expands("#define m(a,b,c) x a##b##c\nm(,,y) m(1,,2)", expect!["x y x 12"]);
}

#[test]
fn variadic_macros_keep_their_commas() {
    expands(
        "#define v(f, ...) f(__VA_ARGS__)\n#define g(f, ...) f(0, ## __VA_ARGS__)\n#define n(r...) r\n\
         v(a, b, (c, d)) v(a) g(a) g(a, b) n(x, y)",
        expect!["a ( b , ( c , d ) ) a ( ) a ( 0 ) a ( 0 , b ) x , y"],
    );
}

#[test]
fn the_example_of_the_c_standard_holds() {
    // C99 6.10.3.5, example 3.
    expands(
        "#define x 3\n#define f(a) f(x * (a))\n#undef x\n#define x 2\n#define g f\n#define z z[0]\n\
         #define h g(~\n#define m(a) a(w)\n#define w 0,1\n#define t(a) a\n#define p() int\n\
         #define q(x) x\n#define r(x,y) x ## y\n#define str(x) # x\n\
         f(y+1) + f(f(z)) % t(t(g)(0) + t)(1);\n\
         g(x+(3,4)-w) | h 5) & m\n(f)^m(m);\n\
         p() i[q()] = { q(1), r(2,3), r(4,), r(,5), r(,) };\nchar c[2][6] = { str(hello), str() };",
        expect![[
            r#"f ( 2 * ( y + 1 ) ) + f ( 2 * ( f ( 2 * ( z [ 0 ] ) ) ) ) % f ( 2 * ( 0 ) ) + t ( 1 ) ; f ( 2 * ( 2 + ( 3 , 4 ) - 0 , 1 ) ) | f ( 2 * ( ~ 5 ) ) & f ( 2 * ( 0 , 1 ) ) ^ m ( 0 , 1 ) ; int i [ ] = { 1 , 23 , 4 , 5 , } ; CHAR c [ 2 ] [ 6 ] = { "hello" , "" } ;"#
        ]],
    );
}

#[test]
fn strings_and_numbers_hold_no_macros() {
    expands("#define ms s\n#define x y\n\"x\" 5ms x", expect![[r#""x" 5 ms y"#]]);
}

#[test]
fn predefined_macros_are_those_of_genom3() {
    expands(
        "__FILE__ __LINE__\n__LINE__ __STDC__ __STDC_VERSION__ __linux__ __GENOM3__",
        expect![[r#""a.gen" 1 2 1 199901 __linux__ __GENOM3__"#]],
    );
    expands("#define at __LINE__\n\n\nat", expect!["4"]);
    let read = read(&[("a.gen", "__GENOM__;__DATE__;__TIME__")]);
    let parts: Vec<_> = read.tokens().split(" ; ").map(str::to_owned).collect();
    assert!(parts[0].starts_with("2.99"), "{parts:?}");
    assert_eq!((parts[1].len(), parts[2].len()), (13, 10), "{parts:?}");
}

#[test]
fn the_command_line_defines_macros() {
    let options =
        Options { defines: vec!["A".into(), "B=2 + 3".into(), "C=".into()], ..Options::default() };
    let read = read_with(&[("a.gen", "A B C;")], &options);
    assert_eq!((read.tokens().as_str(), read.messages().as_str()), ("1 2 + 3 ;", ""));
}

#[test]
fn tokens_of_a_macro_stand_where_it_is_used_and_tell_its_definition() {
    let read = read(&[("a.gen", "#define bad $ x\n  bad\n")]);
    expect![[r#"
        a.gen:2:3: E0101 stray character `$`
    "#]]
    .assert_eq(&read.messages());
    let expansion = read.sources.expansion(read.diagnostics[0].span).unwrap();
    assert_eq!((expansion.name.as_str(), expansion.definition.start), ("bad", 8));
}

#[test]
fn arguments_keep_their_own_place() {
    let read = read(&[("a.gen", "#define id(x) x\nid(\n $)\n")]);
    expect![[r#"
        a.gen:3:2: E0101 stray character `$`
    "#]]
    .assert_eq(&read.messages());
}

#[test]
fn directives_between_arguments_are_obeyed() {
    expands("#define f(x) x\nf(1\n#define A 2\n#if 0\n 3\n#endif\nA)", expect!["1 2"]);
}

#[test]
fn redefining_is_a_warning_unless_it_is_the_same() {
    refuses(
        "#define A 1\n#define A  1\n#define A 2\n#undef A\n#define A 3\n",
        expect![[r#"
            a.gen:3:9: W0103 macro `A` is redefined
        "#]],
    );
}

#[test]
fn malformed_definitions_are_refused() {
    refuses(
        "#define\n#define 3 x\n#define defined 1\n#define f(x\n#define g(x, x) 1\n#define h(x y) 1\n\
         #define i(1) 1\n#define j(x) #y\n#define k ## x\n#define l x ##\n#undef\n",
        expect![[r#"
            a.gen:1:2: E0124 macro name missing after `#define`
            a.gen:2:9: E0124 `3` cannot be the name of a macro
            a.gen:3:9: E0124 `defined` cannot be the name of a macro
            a.gen:4:11: E0124 `,` or `)` is expected after this parameter
            a.gen:5:14: E0124 parameter `x` is named twice
            a.gen:6:11: E0124 `,` or `)` is expected after this parameter
            a.gen:7:11: E0124 `1` is not expected in a list of parameters
            a.gen:8:14: E0124 `#` must stand before a parameter of the macro
            a.gen:9:11: E0124 `##` must stand between two tokens
            a.gen:10:13: E0124 `##` must stand between two tokens
            a.gen:11:2: E0123 `#undef` must name a macro
        "#]],
    );
}

#[test]
fn wrong_arguments_are_refused() {
    refuses(
        "#define f(x, y) x\nf(1)\nf(1, 2, 3)\n#define v(x, y, ...) x\nv(1)\n#define p(a, b) a##b\np(x, \"y\")\nf(1,",
        expect![[r#"
            a.gen:2:1: E0125 macro `f` takes 2 arguments, 1 given
            a.gen:3:1: E0125 macro `f` takes 2 arguments, 3 given
            a.gen:5:1: E0125 macro `v` takes at least 2 arguments, 1 given
            a.gen:7:1: E0126 `##` makes `x"y"`, which is no token
            a.gen:8:1: E0125 the arguments of macro `f` are never closed
        "#]],
    );
}
