//! What became of a tick.

use heapless::Vec;
use sinew_show::Position;

use crate::drives::Limit;
use crate::supervisor::detect::Concern;
use crate::supervisor::{Answer, FaultSet, GuardReason, Moving, Registers, Source, State};

/// The report of a tick: of `DOFS` dofs and `SERVOS` servos at most.
#[derive(Debug, Clone)]
pub struct Report<const DOFS: usize, const SERVOS: usize> {
    /// The state.
    pub state: State,
    /// Where the pose comes from.
    pub source: Source,
    /// Where the show is that is loaded.
    pub show: Option<Position>,
    /// What became of the command.
    pub answer: Option<Answer>,
    /// Faults whose condition is there.
    pub present: FaultSet,
    /// Faults, and warnings, that came in this tick.
    pub raised: FaultSet,
    /// Faults that wait to be cleared.
    pub latched: FaultSet,
    /// What servos hold in their registers; while torque is on nothing is known of it.
    pub registers: Registers,
    /// While torque is off, the joint that moves too fast for the rig to be armed.
    pub moving: Option<Moving>,
    /// How far the rig is from where it should be; none while torque is off.
    pub following: Option<Following>,
    /// By dof.
    pub dofs: Vec<DofReport, DOFS>,
    /// By servo.
    pub servos: Vec<ServoReport, SERVOS>,
    /// Ticks that took too long, since the start.
    pub overruns: u32,
}

impl<const DOFS: usize, const SERVOS: usize> Report<DOFS, SERVOS> {
    /// Before the first tick.
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

/// How far measured dofs are from what was commanded in the tick before, rad; of slides, m.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Following {
    /// Mean of the sizes.
    pub mean_rad: f32,
    /// The largest.
    pub most_rad: f32,
    /// The dof that has it.
    pub dof: u16,
}

/// One dof.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct DofReport {
    /// Commanded less measured; rad or m.
    pub error: f32,
    /// What the tracker asked for, N m or N.
    pub effort: f32,
    /// What its servos give by their currents, N m or N.
    pub measured_effort: Option<f32>,
    /// What limited the effort.
    pub limit: Option<sinew_core::control::LimitReason>,
    /// Whether it swings, or did within the last 5 s.
    pub swings: bool,
    /// What part of its feedback it gets: less than 1 while it swings, if a setting says so.
    pub gain: f32,
}

/// Of a dof that was never read.
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

/// One servo.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ServoReport {
    /// What limited its drive.
    pub limit: Option<Limit>,
    /// What the guard held, which drives should have.
    pub guard: Option<GuardReason>,
    /// What part of its effort it may give, 0 to 1.
    pub share: f32,
    /// Why that is less, or soon will be.
    pub concern: Option<Concern>,
    /// Temperature, degC.
    pub temperature_c: Option<f32>,
    /// Heat of its winding by the model, 1 at the limit.
    pub heat: f32,
    /// Its supply, filtered, V.
    pub voltage_v: Option<f32>,
    /// Replies that did not come, over all.
    pub missed: u32,
    /// Readings that were not believed, over all.
    pub not_believed: u32,
    /// The last error number of a reply; 0 for none.
    pub last_error: u8,
}

impl ServoReport {
    /// Of a servo that was never read.
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

/// So many of one thing; what does not fit is left out.
pub(super) fn filled<T: Clone, const K: usize>(count: usize, of: T) -> Vec<T, K> {
    let mut all = Vec::new();
    // Held to the capacity: there is room.
    let _ = all.resize(count.min(K), of);
    all
}
