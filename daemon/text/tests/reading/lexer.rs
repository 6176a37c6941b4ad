//! The lexer's rules (genom3.md 2.1), seen through whole files.

use expect_test::{Expect, expect};

#[track_caller]
fn check(text: &str, tokens: Expect, messages: Expect) {
    let read = crate::support::read(&[("a.gen", text)]);
    tokens.assert_eq(&read.tokens());
    messages.assert_eq(&read.messages());
}

#[track_caller]
fn accepts(text: &str, tokens: Expect) {
    check(text, tokens, expect![""]);
}

#[test]
fn the_longest_sign_wins_and_digraphs_have_their_main_spelling() {
    accepts(
        "<% %> <: :> a::b :: : << < >> > xor bitand bitor compl not",
        expect!["{ } [ ] a :: b :: : << < >> > ^ & | ~ !"],
    );
}

#[test]
fn a_scope_after_an_angle_is_no_digraph() {
    accepts("sequence<::m::t>", expect!["SEQUENCE < :: m :: t >"]);
}

#[test]
fn nested_templates_need_a_blank_as_in_genom3() {
    accepts("sequence<sequence<long>>", expect!["SEQUENCE < SEQUENCE < LONG >>"]);
}

#[test]
fn names_with_a_dash_are_one_identifier_only_without_blanks() {
    accepts(
        "clock-rate codels-require codels-requires real-time clock - rate clock- rate a-rate",
        expect![
            "clock-rate codels-require codels-requires real-time clock - rate clock - rate a - rate"
        ],
    );
}

#[test]
fn integers_are_decimal_octal_or_hexadecimal_and_keep_64_bits() {
    accepts(
        "0 017 0x1F 0Xffffffff 42u 42UL 42lu 18446744073709551615",
        expect!["0 15 31 4294967295 42 42 42 18446744073709551615"],
    );
}

#[test]
fn an_integer_past_64_bits_is_an_error() {
    check(
        "x = 18446744073709551616;",
        expect!["x = 18446744073709551615 ;"],
        expect![[r#"
            a.gen:1:5: E0116 this integer does not fit in 64 bits
        "#]],
    );
}

#[test]
fn units_may_touch_their_number() {
    accepts(
        "5ms 1s 20k 1M 1.5ms 1e-3s 1.5e3f 5. .5 1e3",
        expect!["5 ms 1 s 20 k 1 M 1.5 ms 0.001 s 1500.0 5.0 0.5 1000.0"],
    );
}

#[test]
fn five_us_is_five_microseconds_with_a_warning() {
    check(
        "period 5us; period 5 us;",
        expect!["period 5 us ; period 5 us ;"],
        expect![[r#"
            a.gen:1:8: W0101 `5us` is read as 5 microseconds
        "#]],
    );
}

#[test]
fn fixed_point_literals_are_left_to_the_parser() {
    accepts("1.5d 5D 5dms", expect!["fixed! fixed! fixed! ms"]);
}

#[test]
fn an_octal_number_has_no_eight() {
    check(
        "08 08.5",
        expect!["8 8.5"],
        expect![[r#"
            a.gen:1:1: E0116 `8` is no digit of an octal number
        "#]],
    );
}

#[test]
fn only_the_quote_is_unescaped_in_strings() {
    accepts(r#""a\"b" "\n" "é""#, expect![[r#""a\"b" "\\n" "é""#]]);
}

#[test]
fn a_string_may_end_in_a_backslash() {
    accepts(r#""foo\\"; "bar""#, expect![[r#""foo\\\\" ; "bar""#]]);
}

#[test]
fn lines_are_right_after_a_string_over_several_lines() {
    check(
        "a \"x\ny\n\"\n$",
        expect![[r#"a "x\ny\n""#]],
        expect![[r#"
            a.gen:4:1: E0101 stray character `$`
        "#]],
    );
}

#[test]
fn an_unclosed_string_costs_one_message_and_the_rest_is_read() {
    check(
        "version \"1.0;\nlang c;\n",
        expect![[r#"version "1.0;" lang c ;"#]],
        expect![[r#"
            a.gen:1:9: E0114 unterminated string
        "#]],
    );
}

#[test]
fn character_literals_have_their_value() {
    accepts(r"'x' '\n' '\''", expect!["'120' '10' '39'"]);
}

#[test]
fn a_lone_quote_is_an_error() {
    check(
        "don't;\n'ab'",
        expect!["don t ; '0'"],
        expect![[r#"
            a.gen:1:4: E0115 unterminated character literal
            a.gen:2:1: E0115 'ab' is not one character of one byte
        "#]],
    );
}

#[test]
fn rule_l1_a_stray_character_is_an_error_and_lexing_goes_on() {
    check(
        "a @ b $$ c \\ d \u{e9} e \0 f",
        expect!["a b c d e f"],
        expect![[r#"
            a.gen:1:3: E0101 stray character `@`
            a.gen:1:7: E0101 stray character `$`
            a.gen:1:12: E0101 stray character `\\`
            a.gen:1:16: E0101 stray character `é`
            a.gen:1:20: E0101 stray character `\0`
        "#]],
    );
}

#[test]
fn rule_l2_a_comment_that_is_never_closed_is_an_error() {
    check(
        "a /* b */ // c\nd /* e\nf",
        expect!["a d"],
        expect![[r#"
            a.gen:2:3: E0102 unterminated comment
        "#]],
    );
}

#[test]
fn keywords_are_told_from_names_by_their_case() {
    accepts("TRUE true struct Struct period", expect!["TRUE true STRUCT Struct period"]);
}

#[test]
fn dos_lines_and_a_byte_order_mark_are_blanks() {
    check(
        "\u{feff}a\r\n\tb \x0b\x0c c\r\n$",
        expect!["a b c"],
        expect![[r#"
            a.gen:3:1: E0101 stray character `$`
        "#]],
    );
}
