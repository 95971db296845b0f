//! The report of a tick.

use heapless::Vec;
use sinew_show::Position;

use crate::drives::Limit;
use crate::supervisor::detect::Concern;
use crate::supervisor::{Answer, FaultSet, GuardReason, Moving, Registers, Source, State};

/// Report of a tick, with at most `DOFS` dofs and `SERVOS` servos.
#[derive(Debug, Clone)]
pub struct Report<const DOFS: usize, const SERVOS: usize> {
    /// State of the supervisor.
    pub state: State,
    /// Source of the commanded pose.
    pub source: Source,
    /// Position in the loaded show.
    pub show: Option<Position>,
    /// Answer to the command of this tick.
    pub answer: Option<Answer>,
    /// Faults whose condition is present.
    pub present: FaultSet,
    /// Faults and warnings that were raised in this tick.
    pub raised: FaultSet,
    /// Faults that must be cleared.
    pub latched: FaultSet,
    /// Result of the comparison of servos' registers; unknown while torque is on.
    pub registers: Registers,
    /// The joint that moves too fast for the rig to be armed, while torque is off.
    pub moving: Option<Moving>,
    /// Distance of the rig from its commanded pose; `None` while torque is off.
    pub following: Option<Following>,
    /// Reports of the dofs.
    pub dofs: Vec<DofReport, DOFS>,
    /// Reports of the servos.
    pub servos: Vec<ServoReport, SERVOS>,
    /// Number of ticks since the start that took too long.
    pub overruns: u32,
}

impl<const DOFS: usize, const SERVOS: usize> Report<DOFS, SERVOS> {
    /// Creates the report before the first tick.
    #[inline(never)]
    pub(super) fn new(state: State, source: Source, dofs: usize, servos: usize) -> Self {
        Self {
            state,
            source,
            show: None,
            answer: None,
            present: FaultSet::EMPTY,
            raised: FaultSet::EMPTY,
            latched: FaultSet::EMPTY,
            registers: Registers::Unread,
            moving: None,
            following: None,
            dofs: filled(dofs, DofReport::default()),
            servos: filled(servos, ServoReport::NOTHING),
            overruns: 0,
        }
    }
}

/// Distance of the measured dofs from the commands of the tick before, rad; for prismatic joints, m.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Following {
    /// Mean of the absolute values.
    pub mean_rad: f32,
    /// Largest absolute value.
    pub most_rad: f32,
    /// Index of the dof with the largest value.
    pub dof: u16,
}

/// Report of a dof.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct DofReport {
    /// Commanded minus measured position, rad or m.
    pub error: f32,
    /// Effort that the tracker requested, N m or N.
    pub effort: f32,
    /// Effort of the dof's servos, computed from their currents, N m or N.
    pub measured_effort: Option<f32>,
    /// Reason for a limited effort.
    pub limit: Option<sinew_core::control::LimitReason>,
    /// Whether the dof swings, or did within the last 5 s.
    pub swings: bool,
    /// Factor of the dof's feedback effort: less than 1 while the dof swings, if a setting requires it.
    pub gain: f32,
}

/// Report of a dof that was never read.
impl Default for DofReport {
    fn default() -> Self {
        Self {
            error: 0.0,
            effort: 0.0,
            measured_effort: None,
            limit: None,
            swings: false,
            gain: 1.0,
        }
    }
}

/// Report of a servo.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ServoReport {
    /// Limit that its drive reached.
    pub limit: Option<Limit>,
    /// Reason for which the guard changed a command; a correct drive causes none.
    pub guard: Option<GuardReason>,
    /// Permitted part of its effort, 0 to 1.
    pub share: f32,
    /// Reason why the permitted part is reduced, or soon will be.
    pub concern: Option<Concern>,
    /// Temperature of the servo, degC.
    pub temperature_c: Option<f32>,
    /// Heat of its winding by the model, 1 at the limit.
    pub heat: f32,
    /// Filtered supply voltage of the servo, V.
    pub voltage_v: Option<f32>,
    /// Total number of missing replies.
    pub missed: u32,
    /// Total number of readings that were not believed.
    pub not_believed: u32,
    /// Last error number of a reply; 0 for none.
    pub last_error: u8,
}

impl ServoReport {
    /// Report of a servo that was never read.
    const NOTHING: Self = Self {
        limit: None,
        guard: None,
        share: 1.0,
        concern: None,
        temperature_c: None,
        heat: 0.0,
        voltage_v: None,
        missed: 0,
        not_believed: 0,
        last_error: 0,
    };
}

/// Returns `count` copies of a value; copies that do not fit are left out.
pub(super) fn filled<T: Clone, const K: usize>(count: usize, of: T) -> Vec<T, K> {
    let mut all = Vec::new();
    // There is room: the count is limited to the capacity.
    let _ = all.resize(count.min(K), of);
    all
}
