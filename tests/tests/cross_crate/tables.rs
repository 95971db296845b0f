//! The paper's tables from the built-in clips, as a committed snapshot: a change of behaviour is visible in review as
//! a change of numbers. `cargo insta review`, or this test with `INSTA_UPDATE=always`, accepts a change.

use sinew_evaluation::{Protocol, evaluate, report};
use sinew_figure::builtin;
use sinew_figure::pipeline::{Settings, prepare};

#[test]
fn tables_of_the_built_in_clips() {
    let settings = Settings::default();
    let motions: Vec<_> =
        builtin::clips().into_iter().map(|clip| prepare(clip, &settings).unwrap().0).collect();
    let evaluation = evaluate(&motions, &Protocol::default(), |_| ()).unwrap();
    insta::assert_snapshot!("built_in", report::tables(&evaluation));
}
