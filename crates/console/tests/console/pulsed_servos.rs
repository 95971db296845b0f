//! Observes hobby servos in each tick: pulses, positions, and the limits of their joints.

use sinew_rig::Mechanism;
use sinew_rig::description::{Description, Pulses};
use sinew_servo_sim::device::Servo;

/// Rows of positions per second.
pub(crate) const RATE_HZ: f64 = 5.0;
/// Time between two pulses, s; and change of a pulse by one step of a PCA9685, us.
const PERIOD_S: f64 = 0.02;
const COUNT_US: f64 = 1e6 * PERIOD_S / 4096.0;

/// A servo, with the limits of its joint. Each joint has its own servo, without a gear between them.
#[derive(Debug)]
struct Limited {
    name: String,
    pulses: Pulses,
    /// Range, rad; and maximum speed, rad/s.
    range: [f64; 2],
    speed: f64,
    /// Goal of the last tick, rad.
    goal: Option<f64>,
    /// Largest values so far: way beyond the range, rad; step of the goal from tick to tick, as a share of the largest
    /// step that the limit of speed permits; speed of the shaft as a share of the limit.
    beyond_rad: f64,
    step: f64,
    shaft: f64,
}

/// All servos of a rig.
#[derive(Debug)]
pub(crate) struct PulsedServos {
    servos: Vec<Limited>,
    dt_s: f64,
    ticks: u64,
    /// Positions of the shafts, rad, averaged over each interval of [`RATE_HZ`]; and their sums in the current one.
    rows: Vec<Vec<f64>>,
    sums: Vec<f64>,
}

impl PulsedServos {
    pub(crate) fn new(rig: &Description, mechanism: &Mechanism, rate_hz: u32) -> Self {
        let servo = |servo: &sinew_rig::description::Servo| {
            let link = mechanism.bodies.iter().find(|link| link.joint_name == servo.name).unwrap();
            Limited {
                name: servo.name.clone(),
                pulses: rig.pulses(servo).unwrap(),
                range: link.ranges[0],
                speed: link.speed,
                goal: None,
                beyond_rad: f64::NEG_INFINITY,
                step: 0.0,
                shaft: 0.0,
            }
        };
        let servos: Vec<Limited> = rig.servos.iter().map(servo).collect();
        let sums = vec![0.0; servos.len()];
        Self { servos, dt_s: f64::from(rate_hz).recip(), ticks: 0, rows: Vec::new(), sums }
    }

    /// Looks at all servos after a tick. `is_on`: whether torque is on.
    pub(crate) fn look(&mut self, is_on: bool, servos: &[Servo<'_>]) {
        for ((own, sum), servo) in self.servos.iter_mut().zip(&mut self.sums).zip(servos) {
            let shaft = servo.shaft();
            // A shaft counts from the beginning of its travel.
            *sum += shaft.position_rad;
            let goal = servo.pulse_us().filter(|_| is_on).map(|us| own.pulses.position_rad(us));
            own.note(goal, shaft.velocity_rad_s);
        }
        self.ticks += 1;
        let due = (self.rows.len() + 1) as f64 / RATE_HZ;
        if self.time_s() >= due - 1e-9 {
            self.rows.push(std::mem::replace(&mut self.sums, vec![0.0; self.servos.len()]));
        }
    }

    /// Returns the time since power-on, s.
    pub(crate) fn time_s(&self) -> f64 {
        self.ticks as f64 * self.dt_s
    }

    pub(crate) fn rows(&self) -> &[Vec<f64>] {
        &self.rows
    }

    pub(crate) fn print(&self) {
        for own in &self.servos {
            println!(
                "{}: {:.2} deg beyond its range; step {:.2} of the limit, shaft {:.2} of its limit",
                own.name,
                own.beyond_rad.to_degrees(),
                own.step,
                own.shaft
            );
        }
    }

    /// Checks that no goal was ever beyond a limit.
    #[track_caller]
    pub(crate) fn assert_limits(&self) {
        for own in &self.servos {
            let count_rad = COUNT_US / own.pulses.us_per_rad().abs();
            assert!(own.beyond_rad <= count_rad && own.step <= 1.0, "{own:?}");
        }
    }
}

impl Limited {
    fn note(&mut self, goal: Option<f64>, shaft_rad_s: f64) {
        let last = std::mem::replace(&mut self.goal, goal);
        let Some(goal) = goal else { return };
        self.beyond_rad = self.beyond_rad.max(self.range[0] - goal).max(goal - self.range[1]);
        self.shaft = self.shaft.max(shaft_rad_s.abs() / self.speed);
        let Some(last) = last else { return };
        // A pulse is renewed every 20 ms, and rounded to a count.
        let most = self.speed * PERIOD_S + COUNT_US / self.pulses.us_per_rad().abs();
        self.step = self.step.max((goal - last).abs() / most);
    }
}
