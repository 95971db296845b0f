//! Rest zones of joints: small errors are ignored while the target is constant.

use glam::Vec3;

use crate::control::Gains;
use crate::joint_states::JointStates;
use crate::joint_targets::JointTargets;
use crate::math;
use crate::observer::Stance;
use crate::transform::Twist;
use crate::tree::Tree;

/// Maximum speed of a target that counts as constant, rad/s. For slides, 1 rad/s stands for 0.1 m/s.
pub const STANDS_RAD_S: f32 = 0.02;
/// Maximum speed of a joint at rest, rad/s. A faster joint only passes through its zone.
const GLIDES_RAD_S: f32 = 0.2;
/// Time in which a zone opens, s. The next constant is the time in which it closes.
const OPENS_S: f32 = 0.1;
const CLOSES_S: f32 = 0.02;
/// Radius, in units of the zone's radius, within which a joint is near its target. A joint that swings through the play
/// of its gear stays within this radius, even with twice the modelled play. A push with half of the joint's spare
/// torque moves the joint out of it.
const NEAR: f32 = 4.0;
/// Time for which a joint must be near its target before it stands, s. Until then, a pushed joint returns at full
/// speed.
const SETTLES_S: f32 = 0.3;
/// Radius, in units of the zone's radius, within which a standing joint learns nothing. Farther off, its model error
/// is larger than gear and friction can hide.
const HELD: f32 = 1.5;
/// Factor that converts a slide's speed to rad: 10 rad per m.
const SLIDE_RAD_M: f32 = 10.0;

/// The rest zones of all joints.
///
/// An encoder behind a gear with play does not show the joint's position within the play, and stiction holds a joint
/// that is slightly off. A loop that corrects such an error hunts. While the target is constant and the joint hardly
/// moves, an error within a zone of half the play plus a step of the encoder therefore counts as zero; of a larger
/// error, only the part beyond the zone counts. The zone opens and closes over several ticks, so that no command jumps.
#[derive(Debug)]
pub(super) struct Rest<const N: usize> {
    dt_s: f32,
    /// Radius of each joint's zone, rad or m; 0 for no zone.
    radii: [f32; N],
    /// Open share of each joint's zone, 0 to 1.
    open: [f32; N],
    /// Time for which each joint has been near a constant target, s.
    near_s: [f32; N],
    stances: [Stance; N],
    is_set: bool,
}

impl<const N: usize> Rest<N> {
    /// Creates rest zones for an empty tree.
    #[inline(never)]
    pub(super) fn uninit() -> Self {
        Self {
            dt_s: 0.0,
            radii: [0.0; N],
            open: [0.0; N],
            near_s: [0.0; N],
            stances: [Stance::Moves; N],
            is_set: false,
        }
    }

    /// Removes all zones.
    pub(super) fn init(&mut self, dt_s: f32) {
        self.dt_s = dt_s;
        self.begin();
        self.is_set = false;
    }

    /// Closes all zones, as at the start.
    pub(super) fn begin(&mut self) {
        self.open.fill(0.0);
        self.near_s.fill(0.0);
        self.stances.fill(Stance::Moves);
    }

    /// Sets the radius of each joint's zone, rad or m.
    pub(super) fn set(&mut self, radii: &[f32]) {
        self.begin();
        self.radii.fill(0.0);
        self.radii.iter_mut().zip(radii).for_each(|(own, radius)| *own = *radius);
        self.is_set = true;
    }

    /// Returns the stance of each joint in the last tick; empty if no zones are set.
    pub(super) fn stances(&self) -> &[Stance] {
        if self.is_set { &self.stances } else { &[] }
    }

    /// Subtracts, from the targets' accelerations, the gains' response to the errors within the zones. O(n).
    ///
    /// The targets' poses are unchanged: drives and reports see the whole error.
    #[inline(never)]
    pub(super) fn apply(
        &mut self,
        tree: &Tree<N>,
        gains: &[Gains],
        targets: &mut JointTargets<N>,
        states: &JointStates<N>,
    ) {
        if !self.is_set {
            return;
        }
        let joints = tree.bodies().iter().zip(states.as_slice());
        let zones = self.radii.iter().zip(&mut self.open).zip(&mut self.near_s);
        for (joint, (((body, state), (((radius, open), near_s), stance)), gains)) in
            joints.zip(zones.zip(&mut self.stances)).zip(gains).enumerate()
        {
            let Some(target) = targets.states().get(joint) else { return };
            if *radius <= 0.0 {
                continue;
            }
            let slides = body.joint.slides();
            let is_slower = |velocity: &Twist, than_rad_s: f32| {
                let own = if slides { velocity.linear * SLIDE_RAD_M } else { velocity.angular };
                own.dot(own) < than_rad_s * than_rad_s
            };
            let stands = is_slower(&target.velocity, STANDS_RAD_S);
            *open = if stands && is_slower(&state.velocity, GLIDES_RAD_S) {
                (*open + self.dt_s / OPENS_S).min(1.0)
            } else {
                (*open - self.dt_s / CLOSES_S).max(0.0)
            };
            if !stands && *open <= 0.0 {
                (*stance, *near_s) = (Stance::Moves, 0.0);
                continue;
            }
            let off = if slides {
                // A target's linear acceleration is a vector of the parent's frame, in the axes of the desired pose.
                let way = target.pose.translation_m - state.pose.translation_m;
                target.pose.rotation.conjugate() * way
            } else {
                // The chord has the direction of the arc, and its length up to a relative error of the squared angle
                // divided by 24: 0.0004 for a zone of 0.1 rad.
                let turn = math::turn_in_body(state.pose.rotation, target.pose.rotation);
                let chord = Vec3::new(turn.x, turn.y, turn.z) * 2.0;
                if turn.w < 0.0 { -chord } else { chord }
            };
            let squared = off.dot(off);
            let is_nearer = |than: f32| squared <= than * than;
            *near_s = if stands && is_nearer(*radius * NEAR) { *near_s + self.dt_s } else { 0.0 };
            *stance = if *near_s > SETTLES_S { Stance::Stands } else { Stance::Moves };
            if *open <= 0.0 {
                continue;
            }
            let zone = *radius * *open;
            let is_within = is_nearer(zone);
            let within = if is_within { off } else { off * (zone / math::sqrt(squared)) };
            let mut against = Twist::ZERO;
            if slides {
                against.linear = within * -gains.linear_kp();
            } else {
                against.angular = within * -gains.kp();
            }
            let stays = *stance == Stance::Stands && is_nearer(*radius * HELD);
            if *open >= 1.0 && (is_within || stays) {
                *stance = Stance::Rests;
            }
            targets.add_acceleration(joint, against);
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::observer::Stance;
    use crate::tracker::{Frame, FrameSource, Measured, Settings, Timing, Tracker, TrackerError};
    use crate::{Body, Inertia, JointKind, RotationalInertia, Transform, Tree};
    use glam::Vec3;

    const DT_S: f32 = 0.002;
    const INERTIA_KG_M2: f32 = 0.01;
    const ZONE_RAD: f32 = 0.005;

    /// Target position and speed of a revolute joint.
    struct Target([f32; 1], [f32; 1]);

    impl FrameSource for Target {
        fn frame(&mut self, _: i32) -> Frame<'_> {
            Frame::Coordinates { q: &self.0, qd: &self.1, qdd: &[0.0] }
        }
    }

    /// Returns a tracker of a wheel about the vertical, without an observer.
    fn tracker() -> Tracker<1> {
        let wheel = Body {
            parent: None,
            joint: JointKind::Revolute { axis: Vec3::Y },
            placement: Transform::IDENTITY,
            inertia: Inertia {
                mass_kg: 1.0,
                center_of_mass_m: Vec3::ZERO,
                rotational_kg_m2: RotationalInertia::diagonal(
                    INERTIA_KG_M2,
                    INERTIA_KG_M2,
                    INERTIA_KG_M2,
                ),
            },
            rotor_inertia: 0.0,
        };
        let tree = Tree::from_bodies(&[wheel]).unwrap();
        let timing = Timing { dt_s: DT_S, latency_ticks: 0 };
        let mut tracker = Tracker::new(tree, &Settings::default(), timing).unwrap();
        tracker.set_rest(&[ZONE_RAD]).unwrap();
        tracker
    }

    fn effort_nm(tracker: &mut Tracker<1>, target: &mut Target, at_rad: f32) -> f32 {
        let mut efforts = [0.0];
        let measured = Measured::Coordinates { q: &[at_rad], qd: &[0.0] };
        tracker.step(target, 0, measured).unwrap().efforts(&mut efforts).unwrap();
        efforts[0]
    }

    #[test]
    fn an_error_counts_by_what_lies_beyond_the_zone_of_a_target_that_stands() {
        for (off_rad, counts_rad) in [(0.004, 0.0), (0.02, 0.02 - ZONE_RAD)] {
            let (mut tracker, mut target) = (tracker(), Target([off_rad], [0.0]));
            let mut effort = effort_nm(&mut tracker, &mut target, 0.0);
            for _ in 0..100 {
                let next = effort_nm(&mut tracker, &mut target, 0.0);
                // The zone opens over 50 ticks.
                let most = INERTIA_KG_M2 * 200.0 * ZONE_RAD * (DT_S / super::OPENS_S);
                assert!((next - effort).abs() < 1.01 * most, "{effort} became {next}");
                effort = next;
            }
            assert!((effort - INERTIA_KG_M2 * 200.0 * counts_rad).abs() < 1e-6, "{effort}");
        }
    }

    #[test]
    fn a_target_that_moves_on_closes_the_zone_without_a_jump() {
        let (mut tracker, mut target) = (tracker(), Target([0.004], [0.0]));
        for _ in 0..100 {
            effort_nm(&mut tracker, &mut target, 0.0);
        }
        // The damping torque for its speed starts at once, in the first tick.
        target.1 = [1.01 * super::STANDS_RAD_S];
        let mut effort = effort_nm(&mut tracker, &mut target, 0.0);
        for _ in 0..20 {
            let next = effort_nm(&mut tracker, &mut target, 0.0);
            let most = INERTIA_KG_M2 * 200.0 * ZONE_RAD * (DT_S / super::CLOSES_S);
            assert!((next - effort).abs() < 1.01 * most, "{effort} became {next}");
            effort = next;
        }
        let kd = 2.0 * crate::math::sqrt(200.0);
        let whole = INERTIA_KG_M2 * (200.0 * 0.004 + kd * target.1[0]);
        assert!((effort - whole).abs() < 1e-6, "{effort}");
    }

    #[test]
    fn a_joint_stands_once_it_has_settled_until_it_is_pushed_or_its_target_moves() {
        let (mut tracker, mut target) = (tracker(), Target([0.0], [0.0]));
        let mut after = |target: &mut Target, at_rad: f32, ticks: u16| {
            for _ in 0..ticks {
                effort_nm(&mut tracker, target, at_rad);
            }
            tracker.rest.stances()[0]
        };
        let settles = 150;
        assert!((f32::from(settles) * DT_S - super::SETTLES_S).abs() < 1e-6);
        let (near_rad, far_rad) = (0.9 * super::NEAR * ZONE_RAD, 1.1 * super::NEAR * ZONE_RAD);
        assert_eq!(after(&mut target, near_rad, settles - 2), Stance::Moves);
        assert_eq!(after(&mut target, near_rad, 4), Stance::Stands);
        assert_eq!(after(&mut target, 0.5 * ZONE_RAD, 1), Stance::Rests);
        assert_eq!(after(&mut target, 0.9 * super::HELD * ZONE_RAD, 1), Stance::Rests);
        assert_eq!(after(&mut target, 1.1 * super::HELD * ZONE_RAD, 1), Stance::Stands);
        assert_eq!(after(&mut target, far_rad, 1), Stance::Moves);
        assert_eq!(after(&mut target, near_rad, settles - 2), Stance::Moves);
        assert_eq!(after(&mut target, near_rad, 4), Stance::Stands);
        target.1 = [1.01 * super::STANDS_RAD_S];
        assert_eq!(after(&mut target, near_rad, 1), Stance::Moves);
    }

    #[test]
    fn a_tracker_that_begins_anew_closes_its_zones() {
        let (mut tracker, mut target) = (tracker(), Target([0.004], [0.0]));
        let first_nm = effort_nm(&mut tracker, &mut target, 0.0);
        for _ in 0..200 {
            effort_nm(&mut tracker, &mut target, 0.0);
        }
        assert_eq!(tracker.rest.stances(), [Stance::Rests]);
        let measured = Measured::Coordinates { q: &[0.0], qd: &[0.0] };
        tracker.begin(&mut target, 0, measured).unwrap();
        assert_eq!(tracker.rest.stances(), [Stance::Moves]);
        let effort = effort_nm(&mut tracker, &mut target, 0.0);
        assert!((effort - first_nm).abs() < 1e-6, "{effort}, at first {first_nm}");
    }

    #[test]
    fn zones_that_cannot_be_are_refused() {
        let mut tracker = tracker();
        for bad in [&[][..], &[0.1, 0.1], &[-0.1], &[f32::NAN], &[f32::INFINITY]] {
            assert_eq!(tracker.set_rest(bad), Err(TrackerError::Rest));
        }
    }
}
