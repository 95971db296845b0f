//! Forward dynamics of random rigs of all joint kinds, up to full capacity, against inverse dynamics.

use proptest::prelude::*;
use sinew_core::dynamics::{ArticulatedBody, BodyMotion, forward_dynamics, inverse_dynamics};
use sinew_core::glam::Vec3;
use sinew_core::{JointKind, Motion, Wrench};
use sinew_tests::property;
use sinew_tests::rig::{CAPACITY, Joints, Rig, rigs};

const GRAVITY: Vec3 = Vec3::new(1.3, -9.4, 2.2);

fn forward(rig: &Rig, wrenches: &[Wrench], external: &[Wrench]) -> Vec<Motion> {
    let mut workspace = vec![ArticulatedBody::default(); rig.tree.len()];
    let mut out = vec![Motion::ZERO; rig.tree.len()];
    let (bodies, states) = (rig.tree.bodies(), rig.states());
    forward_dynamics(bodies, states.as_slice(), wrenches, GRAVITY, external, &mut workspace, &mut out);
    out
}

fn inverse(rig: &Rig, accelerations: &[Motion], external: &[Wrench]) -> Vec<Wrench> {
    let mut scratch = vec![BodyMotion::default(); rig.tree.len()];
    let mut out = vec![Wrench::ZERO; rig.tree.len()];
    let (bodies, states) = (rig.tree.bodies(), rig.states());
    inverse_dynamics(bodies, states.as_slice(), accelerations, GRAVITY, external, &mut scratch, &mut out);
    out
}

#[test]
fn explore() {
    use proptest::strategy::{Strategy, ValueTree};
    use proptest::test_runner::TestRunner;
    for most in [1, 2, 4, 8, 18, 32, 64, 128] {
        for joints in [Joints::Mixed, Joints::Figure] {
            let mut runner = TestRunner::new(property(1));
            let (mut worst_a, mut worst_t, mut all_a, mut all_t) = (0f64, 0f64, vec![], vec![]);
            for _ in 0..200 {
                let rig = rigs(most, joints).new_tree(&mut runner).unwrap().current();
                let a = rig.accelerations();
                let t = inverse(&rig, &a, &[]);
                let back = forward(&rig, &t, &[]);
                let size = |m: &Motion| f64::from(m.angular.abs().max_element().max(m.linear.abs().max_element()));
                let wsize = |m: &Wrench| f64::from(m.moment_nm.abs().max_element().max(m.force_n.abs().max_element()));
                let scale = a.iter().map(size).fold(1.0, f64::max);
                let e = a.iter().zip(&back).map(|(a, b)| size(&(*a - *b))).fold(0.0, f64::max) / scale;
                let t2 = inverse(&rig, &back, &[]);
                let states = rig.states();
                let tscale = t.iter().map(wsize).fold(1.0, f64::max);
                let te = t.iter().zip(&t2).zip(rig.tree.bodies().iter().zip(states.as_slice())).map(|((a, b), (body, state))| {
                    let in_joint = body.placement.rotation.conjugate() * state.pose.rotation;
                    wsize(&body.joint.project_wrench(in_joint, *a - *b))
                }).fold(0.0, f64::max) / tscale;
                worst_a = worst_a.max(e); worst_t = worst_t.max(te); all_a.push(e); all_t.push(te);
            }
            all_a.sort_by(f64::total_cmp); all_t.sort_by(f64::total_cmp);
            println!("{most} {joints:?}: a {:e} med, {:e} p90, {worst_a:e} max; t {:e} {:e} {worst_t:e}", all_a[100], all_a[180], all_t[100], all_t[180]);
        }
    }
}
