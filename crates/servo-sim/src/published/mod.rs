//! Compares published figures of servos with simulated ones, all measured over the bus.

mod figures;
mod page;

use sinew_servo_bus::dynamixel;
use sinew_servo_bus::dynamixel::table::address::{POSITION_P, RETURN_DELAY as DYNAMIXEL_DELAY};
use sinew_servo_bus::feetech;
use sinew_servo_bus::feetech::Family;
use sinew_servo_bus::feetech::table::address::RETURN_DELAY as FEETECH_DELAY;

use crate::bench::Bench;
use crate::device::codes::{duty_per_rad, whole};
use crate::device::{MEMORY_LEN, Servo, ServoError};
use crate::firmware::dynamixel::PWM_COUNTS;
use crate::load::Arm;
use crate::model::{Parameters, ParametersError};
use crate::supply::Supply;
use figures::{Law, MAKERS, RISE, SAGS, STEPS};
pub use page::page;

/// One row of the table.
#[derive(Debug, Clone, PartialEq)]
pub struct Row {
    /// Name of the servo.
    pub servo: &'static str,
    /// Compared quantity, with its unit.
    pub what: &'static str,
    /// Published value.
    pub published: f64,
    /// Value of the published servo's law, computed with the numbers of the simulated servo; they may differ from those
    /// of the source. `None` if the published value is for exactly this servo.
    pub expected: Option<f64>,
    /// Simulated value.
    pub simulated: f64,
    /// Tolerance of the simulated value around the expected value, or around the published value if there is none;
    /// `None` for a published value that is known not to fit, and is only shown.
    pub within: Option<f64>,
    /// Whether parameters were chosen to match this value. Only other values are evidence.
    pub is_fitted: bool,
    /// Source, and differences to the simulation.
    pub source: &'static str,
}

impl Row {
    /// Returns the relative error of the simulated value against the published value.
    pub fn error(&self) -> f64 {
        self.simulated / self.published - 1.0
    }

    /// Returns whether the value is within its tolerance, or has no tolerance.
    pub fn holds(&self) -> bool {
        let off = (self.simulated - self.expected.unwrap_or(self.published)).abs();
        self.within.is_none_or(|within| off <= within)
    }
}

/// The reason why the table could not be computed.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum TableError {
    /// A kind has no parameters.
    #[error(transparent)]
    Parameters(#[from] ParametersError),
    /// A kind has no registers.
    #[error(transparent)]
    Servo(#[from] ServoError),
}

/// Baud rate that all kinds support, bits per second.
const BAUD: u32 = 1_000_000;
/// Number of equal steps from no power to full power.
const RAMP: u16 = 40;

/// A single servo on a stiff supply, controlled by packets.
struct Trial<'m> {
    bench: Bench<'m, Vec<Arm>>,
    is_feetech: bool,
}

impl<'m> Trial<'m> {
    fn new(kind: &Parameters, arm: Arm, memory: &'m mut [u8]) -> Result<Self, ServoError> {
        let is_feetech = kind.name.starts_with("STS");
        let mut servo = Servo::new(kind, 1, memory)?;
        servo.set_baud(BAUD)?;
        // The servo answers without delay, so that commands act at once.
        servo.set(if is_feetech { FEETECH_DELAY.into() } else { DYNAMIXEL_DELAY }, 0);
        let bench = Bench::new(vec![servo], vec![arm], Supply::stiff(kind.voltage_v));
        Ok(Self { bench, is_feetech })
    }

    /// Returns the second-order law of a servo with these numbers, at its present temperature.
    fn law(&self, kind: &Parameters) -> Law {
        let servo = &self.bench.servos()[0];
        let ohm = kind.resistance_ohm * servo.heat().resistance_ratio();
        let constant = kind.torque_constant_nm_a;
        let most_nm = constant * kind.voltage_v / ohm;
        let duty_rad = if self.is_feetech {
            duty_per_rad(kind)
        } else {
            let p = f64::from(servo.get(POSITION_P));
            p / kind.position_p_divisor / PWM_COUNTS / kind.resolution_rad
        };
        Law {
            stiffness_nm_rad: duty_rad * most_nm,
            most_nm,
            back_emf_nm_s: constant * constant / ohm,
            damping_nm_s: kind.damping_nm_s,
            friction_nm: kind.friction_nm + kind.stribeck_nm,
            load_friction: kind.load_friction,
            inertia_kg_m2: kind.rotor_inertia_kg_m2 + self.bench.plant[0].inertia_kg_m2,
            goal_rad_s: kind.speed_cap_rad_s.unwrap_or(f64::INFINITY),
        }
    }

    fn write(&mut self, address: u16, data: &[u8]) {
        let mut out = [0; 64];
        let len = if self.is_feetech {
            let address = u8::try_from(address).unwrap_or(u8::MAX);
            let write = feetech::Instruction::Write { address, data };
            write.encode(Family::Sts, 1, &mut out)
        } else {
            dynamixel::Instruction::Write { address, data }.encode(1, &mut out)
        };
        let mut answered = false;
        self.bench.exchange(&out[..len.unwrap_or(0)], 10_000, |said| {
            answered |= !said.is_empty();
            answered
        });
    }

    /// Applies the full supply to the motor, gradually: a rotor at full speed that hits its gear would wind it up
    /// beyond the motor's torque, and friction would hold this windup.
    fn full_power(&mut self) {
        if self.is_feetech {
            // Several turns are allowed, and the goal is seven turns ahead.
            for address in [9, 11] {
                self.bench.servos_mut()[0].set(address, 0);
            }
            self.write(48, &[0, 0]);
            self.write(42, &30_719_u16.to_le_bytes());
        } else {
            self.write(11, &[16]);
            self.write(64, &[1]);
        }
        for step in 1..=RAMP {
            if self.is_feetech {
                self.write(48, &(1000 * step / RAMP).to_le_bytes());
            } else {
                self.write(100, &(885 * step / RAMP).to_le_bytes());
            }
            self.bench.run_us(10_000);
        }
    }

    /// Starts position control, with a step of `way_rad` from the present position.
    fn step_to(&mut self, kind: &Parameters, way_rad: f64) {
        let servo = &self.bench.servos()[0];
        let goal = whole((servo.shaft().position_rad + way_rad) / kind.resolution_rad);
        if self.is_feetech {
            self.write(42, &goal.to_le_bytes()[..2]);
        } else {
            self.write(64, &[1]);
            self.write(116, &goal.to_le_bytes());
        }
    }
}

/// Measures stall torque, N m, and stall current, A.
fn stall(kind: &Parameters) -> Result<[f64; 2], ServoError> {
    let mut memory = [0; MEMORY_LEN];
    // A load that is too heavy to move.
    let wall = Arm { inertia_kg_m2: 1e4, ..Arm::default() };
    let mut trial = Trial::new(kind, wall, &mut memory)?;
    trial.full_power();
    trial.bench.run_us(100_000);
    let servo = &trial.bench.servos()[0];
    Ok([servo.flow().shaft_nm, servo.current_a()])
}

/// Measures no-load speed, rad/s, and current, A.
fn free_run(kind: &Parameters) -> Result<[f64; 2], ServoError> {
    let mut memory = [0; MEMORY_LEN];
    let mut trial = Trial::new(kind, Arm::default(), &mut memory)?;
    trial.full_power();
    trial.bench.run_us(1_000_000);
    let mut sums = [0.0; 2];
    for _ in 0..1_000 {
        trial.bench.run_us(1_000);
        let servo = &trial.bench.servos()[0];
        sums[0] += servo.shaft().velocity_rad_s;
        sums[1] += servo.current_a();
    }
    Ok(sums.map(|sum| sum / 1e3))
}

/// Measures the time to 63 % of a step of the goal, s. Also returns the time by the law, and its tolerance.
///
/// The tolerance is two ticks of the servo's loop: one until it reads the goal, one for the age of a reading; plus the
/// time for half the play of its gear and one encoder step, at the present speed.
fn rise_s(kind: &Parameters, step_rad: f64) -> Result<[f64; 3], ServoError> {
    let mut memory = [0; MEMORY_LEN];
    let mut trial = Trial::new(kind, Arm::default(), &mut memory)?;
    trial.bench.run_us(10_000);
    let [law_s, speed_rad_s] = trial.law(kind).rise(step_rad);
    let start = trial.bench.servos()[0].shaft().position_rad;
    let begin_s = trial.bench.time_s();
    trial.step_to(kind, step_rad);
    while trial.bench.servos()[0].shaft().position_rad < start + RISE * step_rad {
        trial.bench.run_us(250);
        if trial.bench.time_s() > begin_s + 5.0 {
            break;
        }
    }
    let way_rad = 0.5 * kind.backlash_rad + kind.resolution_rad;
    let within_s = 2.0 / kind.loop_hz + way_rad / speed_rad_s;
    Ok([trial.bench.time_s() - begin_s, law_s, within_s])
}

/// Measures the distances from the goal at which the servo rests under a torque, rad: after it has sagged, and
/// after it was lifted.
///
/// # Errors
/// [`ServoError`] if the kind has no registers.
pub fn sag_rad(kind: &Parameters, torque_nm: f64) -> Result<[f64; 2], ServoError> {
    sag(kind, torque_nm).map(|(rests, _)| rests)
}

/// Measures both distances of [`sag_rad`], and computes their mean by the law.
fn sag(kind: &Parameters, torque_nm: f64) -> Result<([f64; 2], f64), ServoError> {
    let (mut rests, mut law_rad) = ([0.0; 2], 0.0);
    for (rest, before) in rests.iter_mut().zip([0.0, 2.0]) {
        let mut memory = [0; MEMORY_LEN];
        let mut trial = Trial::new(kind, Arm::default(), &mut memory)?;
        trial.bench.plant[0].inertia_kg_m2 = 1e-3;
        let start = trial.bench.servos()[0].shaft().position_rad;
        trial.step_to(kind, 0.0);
        trial.bench.plant[0].torque_nm = -before * torque_nm;
        trial.bench.run_us(1_000_000);
        trial.bench.plant[0].torque_nm = -torque_nm;
        trial.bench.run_us(1_000_000);
        *rest = start - trial.bench.servos()[0].shaft().position_rad;
        law_rad = trial.law(kind).sag_rad(torque_nm);
    }
    Ok((rests, law_rad))
}

/// Computes all rows of the table.
///
/// # Errors
/// [`TableError`] if a built-in file is invalid; a test reads them all.
pub fn table() -> Result<Vec<Row>, TableError> {
    let mut rows = Vec::new();
    for (name, figures) in MAKERS {
        let kind = Parameters::built_in(name)?;
        let [torque, amps] = stall(&kind)?;
        let [speed, _] = free_run(&kind)?;
        for ((what, simulated), published) in [
            ("stall torque, N m", torque),
            ("stall current, A", amps),
            ("no-load speed, rad/s", speed),
        ]
        .into_iter()
        .zip(figures)
        {
            rows.push(Row {
                servo: name,
                what,
                published,
                expected: None,
                simulated,
                within: Some(0.03 * published),
                is_fitted: true,
                source: "maker's sheet, see crates/rig/models",
            });
        }
    }
    for (servo, step_rad, identified, source) in STEPS {
        let kind = Parameters::built_in(servo)?;
        let [simulated, law, within] = rise_s(&kind, step_rad)?.map(|seconds| 1e3 * seconds);
        rows.push(Row {
            servo,
            what: "63 % of a small step, ms",
            published: 1e3 * identified.rise(step_rad)[0],
            expected: Some(law),
            simulated,
            within: Some(within),
            is_fitted: false,
            source,
        });
    }
    for (servo, torque_nm, published_deg, is_compared, is_fitted, source) in SAGS {
        let kind = Parameters::built_in(servo)?;
        let ([down, up], law_rad) = sag(&kind, torque_nm)?;
        rows.push(Row {
            servo,
            what: "sag, mean of both sides, deg",
            published: published_deg,
            expected: Some(law_rad.to_degrees()),
            simulated: (0.5 * (down + up)).to_degrees(),
            // Tolerance: half a step of the goal plus half an encoder step.
            within: is_compared.then(|| kind.resolution_rad.to_degrees()),
            is_fitted,
            source,
        });
    }
    let kind = Parameters::built_in("STS3215-12V")?;
    rows.push(Row {
        servo: "STS3215-12V",
        what: "no-load current, A",
        published: 0.18,
        expected: None,
        simulated: free_run(&kind)?[1],
        within: None,
        is_fitted: false,
        source: "SO-ARM100 issue 132; its friction here is a guess, as the 7.4 V type's",
    });
    Ok(rows)
}
