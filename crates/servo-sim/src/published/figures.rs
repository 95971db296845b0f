//! Published figures of servos, with their sources and tolerances.

/// A second-order servo: torque = stiffness times error, limited to the maximum, minus back-EMF, damping and friction.
/// Its numbers are those that others have identified, or those of a simulated servo.
#[derive(Debug, Clone, Copy)]
pub(super) struct Law {
    pub(super) stiffness_nm_rad: f64,
    pub(super) most_nm: f64,
    pub(super) back_emf_nm_s: f64,
    pub(super) damping_nm_s: f64,
    pub(super) friction_nm: f64,
    /// Friction per torque: of the motor's torque during a step, and of the sum of the motor's and the load's torque at
    /// rest.
    pub(super) load_friction: f64,
    pub(super) inertia_kg_m2: f64,
    /// Speed of the goal, rad/s.
    pub(super) goal_rad_s: f64,
}

impl Law {
    /// Neutral values for numbers that were not identified.
    const BARE: Self = Self {
        stiffness_nm_rad: 0.0,
        most_nm: 0.0,
        back_emf_nm_s: 0.0,
        damping_nm_s: 0.0,
        friction_nm: 0.0,
        load_friction: 0.0,
        inertia_kg_m2: 0.0,
        goal_rad_s: f64::INFINITY,
    };

    /// Returns the time to 63 % of a step, s, and the speed at that time, rad/s.
    pub(super) fn rise(&self, step_rad: f64) -> [f64; 2] {
        let (mut at, mut speed, mut time, dt) = (0.0_f64, 0.0_f64, 0.0, 1e-5);
        let drag = self.back_emf_nm_s + self.damping_nm_s;
        while at < RISE * step_rad && time < 5.0 {
            let goal = step_rad.min(self.goal_rad_s * time);
            let push = (self.stiffness_nm_rad * (goal - at)).clamp(-self.most_nm, self.most_nm);
            let motor = push - self.back_emf_nm_s * speed;
            let friction = self.friction_nm + self.load_friction * motor.abs();
            speed += dt * (push - friction) / self.inertia_kg_m2;
            speed = (speed / (1.0 + dt * drag / self.inertia_kg_m2)).max(0.0);
            at += dt * speed;
            time += dt;
        }
        [time, speed]
    }

    /// Returns the sag under a torque, rad: the mean of the two positions in which the servo comes to rest, from
    /// above and from below. At rest, the motor's torque m and the load's torque T differ by the friction f + l (m
    /// + T), with f = `friction_nm` and l = `load_friction`.
    pub(super) fn sag_rad(&self, torque_nm: f64) -> f64 {
        let load = self.load_friction;
        let motor_nm =
            (torque_nm * (1.0 + load * load) + self.friction_nm * load) / (1.0 - load * load);
        motor_nm / self.stiffness_nm_rad
    }
}

/// Part of a step at which the time is measured.
pub(super) const RISE: f64 = 0.63;

/// Stall torque, N m, stall current, A, and no-load speed, rad/s, at the voltage of the data sheet.
pub(super) const MAKERS: [(&str, [f64; 3]); 6] = [
    ("XL330-M288-T", [0.52, 1.47, 10.786]),
    ("XL430-W250-T", [1.4, 1.3, 5.969]),
    ("XM430-W350-T", [4.1, 2.3, 4.817]),
    ("MX-64", [6.0, 4.1, 6.597]),
    ("STS3215-7.4V", [1.91, 2.0, 5.22]),
    ("STS3215-12V", [2.94, 2.7, 4.817]),
];

/// Identified servos for the step response: kind, step in rad, law, and source with differences.
pub(super) const STEPS: [(&str, f64, Law, &str); 3] = [
    (
        "XL330-M288-T",
        0.5,
        // bam's k/R and k²/R at 5 V with P 400 / 256: a duty cycle of 1.151 for each rad.
        Law {
            stiffness_nm_rad: 1.151 * 5.0 * 0.3867 / 4.017,
            most_nm: 0.481,
            damping_nm_s: 0.3867 * 0.3867 / 4.017 + 0.00366,
            friction_nm: 0.01283,
            inertia_kg_m2: 0.001_914,
            ..Law::BARE
        },
        "Rhoban/bam, xl330 m1: its motor is weaker than the sheet's, by 0.48 to 0.62 N m before friction",
    ),
    (
        "STS3215-7.4V",
        0.1,
        Law {
            stiffness_nm_rad: 17.8,
            most_nm: 3.35,
            damping_nm_s: 0.60,
            friction_nm: 0.052,
            inertia_kg_m2: 0.0281,
            ..Law::BARE
        },
        "Open_Duck_Playground f82b5e7: its damping is 0.60 N m s, the sheet's motor has 0.43; its goal knows no cap of speed",
    ),
    (
        "XM430-W350-T",
        0.2,
        Law {
            stiffness_nm_rad: 21.1,
            most_nm: 5.0,
            damping_nm_s: 1.084,
            friction_nm: 0.03,
            inertia_kg_m2: 0.0013,
            ..Law::BARE
        },
        "MuJoCo Menagerie, OP3, with toddlerbot's inertia: the sheet's motor makes 23.4 of 21.1 N m/rad, more friction",
    ),
];

/// Sag figures: servo, torque in N m, published sag in degrees, whether it is compared, whether it was fitted, and
/// source with differences.
pub(super) type Sag = (&'static str, f64, f64, bool, bool, &'static str);
pub(super) const SAGS: [Sag; 4] = [
    (
        "STS3215-7.4V",
        0.3,
        1.005,
        true,
        true,
        "reachy_mini 70a7c0b: 17.11 N m/rad, 0.3 N m; stiffness here 17.8",
    ),
    (
        "XM430-W350-T",
        1.0,
        2.715,
        true,
        false,
        "MuJoCo Menagerie, OP3: 21.1 N m/rad, 1 N m; supply of the robot 11.1 to 12.6 V, 23.4 N m/rad here at 12 V",
    ),
    (
        "XL330-M288-T",
        0.1,
        10.42,
        true,
        false,
        "Rhoban/bam, xl330 m1: 0.55 N m/rad, 0.1 N m; 0.48 N m at stall, the sheet's motor 0.62",
    ),
    (
        "STS3215-12V",
        1.47,
        2.0,
        false,
        false,
        "SO-ARM100 issue 134: 2 deg with 1.5 kg at 10 cm, gains not told; does not fit 15.6 N m/rad",
    ),
];
