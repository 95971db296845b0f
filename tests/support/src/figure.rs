//! The human figure as boards use it: its compact form, and shows of its coordinates.

use std::error::Error;

use sinew_bit_parity::replay::{METHODS, hash, ticks, tree};
use sinew_figure::builtin;
use sinew_figure::pipeline::{Settings, prepare};
use sinew_figure::{BODY_COUNT, BodyModel, FigureMotion, Root};
use sinew_rig::board::BoardRig;
use sinew_rig::{Description, Mechanism};
use sinew_show::write::{Motion, Settings as ShowSettings, write};
use sinew_show::{Joint, Rate, Show};

/// Number of degrees of freedom of the figure: a free root, and ball joints.
pub const DOFS: usize = 6 + 3 * (BODY_COUNT - 1);

/// Number of coordinates of the figure: a quaternion has four.
pub const COORDINATES: usize = 7 + 4 * (BODY_COUNT - 1);

/// The clip of the show that emulated boards perform.
const CLIP: &str = "kicks_01";

/// Scale of that show's rig, relative to the clip's performer.
const SCALE: f64 = 1.1;

/// A rig and a show for it, in the format of boards.
#[derive(Debug, Clone)]
pub struct FigureShow {
    /// The rig in its compact form.
    pub rig: Vec<u8>,
    /// The show, one sample for each frame of the clip.
    pub show: Vec<u8>,
}

impl FigureShow {
    /// Returns a line for each method: the hash of the torques that this machine computes for the show.
    ///
    /// # Errors
    /// Returns an error if rig and show do not match.
    pub fn torque_hashes(&self) -> Result<Vec<String>, Box<dyn Error>> {
        let (tree, show) = (tree::<BODY_COUNT, DOFS>(&self.rig)?, Show::open(&self.show)?);
        show.check_rig(self.rig.last_chunk().copied().map_or(0, u32::from_le_bytes))?;
        let ticks = ticks(&show);
        let mut lines = Vec::new();
        for method in METHODS {
            let hash = hash::<BODY_COUNT, COORDINATES>(&tree, show, method, ticks)?;
            lines.push(format!("method={method} ticks={ticks} hash={hash:016x}"));
        }
        Ok(lines)
    }
}

/// Returns the show that emulated boards perform: at most `seconds` of a built-in clip.
///
/// # Panics
/// If the clip or the figure was changed.
pub fn figure_show(seconds: f64) -> FigureShow {
    let clip = builtin::clips().into_iter().find(|clip| clip.name == CLIP).expect(CLIP);
    let (motion, _) = prepare(clip, &Settings::default()).expect("a built-in clip");
    let model = BodyModel::from_motion(&motion).expect("a built-in clip").scaled(SCALE);
    let mechanism = model.mechanism(Root::Driven);
    let rig = rig(&mechanism);
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a few thousand")]
    let frames = motion.rotation.len().min((seconds / motion.dt_s).round() as usize);
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a small number")]
    let samples = motion.dt_s.recip().round() as u32;
    let joints: Vec<Joint> =
        mechanism.bodies.iter().map(|link| Joint::from(link.joint.kind())).collect();
    let q: Vec<f64> =
        (0..frames).flat_map(|frame| coordinates(&motion, &mechanism, frame)).collect();
    let motion = Motion {
        joints: &joints,
        q: &q,
        rate: Rate { samples, seconds: 1 },
        is_loop: false,
        rig: rig.last_chunk().copied().map_or(0, u32::from_le_bytes),
        cues: &[],
        time_code: None,
        course: &[],
    };
    let written = write(&motion, &ShowSettings::default()).expect("a motion that a show holds");
    FigureShow { rig, show: written.bytes }
}

/// Returns the figure in a rig's compact form, without servos.
///
/// # Panics
/// If a number of the figure does not fit into f32.
pub fn rig(mechanism: &Mechanism) -> Vec<u8> {
    let rig = BoardRig::<BODY_COUNT, DOFS, 0>::bake(&Description::default(), mechanism)
        .expect("the figure is a rig");
    let mut bytes = vec![0; 1 << 14];
    let length = rig.encode(&mut bytes).expect("there is room");
    bytes.truncate(length);
    bytes
}

/// Returns the coordinates of the figure in a frame of a motion: first its root, then its ball joints.
fn coordinates(
    motion: &FigureMotion,
    mechanism: &Mechanism,
    frame: usize,
) -> impl Iterator<Item = f64> {
    let root_m = motion.root_position_m[frame] - mechanism.bodies[0].position_m;
    motion.rotation[frame].iter().enumerate().flat_map(move |(body, rotation)| {
        let position_m = (body == 0).then_some(root_m.to_array());
        rotation.to_array().into_iter().chain(position_m.into_iter().flatten())
    })
}
