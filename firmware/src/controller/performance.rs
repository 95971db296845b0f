//! Conversion of a pose to servo commands by the tracker and the drives.

use heapless::Vec;
use sinew_core::coordinates::DofCommand;
use sinew_core::dynamics::{BodyMotion, inverse_dynamics};
use sinew_core::tracker::{Measured as Reading, Timing, Tracker, TrackerError};
use sinew_core::{JointStates, Twist, Wrench};
use sinew_rig::board::BoardRig;
use sinew_rig::drive::Numbers;

use super::coordinates::{number, put};
use super::error::ControllerError;
use super::path::Path;
use super::pose::Pose;
use super::report::DofReport;
use super::settings::{ControllerSettings, ServoSetup};
use crate::drives::{Class, Condition, Drives, Limit, ServoCommand, ServoDrive};
use crate::supervisor::Overload;

/// Maximum latency in ticks, plus one.
const DELAYS: usize = 8;

/// The error that a number was refused: there are no commands.
pub(super) struct NotFinite;

/// Input for carrying a rig without a goal.
pub(super) struct Carried<'p> {
    /// Measured pose of the rig.
    pub(super) q: &'p [f32],
    /// Target positions, by coordinates. For dofs whose servos use no feedback effort, they are the goals.
    pub(super) to: &'p [f32],
    /// Speed of each dof, which is to be braked. For dofs whose servos use no feedback effort: the speed of the goal.
    pub(super) qd: &'p [f32],
    /// By dof, effort that pushes the rig back from the ends of its ranges.
    pub(super) walls: &'p [f32],
    /// By dof, released part of its weight.
    pub(super) lowered: &'p [f32],
    /// Maximum part of the weight that is carried.
    pub(super) weight: f32,
}

/// Damping of movements while the rig is carried, 1/s: equal to that of the tracker's gains, which gears can
/// withstand.
const BRAKE_PER_S: f32 = 28.0;

/// Tracker and drives of a rig.
#[derive(Debug)]
pub(super) struct Performance<'a, const BODIES: usize, const DOFS: usize, const SERVOS: usize> {
    rig: &'a BoardRig<BODIES, DOFS, SERVOS>,
    tracker: Tracker<BODIES, DELAYS>,
    pub(super) drives: Drives<'a, BODIES, DOFS, SERVOS>,
    /// By dof, whether its servos use the tracker's feedback effort.
    corrects: Vec<bool, DOFS>,
    commands: Vec<DofCommand, DOFS>,
    out: Vec<Option<ServoCommand>, SERVOS>,
}

impl<'a, const BODIES: usize, const DOFS: usize, const SERVOS: usize>
    Performance<'a, BODIES, DOFS, SERVOS>
{
    /// Creates an unconfigured value of a rig: `init` must follow.
    #[inline(never)]
    pub(super) fn uninit(rig: &'a BoardRig<BODIES, DOFS, SERVOS>) -> Self {
        Self {
            rig,
            tracker: Tracker::uninit(),
            drives: Drives::uninit(rig),
            corrects: Vec::new(),
            commands: Vec::new(),
            out: Vec::new(),
        }
    }

    /// Initializes in place.
    #[inline(never)]
    pub(super) fn init(
        &mut self,
        settings: &ControllerSettings,
        servos: &[ServoSetup],
        timing: Timing,
    ) -> Result<(), ControllerError> {
        let Self { rig, tracker, drives, corrects, commands, out } = self;
        let mut of_drives: Vec<_, SERVOS> = Vec::new();
        of_drives.extend(servos.iter().map(|servo| servo.drive).take(SERVOS));
        drives.init(&of_drives, timing).map_err(ControllerError::Drives)?;
        // There is room: `DOFS` and `SERVOS` are the maximum numbers.
        let _ = commands.resize(rig.dofs().len(), DofCommand::default());
        let _ = out.resize(rig.servos().len(), None);
        let _ = corrects.resize(rig.dofs().len(), false);
        for drive in rig.drives() {
            let class = drive.servos.first().and_then(|servo| class(drives.servos(), *servo));
            for dof in &drive.dofs {
                if let Some(corrects) = corrects.get_mut(usize::from(*dof)) {
                    *corrects = class.is_some_and(Class::corrects);
                }
            }
        }
        let (tree, settings) = (rig.tree(), &settings.tracker);
        tracker.init_for_coordinates(tree, settings, timing).map_err(ControllerError::Tracker)?;
        let observes = settings.effective(timing.dt_s).observer.bandwidth_rad_s > 0.0;
        self.fit_gears(servos, observes).map_err(ControllerError::Tracker)
    }

    /// Sets the values that depend on each joint's gears: its observer's bandwidth, if the tracker has an observer,
    /// and its rest zone.
    #[inline(never)]
    fn fit_gears(&mut self, servos: &[ServoSetup], observes: bool) -> Result<(), TrackerError> {
        let bodies = self.rig.tree().bodies();
        let (mut bandwidths, mut rests) = ([0.0_f32; BODIES], [0.0_f32; BODIES]);
        for drive in self.rig.drives() {
            let own = drive.servos.iter().filter_map(|servo| servos.get(usize::from(*servo)));
            let corrected = own.filter(|servo| servo.drive.effort().is_some());
            let (mut least, mut sum) = (f32::INFINITY, 0.0_f32);
            for servo in corrected {
                (least, sum) = (least.min(servo.bandwidth_rad_s), sum + servo.rest_rad);
            }
            for dof in &drive.dofs {
                let mut next = 0_usize;
                // The joint to which this dof belongs.
                let joint = bodies.iter().position(|body| {
                    next = body.joint.dof_count().saturating_add(next);
                    usize::from(*dof) < next
                });
                let joint = joint.unwrap_or(BODIES);
                if let (Some(bandwidth), Some(rest)) =
                    (bandwidths.get_mut(joint), rests.get_mut(joint))
                {
                    let least = if least.is_finite() { least } else { 0.0 };
                    // A ball joint may have several drives: 0 means that no drive has set the value yet.
                    *bandwidth = if *bandwidth > 0.0 { bandwidth.min(least) } else { least };
                    *rest = rest.max(sum);
                }
            }
        }
        let bandwidths = bandwidths.get(..bodies.len()).unwrap_or_default();
        // An observer of differences has no bandwidth, and not every tracker has an observer.
        if observes {
            self.tracker.set_bandwidths(bandwidths)?;
        }
        self.tracker.set_rest(rests.get(..bodies.len()).unwrap_or_default())
    }

    /// Returns whether the servos of a dof use the tracker's feedback effort.
    pub(super) fn corrects(&self, dof: usize) -> bool {
        self.corrects.get(dof).copied().unwrap_or(false)
    }

    /// Returns the effort by which the model carries a dof, without a correction of errors, N m or N. It is from the
    /// last tick in which the rig was carried.
    pub(super) fn weight(&self, dof: usize) -> f32 {
        self.commands.get(dof).map_or(0.0, |command| command.feedforward_effort)
    }

    /// Returns whether every servo accepts an effort: otherwise the rig cannot carry itself.
    pub(super) fn carries(&self) -> bool {
        self.drives.servos().iter().all(|servo| servo.class().corrects())
    }

    /// Restarts at the rig's current pose, at rest.
    pub(super) fn begin<const COORDS: usize>(
        &mut self,
        pose: &Pose<DOFS, COORDS>,
        conditions: &[Condition],
    ) -> Result<(), NotFinite> {
        self.drives.begin(conditions);
        self.resume(pose)
    }

    /// Restarts the tracker at the rig's current pose, at rest; the drives continue.
    pub(super) fn resume<const COORDS: usize>(
        &mut self,
        pose: &Pose<DOFS, COORDS>,
    ) -> Result<(), NotFinite> {
        let measured = Reading::Positions { q: pose.q() };
        self.tracker.begin(&mut &*pose, 0, measured).map_err(|_| NotFinite)
    }

    /// Computes the commands of all servos for a tick. `share` returns the permitted part of a servo's effort. `report`
    /// supplies the factor on each dof's feedback, and receives efforts and limits. O(dofs).
    pub(super) fn step<const COORDS: usize>(
        &mut self,
        pose: &Pose<DOFS, COORDS>,
        (q, qd): (&[f32], &[f32]),
        conditions: &[Condition],
        share: impl Fn(usize) -> f32,
        report: &mut [DofReport],
    ) -> Result<&[Option<ServoCommand>], NotFinite> {
        let Self { tracker, commands, .. } = self;
        let measured = Reading::Coordinates { q, qd };
        let mut tick = tracker.step(&mut &*pose, 0, measured).map_err(|_| NotFinite)?;
        tick.dof_commands(commands).map_err(|_| NotFinite)?;
        for (command, report) in commands.iter_mut().zip(&mut *report) {
            command.feedback_effort *= report.gain;
            (report.effort, report.limit) = (command.effort(), command.limited);
        }
        for (dof, report) in report.iter().enumerate() {
            if report.gain < 1.0 {
                tracker.note_swing(dof, report.gain);
            }
        }
        self.drive(conditions, share)
    }

    /// Computes the commands of a tick without a goal: the efforts that carry the rig in its pose by its model, and
    /// that brake it. Friction is not compensated: it holds the rig where a hand has left it. O(dofs).
    // Not inlined into its caller, whose stack frame would be larger in every other tick.
    #[inline(never)]
    pub(super) fn carry<const COORDS: usize>(
        &mut self,
        path: &Path<DOFS, COORDS>,
        carried: &Carried<'_>,
        conditions: &[Condition],
        share: impl Fn(usize) -> f32,
        report: &mut [DofReport],
    ) -> Result<&[Option<ServoCommand>], NotFinite> {
        let count = self.rig.dofs().len();
        let mut efforts = [0.0; DOFS];
        let efforts = efforts.get_mut(..count).unwrap_or_default();
        path.positions(carried.to, efforts);
        let mut speeds = [0.0; DOFS];
        let speeds = speeds.get_mut(..count).unwrap_or_default();
        for (dof, (command, position)) in self.commands.iter_mut().zip(&*efforts).enumerate() {
            let qd = number(carried.qd, dof);
            // The target is the current position: no friction is fed forward for a way back.
            *command = DofCommand { position: *position, ..DofCommand::default() };
            if self.corrects.get(dof) == Some(&true) {
                put(speeds, dof, qd);
            } else {
                command.velocity = qd;
            }
        }
        let mut brakes = [0.0; DOFS];
        let brakes = brakes.get_mut(..count).unwrap_or_default();
        self.weights((carried.q, speeds), efforts, brakes)?;
        for (index, (command, dof)) in self.commands.iter_mut().zip(self.rig.dofs()).enumerate() {
            let weight = number(efforts, index);
            let brake = number(brakes, index) - weight;
            let weight = weight.max(-dof.effort).min(dof.effort);
            // A servo in position mode holds its position by itself: its whole weight is compensated until the end.
            let part = if self.corrects.get(index) == Some(&true) {
                (1.0 - number(carried.lowered, index).min(1.0)).min(carried.weight)
            } else {
                1.0
            };
            command.feedforward_effort = part * weight;
            command.feedback_effort = brake + number(carried.walls, index);
        }
        for (command, report) in self.commands.iter().zip(report) {
            report.effort = command.effort();
        }
        self.drive(conditions, share)
    }

    /// Computes, by dof, the efforts that hold a pose by the rig's model, N m or N, and in `brakes` the efforts
    /// that brake the rig. If `brakes` is empty, the latter are not computed. O(dofs).
    #[inline(never)]
    fn weights(
        &self,
        (q, speeds): (&[f32], &[f32]),
        efforts: &mut [f32],
        brakes: &mut [f32],
    ) -> Result<(), NotFinite> {
        let tree = self.rig.tree();
        let mut states = JointStates::rest(tree);
        states.set_coordinates(tree, q, speeds).map_err(|_| NotFinite)?;
        let (mut motions, mut wrenches) = ([BodyMotion::default(); BODIES], [Wrench::ZERO; BODIES]);
        let (bodies, mut braked) = (tree.bodies(), [Twist::ZERO; BODIES]);
        for (braked, state) in braked.iter_mut().zip(states.as_slice()) {
            let Twist { angular, linear } = state.velocity;
            *braked = Twist { angular: angular * -BRAKE_PER_S, linear: linear * -BRAKE_PER_S };
        }
        let gravity = self.tracker.controller().gravity_m_s2();
        for (accelerations, out) in [(&[Twist::ZERO; BODIES], efforts), (&braked, brakes)] {
            if out.is_empty() {
                break;
            }
            inverse_dynamics(
                bodies,
                states.as_slice(),
                accelerations,
                gravity,
                &[],
                &mut motions,
                &mut wrenches,
            );
            let wrenches = wrenches.get(..bodies.len()).unwrap_or_default();
            tree.efforts(states.as_slice(), wrenches, out).map_err(|_| NotFinite)?;
        }
        Ok(())
    }

    /// Returns the overload in a pose, if there is one. If servos are overloaded, returns the servo with the largest
    /// load relative to its maximum torque; otherwise the sum of the currents if that exceeds `supply_a`, the supply's
    /// current (0 if it is not known). `stall_a` returns the stall current of a servo. Friction is left out. O(dofs).
    #[inline(never)]
    pub(super) fn overload<const COORDS: usize>(
        &self,
        path: &Path<DOFS, COORDS>,
        q: &[f32],
        stall_a: impl Fn(usize) -> f32,
        supply_a: f32,
    ) -> Option<Overload> {
        let (mut efforts, mut at) = ([0.0; DOFS], [0.0; DOFS]);
        let efforts = efforts.get_mut(..self.rig.dofs().len()).unwrap_or_default();
        let resting = at.get(..efforts.len()).unwrap_or_default();
        self.weights((q, resting), efforts, &mut []).ok()?;
        path.positions(q, &mut at);
        let (mut most, mut found) = (1.0, None);
        let (mut sum_a, mut most_a, mut thirstiest) = (0.0, 0.0, 0);
        for drive in self.rig.drives() {
            let dof = drive.dofs.first().copied().unwrap_or(0);
            let of = |numbers: &[f32]| -> Numbers {
                let mut own = Numbers::new();
                for dof in &drive.dofs {
                    // A drive's dofs are counted: there is room.
                    let _ = own.push(number(numbers, usize::from(*dof)));
                }
                own
            };
            let Ok(pose) = drive.drive.at_joints(&of(&at)) else { continue };
            let Ok(torques) = pose.servo_torques(&of(efforts)) else { continue };
            let mut own_a = 0.0;
            for (index, shaft_nm) in drive.servos.iter().zip(&torques) {
                let index = usize::from(*index);
                let Some(servo) = self.rig.servos().get(index) else { continue };
                let own = servo.servo.settings();
                let nm = (shaft_nm / own.gear).abs();
                let share = nm / own.torque_nm;
                if share > most {
                    let [mnm, most_mnm] = [nm, own.torque_nm].map(thousandths);
                    (most, found) = (share, Some(Overload::Servo { dof, mnm, most_mnm }));
                }
                // At stall a servo draws its stall current from the supply. With less torque its voltage is lower, too.
                let a = nm / own.torque_constant_nm_a;
                own_a += a * a / stall_a(index);
            }
            sum_a += own_a;
            if own_a > most_a {
                (most_a, thirstiest) = (own_a, dof);
            }
        }
        let is_much = supply_a > 0.0 && sum_a > supply_a;
        let [ma, most_ma] = [sum_a, supply_a].map(thousandths);
        found.or(is_much.then_some(Overload::Supply { dof: thirstiest, ma, most_ma }))
    }

    /// Computes the servos' commands, and limits their currents to the permitted parts.
    fn drive(
        &mut self,
        conditions: &[Condition],
        share: impl Fn(usize) -> f32,
    ) -> Result<&[Option<ServoCommand>], NotFinite> {
        let Self { rig, tracker, drives, commands, out, .. } = self;
        // A current is limited to its permitted part below. In position mode the offset is limited, which is the
        // effort beyond the target; in PWM mode the effort itself is limited, since the part of the voltage against
        // the back-EMF gives no effort.
        for drive in rig.drives() {
            let class = drive.servos.first().and_then(|servo| class(drives.servos(), *servo));
            if !matches!(class, Some(Class::Position | Class::Voltage)) {
                continue;
            }
            let servos = drive.servos.iter().map(|servo| usize::from(*servo));
            let share = servos.map(&share).fold(1.0, f32::min);
            for dof in &drive.dofs {
                if let Some(command) = commands.get_mut(usize::from(*dof)) {
                    command.feedforward_effort *= share;
                    command.feedback_effort *= share;
                }
            }
        }
        drives.step(commands, conditions, out).map_err(|_| NotFinite)?;
        // Most ticks have no such servo, and skip the pass over the drives.
        if out.iter().flatten().any(gives_its_most) {
            for drive in rig.drives() {
                let of_drive = drive.servos.iter().filter_map(|servo| out.get(usize::from(*servo)));
                if of_drive.flatten().any(gives_its_most) {
                    drive.dofs.iter().for_each(|dof| tracker.note_limited(usize::from(*dof)));
                }
            }
        }
        for (index, servo) in out.iter_mut().enumerate() {
            if let Some(ServoCommand { command: sinew_servo_bus::Command::Current(a), .. }) = servo
            {
                *a *= share(index);
            }
        }
        Ok(out)
    }
}

/// Returns whether a servo cannot give more effort. A hot servo does not count: the observer must learn the effect
/// of heat, or a joint would sag further with each tick of less current.
fn gives_its_most(servo: &ServoCommand) -> bool {
    matches!(servo.limit, Some(Limit::Torque | Limit::Current | Limit::Voltage | Limit::Stale))
}

#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "it saturates")]
fn thousandths(of: f32) -> u32 {
    (of * 1e3) as u32
}

fn class(servos: &[ServoDrive], servo: u16) -> Option<Class> {
    servos.get(usize::from(servo)).map(ServoDrive::class)
}

#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "a test may fail by panicking")]
mod tests {
    use sinew_rig::toml_file;
    use sinew_servo_bus::{Command, Effort, Feedback};

    use super::*;
    use crate::drives::{CurrentSettings, CutOff, DriveSettings, Encoder};
    use crate::supervisor::detect::{HeatSettings, SupplySettings, WindingSettings};

    /// Two servos that face each other on a joint. One of them was never read.
    const PAIR: &str = r#"
name = "pair"
[[body]]
name = "base"
mass_kg = 1
[[body]]
name = "link"
mass_kg = 0.1
[[joint]]
name = "hinge"
type = "revolute"
parent = "base"
child = "link"
axis = [0, 1, 0]
[[servo]]
name = "left"
model = "XL330-M288-T"
id = 1
[[servo]]
name = "right"
model = "XL330-M288-T"
id = 2
[[drive]]
joints = ["hinge"]
servos = ["left", "right"]
matrix = { rows = [[0.5, -0.5]] }
"#;

    #[test]
    fn a_joint_that_is_not_measured_is_carried_where_it_is() {
        let described = toml_file::read(PAIR).unwrap();
        let rig = BoardRig::<2, 1, 2>::bake(&described, &described.mechanism().unwrap()).unwrap();
        let timing = Timing { dt_s: 0.005, latency_ticks: 1 };
        let current = CurrentSettings {
            encoder: Encoder::default(),
            blind_rad: 0.01,
            current_a: 1.0,
            cut_off: CutOff::default(),
        };
        let setup = ServoSetup {
            drive: DriveSettings::Current(current),
            bandwidth_rad_s: 0.0,
            rest_rad: 0.0,
            heat: HeatSettings::default(),
            supply: SupplySettings::of(5.0, 3.5, 7.0),
            winding: WindingSettings::of_stall(1.47),
            stall_a: 1.47,
            stall_nm: 0.52,
            shutdown_c: 70.0,
        };
        let mut performance = Performance::uninit(&rig);
        let settings = ControllerSettings::default();
        performance.init(&settings, &[setup; 2], timing).map_err(|_| ()).unwrap();
        let path = Path::<1, 1>::new(&rig, timing.dt_s).unwrap();
        let q = [0.5];
        let read = Feedback {
            position_rad: Encoder::default().zero_rad + q[0],
            velocity_rad_s: 0.0,
            effort: Effort::Current(0.0),
            age_ticks: 0,
        };
        let known = Condition { temperature_c: Some(30.0), ..Condition::default() };
        let conditions = [Condition { feedback: Some(read), ..known }, known];
        for _ in 0..100 {
            let mut reports = [DofReport::default()];
            let carried =
                Carried { q: &q, to: &q, qd: &[0.0], walls: &[0.0], lowered: &[0.0], weight: 1.0 };
            let out = performance.carry(&path, &carried, &conditions, |_| 1.0, &mut reports);
            let out = out.map_err(|_| ()).unwrap();
            for servo in out.iter().flatten() {
                // The joint's axis is vertical, so its weight needs no torque.
                let a = if let Command::Current(a) = servo.command { a } else { f32::NAN };
                assert!(a.abs() < 1e-4, "{servo:?}");
            }
        }
    }
}
