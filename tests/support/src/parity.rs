//! Runs of the built-in evaluation as [`sinew_bit_parity::run`] repeats them on any machine, their answers, and the
//! first difference of two answers.

use std::fmt;
use std::fs::File;
use std::io::Write as _;
use std::path::PathBuf;
use std::process::Command;

use sinew_bit_parity::run::{NUMBERS, QUANTITIES, TICK_BYTES, pose_bytes, tick_bytes};
use sinew_bit_parity::{PLAY, RUN, answer};
use sinew_evaluation::{CAPACITY, MethodName, Protocol};
use sinew_figure::{BODIES, BODY_COUNT, FigureMotion};

use crate::figure::{COORDINATES, DOFS, FigureShow, rig};

/// A run of the evaluation: a figure of one size tracks one clip with one method.
#[derive(Debug, Clone)]
pub struct Run {
    /// Name of the clip.
    pub clip: String,
    /// Factor on the figure's dimensions.
    pub scale: f64,
    /// Method of the tracker.
    pub method: MethodName,
    /// Request of the run, in the format of [`sinew_bit_parity`].
    bytes: Vec<u8>,
    /// Numbers of the evaluation's own tracker, in the format of a machine's answer.
    evaluation: Vec<u8>,
    ticks: usize,
}

impl Run {
    /// Runs the evaluation and records it: the rig, the joints' poses in the clip and those that the tracker
    /// received, and every number that the tracker computed in each tick.
    pub fn record(motion: &FigureMotion, scale: f64, method: MethodName) -> Self {
        let index = MethodName::ALL.iter().position(|one| *one == method);
        let setup = Protocol::default().setup_of(scale, method);
        let model = setup.model(motion).unwrap();
        let (mut measured, mut evaluation) = (Vec::new(), Vec::new());
        let run = sinew_evaluation::Run::new(motion, &setup, None, 0).unwrap();
        let ticks = run
            .track(|step| {
                if measured.is_empty() {
                    measured.extend_from_slice(step.readings[0]);
                }
                measured.extend_from_slice(step.readings[1]);
                let mut answer = [[0; TICK_BYTES]; CAPACITY];
                let tracker = step.tracker.expect("a run alone has its own tracker");
                evaluation.extend_from_slice(tick_bytes(tracker, &mut answer));
            })
            .unwrap();

        let (rig, frames) = (rig(&model.mechanism(setup.root)), motion.rotation.len());
        let mut bytes = Vec::new();
        bytes.extend(RUN.to_le_bytes());
        for count in [index.expect("a method to compare"), ticks, frames, rig.len()] {
            bytes.extend(u32::try_from(count).unwrap().to_le_bytes());
        }
        #[expect(clippy::cast_possible_truncation, reason = "the core computes in f32")]
        bytes.extend((motion.dt_s as f32).to_le_bytes());
        bytes.extend(rig);
        for frame in 0..frames {
            bytes.extend(motion.joint_poses(frame).iter().flat_map(pose_bytes));
        }
        bytes.extend(measured.iter().flat_map(pose_bytes));
        Self { clip: motion.name.clone(), scale, method, bytes, evaluation, ticks }
    }

    /// Returns the numbers of the evaluation itself, in the format of a machine's answer.
    pub fn evaluation(&self) -> &[u8] {
        &self.evaluation
    }

    /// Returns the number of ticks.
    pub fn ticks(&self) -> usize {
        self.ticks
    }

    /// Repeats the recorded run in this program, and returns the bytes of the answer.
    pub fn here(&self) -> Vec<u8> {
        here(&self.bytes)
    }

    /// Repeats the recorded run on a machine, and returns the bytes of its answer.
    pub fn on(&self, machine: &Machine) -> Vec<u8> {
        machine.answer(&self.bytes).unwrap_or_else(|problem| panic!("{machine}, {self}: {problem}"))
    }
}

/// Returns the request to play the first ticks of a show.
///
/// # Panics
/// If the show is too long for a request.
pub fn to_play(FigureShow { rig, show }: &FigureShow, ticks: u32) -> Vec<u8> {
    let length = |bytes: &[u8]| u32::try_from(bytes.len()).unwrap();
    let numbers = [PLAY, ticks, length(rig), length(show)].map(u32::to_le_bytes);
    [&numbers.concat(), rig, show].map(|part| &part[..]).concat()
}

/// Returns this program's answer to a request.
///
/// # Panics
/// If the request is invalid.
pub fn here(mut request: &[u8]) -> Vec<u8> {
    let (mut out, mut buffer) = (Vec::new(), vec![0; request.len()]);
    let read = |bytes: &mut [u8]| {
        let taken = request.split_off(..bytes.len()).ok_or("the request ends too early")?;
        bytes.copy_from_slice(taken);
        Ok(())
    };
    let write = |bytes: &[u8]| {
        out.extend_from_slice(bytes);
        Ok(())
    };
    answer::<BODY_COUNT, DOFS, COORDINATES>(&mut buffer, read, write).unwrap();
    out
}

impl fmt::Display for Run {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}, scale {:.1}, {}", self.clip, self.scale, self.method)
    }
}

/// A machine that runs the program of [`sinew_bit_parity`].
#[derive(Debug, Clone)]
pub struct Machine {
    /// Name of the machine.
    pub name: &'static str,
    /// Path of the program.
    pub program: PathBuf,
    /// Whether the program is an image for QEMU's `mps2-an386`.
    pub emulated: bool,
}

impl Machine {
    /// Returns the program's answer to a request of [`sinew_bit_parity::answer`].
    ///
    /// # Errors
    /// The program's message, or the reason why it cannot run.
    pub fn answer(&self, request: &[u8]) -> Result<Vec<u8>, String> {
        let mut file = tempfile::NamedTempFile::new().unwrap();
        file.write_all(request).unwrap();
        let output = self.command().stdin(File::open(file.path()).unwrap()).output();
        let output = output.map_err(|error| format!("it cannot be started: {error}"))?;
        let is_done = output.status.success();
        is_done.then_some(output.stdout).ok_or(String::from_utf8_lossy(&output.stderr).into_owned())
    }

    fn command(&self) -> Command {
        if !self.emulated {
            return Command::new(&self.program);
        }
        let mut command = Command::new("qemu-system-arm");
        command
            .args(["-machine", "mps2-an386", "-display", "none", "-monitor", "none"])
            .args(["-serial", "none", "-semihosting-config", "enable=on,target=native"])
            .arg("-kernel")
            .arg(&self.program);
        command
    }
}

impl fmt::Display for Machine {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name)
    }
}

/// A number that differs.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Difference {
    /// Frame of the clip.
    pub frame: usize,
    /// Name of the body.
    pub body: &'static str,
    /// Quantity of the body.
    pub quantity: &'static str,
    /// Component of the quantity.
    pub component: &'static str,
    /// Bits of the number in both answers.
    pub bits: [u32; 2],
}

impl Difference {
    /// Returns the first difference, in the order in which the numbers are computed.
    ///
    /// # Panics
    /// If the answers have different numbers of ticks.
    pub fn first(answers: [&[u8]; 2]) -> Option<Self> {
        let [here, there] = answers;
        assert_eq!(here.len(), there.len(), "bytes of the answers");
        let mut numbers = here.as_chunks::<4>().0.iter().zip(there.as_chunks::<4>().0);
        let index = numbers.position(|(here, there)| here != there)?;
        let bits = answers.map(|answer| u32::from_le_bytes(answer.as_chunks::<4>().0[index]));
        let mut rest = index % (NUMBERS * BODY_COUNT);
        for (quantity, components) in QUANTITIES {
            let count = components.len() * BODY_COUNT;
            if rest < count {
                return Some(Self {
                    frame: index / (NUMBERS * BODY_COUNT),
                    body: BODIES[rest / components.len()].name,
                    quantity,
                    component: components[rest % components.len()],
                    bits,
                });
            }
            rest -= count;
        }
        unreachable!("the quantities together are a tick")
    }
}

impl fmt::Display for Difference {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { frame, body, quantity, component, bits: [here, there] } = self;
        write!(
            f,
            "frame {frame}, {body}, {quantity}, {component}: {here:08x} ({:e}) in the evaluation, {there:08x} ({:e}) there",
            f32::from_bits(*here),
            f32::from_bits(*there)
        )
    }
}
