//! The data of a tick for telemetry.

use heapless::Vec;
use sinew_core::{BodyState, JointStates, kinematics};
use sinew_link::message::{self, Dof, Errors, SUPPLY_UNIT, Servo, Summary, TARGET_UNIT};
use sinew_rig::board::BoardRig;

use super::mail::Tick;
use super::text;
use crate::controller::MotionController;
use crate::supervisor::{Fault, FaultSet};

/// Durations of the ticks since the last snapshot.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Times {
    tick: u32,
    sum_us: u64,
    count: u32,
    most_us: u32,
}

impl Times {
    pub(super) fn add(&mut self, took_us: u32) {
        self.tick = self.tick.wrapping_add(1);
        self.sum_us = self.sum_us.saturating_add(took_us.into());
        self.count = self.count.saturating_add(1);
        self.most_us = self.most_us.max(took_us);
    }

    /// Restarts the statistics for the next ticks; the tick counter continues.
    pub(super) fn go_on(self) -> Self {
        Self { tick: self.tick, ..Self::default() }
    }

    fn mean_us(self) -> u16 {
        let mean = self.sum_us.checked_div(self.count.into()).unwrap_or(0);
        u16::try_from(mean).unwrap_or(u16::MAX)
    }
}

/// Data of a snapshot that the controller does not have.
#[derive(Debug)]
pub(super) struct More {
    pub(super) times: Times,
    pub(super) stack_free: u32,
    pub(super) live_age_ms: Option<u16>,
    pub(super) show_hz: Option<f32>,
}

/// Returns the snapshot of the last tick. O(bodies).
// Not inlined into its caller: the loop would have the poses on its stack in every tick.
#[inline(never)]
pub(super) fn of<
    const BODIES: usize,
    const DOFS: usize,
    const SERVOS: usize,
    const COORDS: usize,
>(
    controller: &MotionController<'_, BODIES, DOFS, SERVOS, COORDS>,
    rig: &BoardRig<BODIES, DOFS, SERVOS>,
    more: &More,
) -> Tick<DOFS, SERVOS, COORDS> {
    let report = controller.report();
    let voltages = report.servos.iter().filter_map(|servo| servo.voltage_v);
    let show_s = match (report.show, more.show_hz) {
        (Some(at), Some(hz)) => at.sample() as f32 / hz,
        _ => 0.0,
    };
    let warning = || report.present.and(FaultSet::WARNINGS).first();
    let mut tick = Tick {
        number: more.times.tick,
        summary: Summary {
            state: text::state(report.state),
            fault: report.latched.first().or_else(warning).map(Fault::number),
            errors: errors(controller, rig),
            tick_us: more.times.mean_us(),
            tick_max_us: u16::try_from(more.times.most_us).unwrap_or(u16::MAX),
            overruns: report.overruns,
            stack_free: more.stack_free,
            supply_v: finite(voltages.reduce(f32::min).unwrap_or(0.0)),
            link_damaged: 0,
            link_lost: 0,
            live_age_ms: more.live_age_ms,
            show_ms: rounded(show_s * 1e3),
        },
        q: Vec::new(),
        dofs: Vec::new(),
        servos: Vec::new(),
    };
    // Each list has as much room as the controller's.
    for q in controller.measured() {
        let _ = tick.q.push(finite(*q));
    }
    for (index, dof) in report.dofs.iter().enumerate() {
        let effort = finite(dof.effort);
        let limiter = text::limiter(dof, controller.first_servo(index));
        #[expect(clippy::cast_possible_truncation, reason = "it saturates")]
        let target = (dof.error / TARGET_UNIT) as i16;
        let _ = tick.dofs.push(Dof { effort, limiter, target });
    }
    for servo in &report.servos {
        let temperature_c = servo.temperature_c.map(|t| {
            #[expect(clippy::cast_possible_truncation, reason = "it saturates")]
            let t = t as i8;
            t
        });
        let heat_percent = u8::try_from(rounded(servo.heat * 100.0)).unwrap_or(u8::MAX);
        let errors = servo.missed.saturating_add(servo.not_believed);
        let bus_errors = u16::try_from(errors).unwrap_or(u16::MAX);
        let hardware_error = servo.last_error;
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "it saturates")]
        let supply = (servo.voltage_v.unwrap_or(0.0) / SUPPLY_UNIT + 0.5) as u8;
        let of_servo = Servo { temperature_c, heat_percent, bus_errors, hardware_error, supply };
        let _ = tick.servos.push(of_servo);
    }
    tick
}

/// Returns the distance of the measured pose from the commanded pose: angles by dof, and positions of the joints in
/// space. Returns `None` while torque is off.
#[inline(never)]
fn errors<const BODIES: usize, const DOFS: usize, const SERVOS: usize, const COORDS: usize>(
    controller: &MotionController<'_, BODIES, DOFS, SERVOS, COORDS>,
    rig: &BoardRig<BODIES, DOFS, SERVOS>,
) -> Option<message::Errors> {
    let following = controller.report().following?;
    let tree = rig.tree();
    let mut places = [[BodyState::WORLD; BODIES]; 2];
    for (world, q) in places.iter_mut().zip([controller.commanded().0, controller.measured()]) {
        let mut joints = JointStates::rest(tree);
        joints.set_coordinates_at_rest(tree, q).ok()?;
        kinematics::body_states(tree.bodies(), joints.as_slice(), world);
    }
    let [commanded, measured] = &places;
    let (mut sum, mut most, mut count) = (0.0_f32, 0.0_f32, 0.0_f32);
    for (a, b) in commanded.iter().zip(measured).take(tree.len()) {
        let far = sinew_core::math::length(a.pose.translation_m - b.pose.translation_m);
        (sum, most, count) = (sum + far, most.max(far), count + 1.0);
    }
    Some(Errors {
        mean_deg: finite(following.mean_rad.to_degrees()),
        largest_deg: finite(following.most_rad.to_degrees()),
        mean_cm: finite(100.0 * sum / count.max(1.0)),
        largest_cm: finite(100.0 * most),
        worst: u8::try_from(following.dof).unwrap_or(u8::MAX),
    })
}

/// Returns 0 instead of NaN or infinity, which are not sent.
fn finite(number: f32) -> f32 {
    if number.is_finite() { number } else { 0.0 }
}

#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "it saturates")]
fn rounded(number: f32) -> u32 {
    (number + 0.5) as u32
}
