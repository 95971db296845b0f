//! Input and results of a review.

use serde::Serialize;

use super::flexible_joint::Stability;

/// The control loop for which gains are judged.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Loop {
    /// Control rate, Hz.
    pub rate_hz: f64,
    /// Delay until a torque acts, in ticks.
    pub latency_ticks: usize,
    /// Bandwidth of the observer, rad/s; `None` for the bandwidth of the rule.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub bandwidth_rad_s: Option<f64>,
}

/// Effort and speed that the servos of one dof give through their drive.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Capability {
    /// Names of the servos.
    pub servos: Vec<String>,
    /// Maximum continuous effort, N m or N.
    pub continuous: f64,
    /// Effort at standstill, N m or N.
    pub stall: f64,
    /// Speed without load, rad/s or m/s.
    pub no_load_speed: f64,
    /// Smallest step, rad or m.
    pub resolution: f64,
    /// Current of all these servos per effort, A per N m or A per N.
    pub current_per_effort: f64,
    /// Whether a value in the servo's data is a guess.
    pub guessed: bool,
    /// Part of the joint's range that the servos' own ranges permit, rad or m. `None` if they permit all of it, or if
    /// the drive has several dofs.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reached: Option<[f64; 2]>,
    /// Gear inside the tracker's loop; `None` if a servo has a loop of its own.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub gear: Option<SoftGear>,
}

/// Rotors and gears of a dof's servos, referred to the dof in the home pose: rad, or m for a slide.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct SoftGear {
    /// Inertia of the rotors, kg m² or kg.
    pub rotor_inertia: f64,
    /// Stiffness, N m/rad or N/m.
    pub stiffness: f64,
    /// Damping between rotor and output, N m s or N s/m.
    pub gear_damping: f64,
    /// Viscous friction of the rotors, N m s or N s/m.
    pub damping: f64,
    /// Damping by the windings of servos that are driven by voltage, N m s or N s/m.
    pub winding_damping: f64,
    /// Play from end to end, rad or m.
    pub play: f64,
}

/// Review of one dof of a joint.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct DofReview {
    /// Name of the dof, see [`Mechanism::dof_names`](crate::Mechanism::dof_names).
    pub name: String,
    /// Whether the dof slides: efforts are then in N and positions in m, otherwise in N m and rad.
    pub slides: bool,
    /// Effort that gravity demands in the worst pose found, N m or N.
    pub gravity_effort: f64,
    /// Joint coordinates of the worst pose, in the rig's order.
    pub gravity_pose: Vec<f64>,
    /// Effort limit in the file, N m or N.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub effort_limit: Option<f64>,
    /// Capability of its servos, if it has any.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub servo: Option<Capability>,
    /// Speed limit in the file, rad/s or m/s.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub speed_limit: Option<f64>,
    /// Inertia of the dof in the home pose with all joints beyond it held, including the rotor, kg m² or kg.
    pub inertia: f64,
    /// Inertia of the dof with all joints beyond it free, which a sudden torque acts on first, kg m² or kg.
    pub inertia_free: f64,
    /// Part of the inertia that the rotor adds, kg m² or kg.
    pub rotor_inertia: f64,
    /// Review of the loop through its gear, if there is one.
    #[serde(rename = "loop", skip_serializing_if = "Option::is_none")]
    pub control: Option<LoopReview>,
    /// Maximum stable stiffness of a critically damped loop, N m/rad or N/m.
    pub stable_stiffness: f64,
    /// Upper bound of the distance from this joint to any joint or centre of mass that it moves, m.
    pub reach_m: f64,
    /// Motion by one servo step at the distance `reach_m`, mm.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub resolution_mm: Option<f64>,
}

/// Review of the tracker's loop on one dof, through its gear.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct LoopReview {
    /// Resonance of the rotor on the gear with the output held, Hz.
    pub resonance_hz: f64,
    /// Minimum and maximum inertia at the output in the evaluated poses, with all joints beyond held, kg m² or kg.
    pub load_inertia: [f64; 2],
    /// Bandwidth of the observer, rad/s.
    pub bandwidth_rad_s: f64,
    /// Stability for minimum and maximum load, the worse of both.
    pub nominal: Stability,
    /// Stability with a gear of half the stiffness and twice the play, the worse for both loads.
    pub worst: Stability,
    /// Largest observer bandwidth at which the loop is stable with both loads and both gears, rad/s; 0 if there is
    /// none. `None` if the loop is stable with the observer's own bandwidth.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub bearable_rad_s: Option<f64>,
    /// Whether the loop with the minimum load is stable both with the nominal gear and with the worst gear. If so,
    /// a smaller load helps.
    pub light_bears: bool,
    /// Whether the loop is stable with both loads and both gears in voltage mode, in which the winding damps
    /// oscillations.
    pub voltage_bears: bool,
}

/// Current of all servos together.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct CurrentReview {
    /// Current if every joint holds its own worst pose, A: an upper bound for any single pose.
    pub holding_a: f64,
    /// Current if all servos stall, A.
    pub stall_a: f64,
    /// Maximum current of the supply, A.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub supply_a: Option<f64>,
}

/// Result of a review.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Review {
    /// Mass of the whole rig, kg.
    pub mass_kg: f64,
    /// Number of bodies including the base, with fixed joints merged.
    pub bodies: usize,
    /// Number of dofs.
    #[serde(rename = "freedoms")]
    pub dofs: usize,
    /// Control loop for which gains are judged.
    pub control: Loop,
    /// Largest stable gain of a critically damped loop, 1/s²: stiffness per inertia.
    pub stable_kp_per_s2: f64,
    /// Review of each dof, in the order of efforts.
    #[serde(rename = "by_freedom")]
    pub by_dof: Vec<DofReview>,
    /// Currents, if the servos are known.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub current: Option<CurrentReview>,
    /// Comparison of the supply voltage with the data of each kind of servo; empty if the supply is unknown.
    pub voltages: Vec<Voltage>,
    /// Wrong or doubtful values, the worst first.
    pub findings: Vec<Finding>,
}

/// Supply voltage of the servos of one kind, beside the voltage at which the kind's values are valid.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Voltage {
    /// Names of the servos.
    pub servos: Vec<String>,
    /// Kind of these servos.
    pub model: String,
    /// Voltage of the supply, V.
    pub supply_v: f64,
    /// Voltage at which the kind's values are valid, V.
    pub model_v: f64,
}

/// Servo data that a review needs.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Servos {
    /// Capability for each dof; `None` for a dof without servos.
    pub by_dof: Vec<Option<Capability>>,
    /// Current if all servos stall, A.
    pub stall_current_a: f64,
    /// Maximum current of the supply, A.
    pub supply_a: Option<f64>,
    /// Comparison of the supply voltage with the data of each kind of servo; empty if the supply is unknown.
    pub voltages: Vec<Voltage>,
}

/// Severity of a finding.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Severity {
    /// The rig cannot do its task.
    Fault,
    /// The rig may be unable to do its task.
    Warning,
    /// The finding is worth knowing.
    Note,
}

/// A result of the review that needs attention.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Finding {
    /// Severity of the finding.
    pub severity: Severity,
    /// Part that the finding is about, for example `joint elbow`.
    pub about: String,
    /// Description of the finding, and of what would help.
    pub text: String,
}
