//! Descriptions of tests.

use std::sync::Arc;

use genom_description::{Options, read_text};
use genom_runtime::Plan;

/// The plan of the first component of a `.gen` text.
#[track_caller]
pub(crate) fn plan(gen_text: &str) -> Arc<Plan> {
    let analysis = read_text("test.gen", gen_text, &Options::default());
    assert!(!analysis.has_errors(), "{:#?}", analysis.diagnostics);
    Arc::new(Plan::new(&Arc::new(analysis.specification), 0).unwrap())
}
