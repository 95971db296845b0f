//! Parts of a rig's controller, buses and simulated servos.

use sinew_core::tracker::{MethodName, Settings as TrackerSettings, Timing as LoopTiming};
use sinew_firmware::controller::{
    Approach, ControllerSettings, ServoSetup, approach, estimated_us,
};
use sinew_firmware::node::NodeSettings;
use sinew_firmware::supervisor::Settings;
use sinew_firmware::supervisor::detect::FollowingSettings;
use sinew_rig::description::{Servo, Supply as RigSupply};
use sinew_rig::mechanism::JointModel;
use sinew_rig::tracking::{ServoTracking, tracking};
use sinew_rig::{Description, Mechanism};
use sinew_servo_bus::Schedule;
use sinew_servo_sim::plant::RigPlant;
use sinew_servo_sim::rig::{RigServosError, servos};
use sinew_servo_sim::supply::Supply;
use sinew_servo_sim::variation::Variation;
use sinew_servo_tools::position_gain::PositionGain;
use sinew_show::{Show, ShowFrames};

use super::error::PartsError;
use super::line::{Line, lines};
use super::options::Options;
use super::schedule::{Load, Needs, choose};
use super::servo_part::{Drive, ServoPart, drives, setup, single};
use super::{COORDINATES, CompactRig};
use crate::rig_hash;

/// Clock of the reference board's processor, an STM32F446, Hz.
const BOARD_HZ: u32 = 180_000_000;

/// Ways of a rig to the beginnings of its shows.
#[derive(Debug)]
pub struct Ways {
    board: CompactRig,
    settings: Settings,
    tick_us: u32,
}

impl Ways {
    /// Computes the way from a pose to the beginning of a show, as [`RigParts::approach`].
    pub fn approach(&self, show: &[u8], from: &[f32]) -> Option<Approach> {
        way((&self.board, &self.settings, self.tick_us), show, from)
    }
}

fn way(
    (board, settings, tick_us): (&CompactRig, &Settings, u32),
    show: &[u8],
    from: &[f32],
) -> Option<Approach> {
    let dt_s = 1e-6 * tick_us as f32;
    let mut frames = ShowFrames::<COORDINATES>::new(Show::open(show).ok()?, dt_s).ok()?;
    approach(board, settings, &mut frames, dt_s, from)
}

/// The parts of a rig that plays: its compact form, settings, lines and servos.
pub struct RigParts {
    pub(super) board: CompactRig,
    pub(super) settings: ControllerSettings,
    pub(super) setups: Vec<ServoSetup>,
    /// Schedule of the line whose readings have the longest delay; of the lines that close the tracker's loop, if there
    /// are any.
    pub(super) schedule: Schedule,
    pub(super) schedules: Vec<Schedule>,
    supply: Option<RigSupply>,
    /// Bus lines, in the order in which the rig's servos name them.
    pub lines: Vec<Line>,
    /// Servos, in the rig's order.
    pub servos: Vec<ServoPart>,
    /// Maximum inertia that each servo moves, without its rotor, at its own shaft, kg m².
    pub load_inertias_kg_m2: Vec<f64>,
    /// Names of the dofs.
    pub names: Vec<String>,
    /// Whether each dof slides: its numbers are in m and N.
    pub slides: Vec<bool>,
    /// Drive of the servos of each dof; `None` if no servo moves the dof.
    pub drives: Vec<Option<Drive>>,
    /// First servo of each dof.
    pub first_servo: Vec<Option<usize>>,
    /// Tick rate, Hz.
    pub rate_hz: u32,
    /// Estimated time of a tick on the reference board without its bus, µs, and the tick rate that the board can keep
    /// with it; `None` if it cannot keep any rate that servos of this drive need.
    pub on_board: (u32, Option<u32>),
    variation: Variation,
}

impl RigParts {
    /// Makes the parts of a rig.
    ///
    /// # Errors
    /// [`PartsError`] names the servo or the line, and the valid choices.
    pub fn new(
        rig: &Description,
        mechanism: &Mechanism,
        options: Options,
    ) -> Result<Self, PartsError> {
        if mechanism.bodies.iter().any(|link| link.joint == JointModel::Free) {
            return Err(PartsError::Travels);
        }
        let board = CompactRig::bake(rig, mechanism)?;
        let (rig_crc, _) = rig_hash(rig, mechanism);
        let own = servos(rig, mechanism)?;
        let mut lines = lines(&own, options)?;
        let drives = drives(&board, &own, options.drive)?;
        let mut parts = Vec::new();
        for (index, (own, drive)) in own.into_iter().zip(drives).enumerate() {
            let line = lines.iter().position(|line| line.name == own.bus).unwrap_or_default();
            lines[line].servos.push(index);
            parts.push(ServoPart { own, drive, place: (line, lines[line].servos.len() - 1) });
        }
        let supply_a = rig.supply.map_or(0.0, |supply| single(supply.current_a));
        let mut settings =
            ControllerSettings { rig_crc, supply_a, ..ControllerSettings::default() };
        let loads: Vec<(&str, Load)> =
            lines.iter().map(|line| (line.name.as_str(), line.load(&parts))).collect();
        let compute_us = estimated_us(parts.len(), BOARD_HZ);
        if options.is_of_board {
            settings.compute_us = compute_us;
        }
        let needs = Needs { compute_us: settings.compute_us, stale_s: settings.stale_s };
        let (rate_hz, schedules) = choose(&loads, options.rate_hz, needs)?;
        let of_board = Needs { compute_us, ..needs };
        let holds =
            choose(&loads, Some(rate_hz), of_board).or_else(|_| choose(&loads, None, of_board));
        let on_board = (compute_us, holds.ok().map(|(rate_hz, _)| rate_hz));
        // The tracker's readings are those of lines that close its loop, if there are any.
        let closes = loads.iter().any(|(_, load)| load.closes_loop);
        let latest = loads
            .iter()
            .zip(&schedules)
            .filter(|((_, load), _)| load.closes_loop == closes)
            .map(|(_, schedule)| *schedule)
            .max_by_key(Schedule::groups);
        let schedule = latest.ok_or(PartsError::NoServos)?;
        let dt_s = 1e-6 * f64::from(schedule.tick_us());
        let gears = tracking(rig, mechanism, dt_s)?;
        let setup_of = |((part, gear), servo): ((&ServoPart, &ServoTracking), &Servo)| {
            let model = rig.servo_model(&servo.model).unwrap_or_default();
            let gain = PositionGain::of(servo, &model, gear.stiffness)?;
            Ok(setup(rig, part, gear, gain))
        };
        let each = parts.iter().zip(&gears).zip(&rig.servos);
        let setups = each.map(setup_of).collect::<Result<Vec<ServoSetup>, PartsError>>()?;
        settings.tracker = tracker(&schedule);
        refuse_shaking(rig, &parts, &gears, &settings.tracker, &schedule)?;
        let least = setups
            .iter()
            .zip(&parts)
            .filter(|(setup, part)| part.drive.closes_loop() && setup.bandwidth_rad_s > 0.0)
            .map(|(setup, _)| setup.bandwidth_rad_s)
            .reduce(f32::min);
        let observer = &mut settings.tracker.observer;
        if observer.bandwidth_rad_s > 0.0 {
            // Joints without a servo get the smallest bandwidth of all.
            observer.bandwidth_rad_s = least.unwrap_or(observer.bandwidth_rad_s);
        }
        let (drives, first_servo) = by_dof(&board, &parts);
        let slides = mechanism.bodies.iter().flat_map(|link| {
            let is_slide = matches!(link.joint, JointModel::Prismatic(_));
            std::iter::repeat_n(is_slide, link.joint.kind().dof_count())
        });
        Ok(Self {
            settings,
            setups,
            schedule,
            schedules,
            supply: rig.supply,
            lines,
            servos: parts,
            load_inertias_kg_m2: gears.iter().map(|gear| gear.load_inertia_kg_m2).collect(),
            names: mechanism.dof_names(),
            slides: slides.collect(),
            drives,
            first_servo,
            rate_hz,
            on_board,
            board,
            variation: Variation::default(),
        })
    }

    /// Makes the simulated plant differ from the controller's model. Call it once.
    pub fn vary(&mut self, variation: Variation) {
        let tick_s = 1e-6 * f64::from(self.tick_us());
        for part in &mut self.servos {
            variation.change_servo(&mut part.own.kind, tick_s);
        }
        self.variation = variation;
    }

    /// Computes the way from a pose to the beginning of a show. Returns `None` if `show` is not a valid show, has too
    /// many coordinates, or the way takes longer than 5 minutes. The show's rig is not checked.
    pub fn approach(&self, show: &[u8], from: &[f32]) -> Option<Approach> {
        way((&self.board, &self.settings.supervisor, self.tick_us()), show, from)
    }

    /// Returns what computes such ways without these parts.
    pub fn ways(&self) -> Ways {
        Ways {
            board: self.board.clone(),
            settings: self.settings.supervisor,
            tick_us: self.tick_us(),
        }
    }

    /// Returns the controller's settings for a servo.
    pub(crate) fn setup(&self, servo: usize) -> &ServoSetup {
        &self.setups[servo]
    }

    /// Returns the limits of the following error.
    pub(crate) fn following_limit(&self) -> FollowingSettings {
        self.settings.following
    }

    /// Lets following errors be as large and as long as a setting may be, so that they end no show. Returns the limits
    /// from before.
    pub(crate) fn without_following_faults(&mut self) -> FollowingSettings {
        let most = FollowingSettings { most_rad: 10.0, time_s: 10.0 };
        std::mem::replace(&mut self.settings.following, most)
    }

    /// Returns the CRC by which shows identify this rig.
    pub fn rig_crc(&self) -> u32 {
        self.settings.rig_crc
    }

    /// Accepts shows with this CRC instead of the rig's own: the CRC of the same rig before servos were added to it.
    pub fn take_shows_of(&mut self, rig_crc: u32) {
        self.settings.rig_crc = rig_crc;
    }

    /// Returns the rig in its compact form.
    pub fn compact(&self) -> &CompactRig {
        &self.board
    }

    /// Returns the settings of a node that drives this rig.
    pub fn node_settings(&self) -> NodeSettings {
        NodeSettings::new(self.settings.clone(), self.schedule)
    }

    /// Returns the method of the tracker.
    pub fn method(&self) -> MethodName {
        self.settings.tracker.method
    }

    /// Returns the number of ticks in which each servo of a line is read once.
    pub fn groups(&self, line: usize) -> u32 {
        self.schedules[line].groups()
    }

    /// Returns whether a dof is moved by servos that report nothing. The position of such a dof is unknown.
    pub fn tells_nothing(&self, dof: usize) -> bool {
        self.drives[dof] == Some(Drive::Pulses)
    }

    /// Returns the length of a tick, µs.
    pub fn tick_us(&self) -> u32 {
        self.schedule.tick_us()
    }

    /// Returns the rig's mechanism as a plant that the servos of all lines move, with the changes of [`Self::vary`].
    ///
    /// # Errors
    /// [`RigServosError`] if the servos cannot be simulated.
    pub fn plant(
        &self,
        rig: &Description,
        mechanism: &Mechanism,
    ) -> Result<RigPlant, RigServosError> {
        let servos = self.lines.iter().flat_map(|line| &line.servos);
        let names: Vec<&str> = servos.map(|servo| self.servos[*servo].own.name.as_str()).collect();
        let mut bodies = mechanism.clone();
        self.variation.change_bodies(&mut bodies);
        RigPlant::new(rig, &bodies, &names)
    }

    /// Returns the index of a servo among all servos, line after line.
    pub(super) fn place_on_bench(&self, servo: usize) -> usize {
        let (line, place) = self.servos[servo].place;
        place + self.lines[..line].iter().map(|line| line.servos.len()).sum::<usize>()
    }

    /// Returns the voltage of the common supply, if the rig's file states it, V.
    pub fn supply_v(&self) -> Option<f32> {
        self.supply.map(|supply| single(supply.voltage_v))
    }

    /// Returns the common supply, if the rig's file states it.
    pub(super) fn supply(&self) -> Option<Supply> {
        self.supply.map(|supply| Supply::limited(supply.voltage_v, supply.current_a))
    }

    /// Returns supplies for a rig whose file states none: one for each line, with the voltage of its first servo.
    pub(super) fn stiff_supplies(&self) -> Vec<Supply> {
        let first = |line: &Line| &self.servos[line.servos[0]].own;
        self.lines.iter().map(|line| Supply::stiff(first(line).kind.voltage_v)).collect()
    }
}

/// Refuses a rig with a joint that oscillates by itself in the tracker's loop.
fn refuse_shaking(
    rig: &Description,
    parts: &[ServoPart],
    gears: &[ServoTracking],
    tracker: &TrackerSettings,
    schedule: &Schedule,
) -> Result<(), PartsError> {
    if tracker.observer.bandwidth_rad_s <= 0.0 {
        return Ok(());
    }
    let dt_s = 1e-6 * f64::from(schedule.tick_us());
    let latency_ticks = usize::try_from(schedule.groups()).unwrap_or(usize::MAX);
    let kp_per_s2 = f64::from(tracker.kp);
    for ((part, gear), servo) in parts.iter().zip(gears).zip(&rig.servos) {
        let model = rig.servo_model(&servo.model).unwrap_or_default();
        let decays =
            |braking_nm_s| gear.decays(&model, dt_s, latency_ticks, kp_per_s2, braking_nm_s);
        let by_voltage = || decays(model.winding_damping());
        let is_calm = match part.drive {
            Drive::Current => decays(0.0),
            Drive::Voltage => by_voltage(),
            Drive::Position | Drive::Pulses => true,
        };
        if let Some(bandwidth) = gear.bandwidth.filter(|_| !is_calm) {
            return Err(PartsError::Shakes {
                servo: servo.name.clone(),
                bandwidth_rad_s: bandwidth.rad_s,
                rate_hz: 1_000_000 / schedule.tick_us(),
                voltage_bears: part.drive == Drive::Current && by_voltage(),
            });
        }
    }
    Ok(())
}

/// Returns the recommended tracker settings if the delay of readings allows them, else the default settings.
fn tracker(schedule: &Schedule) -> TrackerSettings {
    let latency_ticks = usize::try_from(schedule.groups()).unwrap_or(usize::MAX);
    let timing = LoopTiming { dt_s: 1e-6 * schedule.tick_us() as f32, latency_ticks };
    if timing.check_recommended().is_ok() {
        // Targets are the rig's own joints: the error of each joint is local, and no other joint's gear contributes
        // to it.
        TrackerSettings {
            method: MethodName::Local,
            ..TrackerSettings::recommended().effective(timing.dt_s)
        }
    } else {
        TrackerSettings { method: MethodName::Local, ..TrackerSettings::default() }
    }
}

fn by_dof(board: &CompactRig, servos: &[ServoPart]) -> (Vec<Option<Drive>>, Vec<Option<usize>>) {
    let count = board.dofs().len();
    let (mut drives, mut first) = (vec![None; count], vec![None; count]);
    for drive in board.drives() {
        let servo = drive.servos.first().map(|servo| usize::from(*servo));
        for dof in &drive.dofs {
            let dof = usize::from(*dof);
            first[dof] = servo;
            drives[dof] = servo.map(|servo| servos[servo].drive);
        }
    }
    (drives, first)
}
