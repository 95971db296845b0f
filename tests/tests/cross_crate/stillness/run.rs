//! A rig that plays a motion on simulated servos, with a record of every tick.

use sinew_performance::play::{Director, Drive, Ended, Memory, Options, RigParts, SimulatedRig};
use sinew_performance::{Baker, ShowMarks};
use sinew_retarget::feasibility::RigMotion;
use sinew_rig::description::ServoModel;
use sinew_rig::{Description, Mechanism};
use sinew_servo_sim::device::MEMORY_LEN;
use sinew_servo_sim::plant::RigPlant;
use sinew_servo_sim::variation::Variation;
use sinew_show::write::Settings;

/// The old starter arm, which oscillated.
const OLD_ARM: &str = include_str!("../../../support/rigs/arm_62ff7e0.toml");
/// Longest time of a run besides its motion, s: arming (1 s), the way to the first pose, the way to rest (10 s at most)
/// and lowering (18 s at most).
const BESIDE_S: u32 = 60;

/// A rig that is driven by current wherever possible.
pub(crate) struct Rig {
    pub(crate) description: Description,
    pub(crate) mechanism: Mechanism,
    pub(super) drive: Option<Drive>,
}

/// Tolerance of shows, rad.
const SHOW_RAD: f64 = 2e-4;

/// State of one dof in a tick, in rad and A.
#[derive(Debug, Clone, Copy)]
pub(super) struct Sample {
    pub(super) commanded: f64,
    pub(super) measured: f64,
    /// Error that the controller reports, rad: the command of the tick before minus the measured position.
    pub(super) error_rad: f64,
    pub(super) current_a: f64,
    pub(super) is_limited: bool,
}

/// All ticks in which the show ran.
pub(super) struct Run {
    pub(super) rate_hz: f64,
    pub(super) names: Vec<String>,
    /// Half the play plus a step of the encoder of each dof's servos, rad.
    pub(super) blind_rad: Vec<f64>,
    /// Samples by dof, then by tick.
    pub(super) samples: Vec<Vec<Sample>>,
}

impl Rig {
    pub(super) fn new(description: Description) -> Self {
        let mechanism = description.mechanism().unwrap();
        Self { description, mechanism, drive: None }
    }

    /// Returns the starter arm.
    pub(super) fn new_arm() -> Self {
        Self::new(sinew_rig::new::arm(6).unwrap())
    }

    pub(super) fn old_arm() -> Self {
        Self::new(sinew_rig::toml_file::read(OLD_ARM).unwrap())
    }

    /// Returns the model of a servo.
    pub(super) fn model(&self, servo: usize) -> ServoModel {
        self.description.servo_model(&self.description.servos[servo].model).unwrap()
    }

    /// Plays a motion, and records it. `on_tick` receives the rig before each tick of the show.
    pub(super) fn play(
        &self,
        motion: &RigMotion,
        variation: Variation,
        on_tick: impl FnMut(&mut SimulatedRig<'_, RigPlant>, f64),
    ) -> Run {
        self.perform(self.show_of(motion), variation, on_tick)
    }

    /// Returns a function that makes a show of a motion for the rig with a CRC.
    pub(super) fn show_of<'r>(
        &'r self,
        motion: &'r RigMotion,
    ) -> impl FnOnce(u32) -> Vec<u8> + use<'r> {
        // A show may differ from its motion by its tolerance, so a constant pose moves slowly within it.
        let settings = Settings { angle_rad: SHOW_RAD, ..Settings::default() };
        move |rig_crc| {
            let baker = Baker { mechanism: &self.mechanism, rig: rig_crc, settings };
            baker.bake(motion, &ShowMarks::default()).unwrap().written.bytes
        }
    }

    /// Plays a show, and records it. `show` makes the show for the rig's CRC.
    pub(super) fn perform(
        &self,
        show: impl FnOnce(u32) -> Vec<u8>,
        variation: Variation,
        mut on_tick: impl FnMut(&mut SimulatedRig<'_, RigPlant>, f64),
    ) -> Run {
        let Self { description, mechanism, drive } = self;
        let options = Options { drive: *drive, ..Options::default() };
        let mut parts = RigParts::new(description, mechanism, options).unwrap();
        parts.vary(variation);
        let show = show(parts.rig_crc());
        let most_s = sinew_show::Show::open(&show).unwrap().duration_s().ceil();
        let mut memories: Vec<Memory> = vec![[0; MEMORY_LEN]; parts.servos.len()];
        let plant = parts.plant(description, mechanism).unwrap();
        let mut sim = SimulatedRig::new(&parts, Some(&show), &mut memories, plant).unwrap();
        let mut director = Director::default();
        let rate_hz = f64::from(parts.rate_hz);
        let mut samples = vec![Vec::new(); parts.names.len()];
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "seconds")]
        let most = (most_s as u32 + BESIDE_S) * parts.rate_hz;
        let ended = (0..most).find_map(|_| {
            if sim.runs() {
                let ticks = samples.first().map_or(0, Vec::len);
                on_tick(&mut sim, ticks as f64 / rate_hz);
            }
            let ended = director.tick(&mut sim, false);
            if sim.runs() {
                for (dof, samples) in samples.iter_mut().enumerate() {
                    samples.push(sample(&sim, dof));
                }
            }
            ended
        });
        assert_eq!(ended, Some(Ended::Done), "{:?}", director.raised());
        let blind_rad = parts.first_servo.iter().map(|servo| {
            let model = servo.map(|servo| self.model(servo)).unwrap_or_default();
            model.half_play_rad() + model.resolution_rad.value
        });
        Run { rate_hz, names: parts.names.clone(), blind_rad: blind_rad.collect(), samples }
    }
}

fn sample(sim: &SimulatedRig<'_, RigPlant>, dof: usize) -> Sample {
    let [commanded, measured] = sim.dofs().map(|q| f64::from(q[dof]));
    let current_a = sim.parts.first_servo[dof].and_then(|servo| sim.current_a(servo));
    Sample {
        commanded,
        measured,
        error_rad: f64::from(sim.report().dofs[dof].error),
        current_a: current_a.map_or(0.0, f64::from),
        is_limited: sim.limiter(dof).is_some(),
    }
}
