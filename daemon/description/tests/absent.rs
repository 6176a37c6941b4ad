//! Missing files and packages: each mistake is reported once.

use genom_description::{Options, read_text};

const TEXT: &str = "#include \"or/pose/pose.gen\"
component m {
  provides or_robot;
  ids { or_pose::state a; };
  port in or_pose::state pose;
  task t;
  activity g(in or_pose::t p) { task t; codel<start> g1(in p, in pose) yield ether; throw e_sys; };
};";

fn said(text: &str) -> Vec<(&'static str, String)> {
    let analysis = read_text("m.gen", text, &Options::default());
    let told = |one: &genom_description::diagnostic::Diagnostic| {
        (one.code, one.help.clone().unwrap_or_default())
    };
    analysis.diagnostics.iter().map(told).collect()
}

#[test]
fn a_missing_file_is_one_error_that_tells_how_many_are_left_out() {
    let said = said(TEXT);
    assert_eq!(said.iter().map(|(code, _)| *code).collect::<Vec<_>>(), ["E0121"]);
    let left_out = "5 errors about names that are unknown without it are left out";
    assert!(said[0].1.ends_with(left_out), "{said:?}");
}

#[test]
fn a_missing_package_is_one_error_with_its_files_and_their_names() {
    let said = said(&format!("#pragma requires \"no-such-idl\"\n{TEXT}"));
    assert_eq!(said.iter().map(|(code, _)| *code).collect::<Vec<_>>(), ["E0131"]);
}

#[test]
fn other_mistakes_are_told_beside_a_missing_file() {
    let text = format!("{TEXT}\nmodule x {{ struct s {{ long a; long a; }}; }};");
    let codes: Vec<_> = said(&text).into_iter().map(|(code, _)| code).collect();
    assert_eq!(codes.len(), 2, "{codes:?}");
}
