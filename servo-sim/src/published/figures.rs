//! What is published, by whom, and how near a simulation should come.

/// A second-order servo as others have identified it: torque = stiffness times error, cut at the most, less damping and
/// friction.
#[derive(Debug, Clone, Copy)]
pub(super) struct Identified {
    stiffness_nm_rad: f64,
    most_nm: f64,
    damping_nm_s: f64,
    friction_nm: f64,
    inertia_kg_m2: f64,
}

impl Identified {
    /// Time to 63 % of a step, s.
    pub(super) fn rise_s(&self, step_rad: f64) -> f64 {
        let (mut at, mut speed, mut time, dt) = (0.0_f64, 0.0_f64, 0.0, 1e-5);
        while at < RISE * step_rad && time < 5.0 {
            let push = (self.stiffness_nm_rad * (step_rad - at)).clamp(-self.most_nm, self.most_nm);
            speed += dt * (push - self.friction_nm) / self.inertia_kg_m2;
            speed = (speed / (1.0 + dt * self.damping_nm_s / self.inertia_kg_m2)).max(0.0);
            at += dt * speed;
            time += dt;
        }
        time
    }
}

/// Part of a step at which its time is taken.
pub(super) const RISE: f64 = 0.63;

/// Stall torque, stall current and no-load speed, at the voltage of the sheet.
pub(super) const MAKERS: [(&str, [f64; 3]); 6] = [
    ("XL330-M288-T", [0.52, 1.47, 10.786]),
    ("XL430-W250-T", [1.4, 1.3, 5.969]),
    ("XM430-W350-T", [4.1, 2.3, 4.817]),
    ("MX-64", [6.0, 4.1, 6.597]),
    ("STS3215-7.4V", [1.91, 2.0, 5.22]),
    ("STS3215-12V", [2.94, 2.7, 4.817]),
];

/// Identified servos for the step response: step, model, tolerance, source and the tolerance's reason.
pub(super) const STEPS: [(&str, f64, Identified, f64, &str); 3] = [
    (
        "XL330-M288-T",
        0.5,
        // bam's k/R and k²/R at 5 V with P 400 / 256: 1.151 of the supply for each rad.
        Identified {
            stiffness_nm_rad: 1.151 * 5.0 * 0.3867 / 4.017,
            most_nm: 0.481,
            damping_nm_s: 0.3867 * 0.3867 / 4.017 + 0.00366,
            friction_nm: 0.01283,
            inertia_kg_m2: 0.001_914,
        },
        0.35,
        "Rhoban/bam, xl330 m1; 35 %: its motor is weaker than the sheet's by 0.48 to 0.62 N m before friction",
    ),
    (
        "STS3215-7.4V",
        0.1,
        Identified {
            stiffness_nm_rad: 17.8,
            most_nm: 3.35,
            damping_nm_s: 0.60,
            friction_nm: 0.052,
            inertia_kg_m2: 0.0281,
        },
        0.35,
        "Open_Duck_Playground f82b5e7; 35 %: its damping is 0.60 N m s, that of the sheet's motor k²/R + b = 0.45",
    ),
    (
        "XM430-W350-T",
        0.1,
        Identified {
            stiffness_nm_rad: 21.1,
            most_nm: 5.0,
            damping_nm_s: 1.084,
            friction_nm: 0.03,
            inertia_kg_m2: 0.0013,
        },
        0.2,
        "MuJoCo Menagerie, OP3, with toddlerbot's inertia; 20 %: the sheet's motor makes 23.7 of 21.1 N m/rad",
    ),
];

/// Servo, torque, published sag in degrees, tolerance, whether fitted, source.
pub(super) type Sag = (&'static str, f64, f64, Option<f64>, bool, &'static str);
pub(super) const SAGS: [Sag; 4] = [
    (
        "STS3215-7.4V",
        0.3,
        1.005,
        Some(0.2),
        true,
        "reachy_mini 70a7c0b: 17.11 N m/rad, 0.3 N m; 20 %: an encoder step is 0.09 deg, stiffness here 17.8",
    ),
    (
        "XM430-W350-T",
        1.0,
        2.715,
        Some(0.2),
        false,
        "MuJoCo Menagerie, OP3: 21.1 N m/rad, 1 N m; 20 %: supply of the robot 11.1 to 12.6 V, an encoder step",
    ),
    (
        "XL330-M288-T",
        0.1,
        10.42,
        Some(0.3),
        false,
        "Rhoban/bam, xl330 m1: 0.55 N m/rad, 0.1 N m; 30 %: 0.48 N m at stall, the sheet's motor 0.62",
    ),
    (
        "STS3215-12V",
        1.47,
        2.0,
        None,
        false,
        "SO-ARM100 issue 134: 2 deg with 1.5 kg at 10 cm, gains not told; does not fit 15.6 N m/rad",
    ),
];
