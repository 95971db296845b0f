//! The paper's tables from the built-in clips, as a committed snapshot: a change of behaviour shows in review as a
//! change of figures. `cargo insta review`, or `INSTA_UPDATE=always` with this test, accepts one.

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
