//! The input and the findings of a review.

use serde::Serialize;

use super::flexible_joint::Stability;

/// The control loop that gains are judged for.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Loop {
    /// Ticks a second.
    pub rate_hz: f64,
    /// Ticks that a torque acts late.
    pub latency_ticks: usize,
    /// Bandwidth of the observer, rad/s; none: by the rule.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub bandwidth_rad_s: Option<f64>,
}

/// The effort and speed that the servos of one dof can give there, through their drive.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Capability {
    /// Names of the servos.
    pub servos: Vec<String>,
    /// Effort for long, N m or N.
    pub continuous: f64,
    /// Effort at standstill, N m or N.
    pub stall: f64,
    /// Speed without load, rad/s or m/s.
    pub no_load_speed: f64,
    /// Least step, rad or m.
    pub resolution: f64,
    /// Current of all of them for an effort, A per N m or A per N.
    pub current_per_effort: f64,
    /// Whether a value is a guess of the servo's data.
    pub guessed: bool,
    /// The gear that the loop of the tracker is closed through; none where a servo has a loop of its own.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub gear: Option<SoftGear>,
}

/// The rotors of a dof's servos and their gears, as the dof sees them at home: rad, or m of one that slides.
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
    /// Damping by the windings where servos are driven by voltage, N m s or N s/m.
    pub winding_damping: f64,
    /// Play from end to end, rad or m.
    pub play: f64,
}

/// One dof of one joint.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct DofReview {
    /// Name of the dof, see [`Mechanism::dof_names`](crate::Mechanism::dof_names).
    pub name: String,
    /// Whether it slides: forces in N and ways in m, else torques in N m and angles in rad.
    pub slides: bool,
    /// What gravity asks for in the worst pose found, N m or N.
    pub gravity_effort: f64,
    /// That pose: joint coordinates by the rig's order.
    pub gravity_pose: Vec<f64>,
    /// The file's own limit, N m or N.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub effort_limit: Option<f64>,
    /// What its servos can do, if it has any.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub servo: Option<Capability>,
    /// The file's own limit of speed, rad/s or m/s.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub speed_limit: Option<f64>,
    /// Inertia against the drive in the home pose with all joints beyond held: kg m² or kg, the rotor's included.
    pub inertia: f64,
    /// The same with all joints beyond free to give way: what a torque meets first.
    pub inertia_free: f64,
    /// The rotor's part.
    pub rotor_inertia: f64,
    /// How the loop stands that is closed through its gear, if there is one.
    #[serde(rename = "loop", skip_serializing_if = "Option::is_none")]
    pub control: Option<LoopReview>,
    /// The largest stable stiffness of a critically damped loop, N m/rad or N/m.
    pub stable_stiffness: f64,
    /// The farthest that a point beyond the joint can be from it, m; an upper bound.
    pub reach_m: f64,
    /// What the servo's least step is at that distance, mm.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub resolution_mm: Option<f64>,
}

/// The loop of the tracker round one dof, through its gear.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct LoopReview {
    /// Resonance of the rotor on the gear with the output held, Hz.
    pub resonance_hz: f64,
    /// Least and greatest inertia at the output in the poses that were tried, kg m² or kg; all joints beyond held.
    pub load_inertia: [f64; 2],
    /// Bandwidth of the observer, rad/s.
    pub bandwidth_rad_s: f64,
    /// With either load, the lesser of both.
    pub nominal: Stability,
    /// The same of a gear that is half as stiff, and has twice the play.
    pub worst: Stability,
    /// The largest bandwidth at which all of that is stable, rad/s, 0 if it is at no bandwidth; none if that of the
    /// observer is less.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub bearable_rad_s: Option<f64>,
    /// Whether the lightest load alone is stable, with either gear: then less load helps.
    pub light_bears: bool,
    /// Whether all of it is stable by voltage, where the winding damps.
    pub voltage_bears: bool,
}

/// Current of all servos together.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct CurrentReview {
    /// Where every joint holds its own worst pose, A: more than any one pose takes.
    pub holding_a: f64,
    /// Where all servos stall, A.
    pub stall_a: f64,
    /// What the supply gives, A.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub supply_a: Option<f64>,
}

/// All of it.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Review {
    /// Mass of the whole rig, kg.
    pub mass_kg: f64,
    /// Number of bodies, fixed joints merged; the base is one.
    pub bodies: usize,
    /// Number of degrees of freedom.
    #[serde(rename = "freedoms")]
    pub dofs: usize,
    /// The loop that stiffness is judged for.
    pub control: Loop,
    /// Largest stable gain of a critically damped loop, 1/s²: stiffness over inertia.
    pub stable_kp_per_s2: f64,
    /// By dof, in the order of efforts.
    #[serde(rename = "by_freedom")]
    pub by_dof: Vec<DofReview>,
    /// If servos are known.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub current: Option<CurrentReview>,
    /// What feeds each kind of servo; empty if the supply is not known.
    pub voltages: Vec<Voltage>,
    /// What is wrong or doubtful, the worst first.
    pub findings: Vec<Finding>,
}

/// What feeds the servos of one kind.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Voltage {
    /// Names of the servos.
    pub servos: Vec<String>,
    /// Their kind.
    pub model: String,
    /// What the supply gives, V.
    pub supply_v: f64,
    /// What the kind's values are for, V.
    pub model_v: f64,
}

/// What is known of the servos.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Servos {
    /// By dof; `None` where no servo moves it.
    pub by_dof: Vec<Option<Capability>>,
    /// Where all stall, A.
    pub stall_current_a: f64,
    /// What the supply gives, A.
    pub supply_a: Option<f64>,
    /// What feeds each kind; empty if the supply is not known.
    pub voltages: Vec<Voltage>,
}

/// How bad it is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Severity {
    /// The rig cannot do what it is for.
    Fault,
    /// It may not.
    Warning,
    /// Worth knowing.
    Note,
}

/// One thing that was found.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Finding {
    /// How bad it is.
    pub severity: Severity,
    /// Its subject: `joint elbow`.
    pub about: String,
    /// The finding, and what would help.
    pub text: String,
}
