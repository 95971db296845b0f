//! Checks independently of the tested code that a show keeps to a rig's limits: positions from the decoder, speeds
//! and accelerations from their differences, efforts by Newton and Euler in f64, body by body in the world frame.

use glam::DVec3;
use sinew_rig::Mechanism;
use sinew_rig::mechanism::{GRAVITY_M_S2, JointModel, Pose};
use sinew_show::{Player, Show};

/// Time between the positions of which differences are computed, s. Rounding to f32 adds errors of 0.02 rad/s².
const H_S: f64 = 4e-3;
/// Margin on each limit, as a share. Besides rounding, differences with this time step have an error in proportion to
/// the square of the step.
const ROOM: f64 = 0.01;

/// Fails if a show exceeds a limit at any of 500 instants per second; for a loop also across its seam.
pub(crate) fn exceeds_nothing(mechanism: &Mechanism, bytes: &[u8]) {
    let show = Show::open(bytes).unwrap();
    let mut player = Player::<256>::new(show).unwrap();
    let (nq, nv) = (show.channel_count(), show.dof_count());
    // A loop continues after its end.
    let behind_s = if show.is_loop() { 0.1 } else { 0.0 };
    let end_s = f64::from(show.duration_s()) + behind_s;
    let mut at = |time_s: f64| -> Vec<f64> {
        let (mut q, mut qd, mut qdd) = (vec![0.0; nq], vec![0.0; nv], vec![0.0; nv]);
        let position = show.position_at_us(super::whole_us(time_s));
        player.state_at(position, &mut q, &mut qd, &mut qdd).unwrap();
        q.into_iter().map(f64::from).collect()
    };
    let mut time_s = H_S;
    while time_s < end_s - H_S {
        let [before, now, after] = [time_s - H_S, time_s, time_s + H_S].map(&mut at);
        let mut motion = Vec::new();
        for (link, range) in mechanism.bodies.iter().zip(mechanism.coordinate_ranges()) {
            let JointModel::Revolute(_) = link.joint else {
                assert!(range.is_empty(), "{}: only hinges are looked at", link.joint_name);
                motion.push([0.0; 2]);
                continue;
            };
            let [a, b, c] = [&before, &now, &after].map(|q| q[range.start]);
            let (speed, acceleration) = ((c - a) / (2.0 * H_S), (a - 2.0 * b + c) / (H_S * H_S));
            let name = &link.joint_name;
            if let Some([least, most]) = link.ranges.first() {
                assert!((*least..=*most).contains(&b), "{name}: {b} at {time_s}");
            }
            assert!(
                speed.abs() <= link.speed * (1.0 + ROOM) + 1e-3,
                "{name}: {speed} rad/s at {time_s}"
            );
            let most = link.acceleration * (1.0 + ROOM) + 0.1;
            assert!(acceleration.abs() <= most, "{name}: {acceleration} rad/s2 at {time_s}");
            motion.push([speed, acceleration]);
        }
        for linked in &mechanism.linked {
            let ranges = mechanism.coordinate_ranges();
            let [own, other] = [linked.body, linked.other].map(|body| now[ranges[body].start]);
            let sum = linked.factor * own + linked.other_factor * other;
            let [least, most] = linked.range;
            // Tied coordinates are rounded to f32, twice.
            assert!(
                sum >= least - 1e-5 && sum <= most + 1e-5,
                "{sum} of {least} to {most} at {time_s}"
            );
        }
        for (link, effort) in mechanism.bodies.iter().zip(efforts(mechanism, &now, &motion)) {
            let most = link.effort * (1.0 + ROOM) + 1e-3;
            assert!(
                effort.abs() <= most,
                "{}: {effort} N m of {most} at {time_s}",
                link.joint_name
            );
        }
        time_s += 2e-3;
    }
}

/// Returns the torques of the hinges: the moment about each joint of all bodies beyond it, with rotors and friction.
fn efforts(mechanism: &Mechanism, q: &[f64], motion: &[[f64; 2]]) -> Vec<f64> {
    let poses: Vec<Pose> = mechanism.poses(q);
    // Angular velocity and acceleration, and acceleration of the origin minus gravity, in the world.
    let mut moving: Vec<[DVec3; 3]> = Vec::new();
    for (body, link) in mechanism.bodies.iter().enumerate() {
        let [speed, acceleration] = motion[body];
        let Some(parent) = link.parent else {
            moving.push([DVec3::ZERO, DVec3::ZERO, -GRAVITY_M_S2]);
            continue;
        };
        let axis = match link.joint {
            JointModel::Revolute(axis) => poses[body].rotation * axis,
            _ => DVec3::ZERO,
        };
        let [w, dw, a] = moving[parent];
        let arm = poses[body].position_m - poses[parent].position_m;
        let own_w = w + axis * speed;
        let own_dw = dw + axis * acceleration + w.cross(axis * speed);
        moving.push([own_w, own_dw, a + dw.cross(arm) + w.cross(w.cross(arm))]);
    }
    // Load that the joint passes on: moment about its origin, and force.
    let mut passed = vec![[DVec3::ZERO; 2]; poses.len()];
    for (body, link) in mechanism.bodies.iter().enumerate().rev() {
        let [w, dw, a] = moving[body];
        let pose = &poses[body];
        let center = pose.rotation * link.center_of_mass_m;
        let force = link.mass_kg * (a + dw.cross(center) + w.cross(w.cross(center)));
        let turn = glam::DMat3::from_quat(pose.rotation);
        let inertia = turn * link.inertia_kg_m2 * turn.transpose();
        let moment = inertia * dw + w.cross(inertia * w) + center.cross(force);
        passed[body][0] += moment;
        passed[body][1] += force;
        if let Some(parent) = link.parent {
            let [moment, force] = passed[body];
            let arm = pose.position_m - poses[parent].position_m;
            passed[parent][0] += moment + arm.cross(force);
            passed[parent][1] += force;
        }
    }
    let of_joint = |(body, link): (usize, &sinew_rig::mechanism::Link)| match link.joint {
        JointModel::Revolute(axis) => {
            let [speed, acceleration] = motion[body];
            let dry = link.friction * (speed / 0.01).clamp(-1.0, 1.0);
            (poses[body].rotation * axis).dot(passed[body][0])
                + link.rotor_inertia * acceleration
                + link.damping * speed
                + dry
        }
        _ => 0.0,
    };
    mechanism.bodies.iter().enumerate().map(of_joint).collect()
}
