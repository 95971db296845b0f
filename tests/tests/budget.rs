//! Memory of the core's types: what grows here grows in every board's RAM.
//!
//! The numbers are those of a 64-bit host, where an index takes 8 bytes; a board's are a little smaller.

use std::mem::size_of;

use sinew_core::observer::Observer;
use sinew_core::projection::{ManifoldProjection, ProjectionWorkspace};
use sinew_core::state_error::Method;
use sinew_core::{Controller, JointStates, JointTargets, Tree, Workspace};

#[test]
#[cfg(target_pointer_width = "64")]
fn types_stay_within_their_budget() {
    for (name, bytes, budget) in [
        ("Tree<18>", size_of::<Tree<18>>(), 3_000),
        ("Tree<128>", size_of::<Tree<128>>(), 20_600),
        // Resolved acceleration takes 132 bytes of it for each body: a symmetric 6 x 6 matrix and a wrench.
        ("Workspace<18>", size_of::<Workspace<18>>(), 7_200),
        ("Workspace<128>", size_of::<Workspace<128>>(), 51_000),
        ("JointStates<128>", size_of::<JointStates<128>>(), 6_700),
        ("JointTargets<128>", size_of::<JointTargets<128>>(), 9_800),
        // An aim at several children has a set of them: 16 bytes.
        ("Method<128>", size_of::<Method<128>>(), 3_200),
        // Gains by joint take 16 bytes each: angular and linear ones differ in unit where there is no inverse
        // dynamics. Their inertias take 28: a symmetric matrix and a mass.
        ("Controller<18>", size_of::<Controller<18>>(), 4_450),
        ("Controller<128>", size_of::<Controller<128>>(), 30_400),
        ("ManifoldProjection<18>", size_of::<ManifoldProjection<18>>(), 550),
        // A body's demand is a symmetric 6 x 6 matrix, and its joint answers with up to three axes.
        ("ProjectionWorkspace<18>", size_of::<ProjectionWorkspace<18>>(), 8_700),
        ("ProjectionWorkspace<128>", size_of::<ProjectionWorkspace<128>>(), 61_750),
        // 28 bytes a joint for each command on its way.
        ("Observer<18, 4>", size_of::<Observer<18, 4>>(), 4_550),
    ] {
        assert!(bytes <= budget, "{name} takes {bytes} bytes, its budget is {budget}");
        assert!(
            bytes > budget / 10 * 9,
            "{name} takes {bytes} of {budget} bytes: lower its budget"
        );
    }
}
