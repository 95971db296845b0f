//! Baked shows: a rig and the frames it performs, read in place from flash.
//!
//! # Format, version 1
//! All numbers little-endian; `f32` as IEEE 754.
//!
//! | bytes | what |
//! | --- | --- |
//! | 4 | magic `SNWS` |
//! | u16 | version, 1 |
//! | u16 | bodies n, at least 1 |
//! | u32 | frames f, at least 1 |
//! | f32 | time from frame to frame, s: from 1e-9 to 1000 |
//! | n x 108 | rig, per body: parent i16 (-1: the world), joint kind u16 (0 fixed, 1 revolute, 2 prismatic, 3
//! universal, 4 spherical, 5 free), two axes 6 x f32 (unused ones zero), placement quaternion xyzw and translation 7 x
//! f32 (m), performer's offset 3 x f32 (m), mass f32 (kg), centre of mass 3 x f32 (m), inertia xx xy xz yy yz zz 6 x
//! f32 (kg m²) |
//! | f x (12 + 16 n) | frame: root translation 3 x f32 (m), rotation of each body to its parent, xyzw 4 x f32 |
//! | u32 | CRC-32 (ISO-HDLC) of all bytes before it |
//!
//! The rig's placements are the machine's own; the performer's offsets are those of the animation. Both are
//! kept because a rig need not have the dimensions of the figure it imitates. No translation is longer than 1000 m.

use core::fmt;
use core::ops::RangeInclusive;

use crc::{CRC_32_ISO_HDLC, Crc};
use sinew_core::glam::{Quat, Vec3};
use sinew_core::{Body, Inertia, JointKind, RotationalInertia, Transform, Tree, TreeError};

const MAGIC: [u8; 4] = *b"SNWS";
const VERSION: u16 = 1;
const HEADER_LEN: usize = 16;
const BODY_LEN: usize = 108;
/// Where a body's placement has its translation, and where the performer's offset is.
const PLACE_AT: usize = 44;
const OFFSET_AT: usize = 56;
const CRC_LEN: usize = 4;
const CHECKSUM: Crc<u32> = Crc::<u32>::new(&CRC_32_ISO_HDLC);

/// How far a stored quaternion's squared length may be from 1: it was unit in f32 when it was baked.
const UNIT_TOLERANCE: f32 = 1e-3;

/// The farthest that a body may be from its parent, and the root from the origin, m. The tracker takes differences of
/// positions up to 1e6 m. Frames before the first go on as the first step did: hundreds of them stay within that.
const FARTHEST_M: f32 = 1e3;

/// Times from frame to frame, in s. The shortest is that of the tracker's differences. The longest times the most ticks
/// that can be lost (65,535) is still a number.
const TIME_STEPS_S: RangeInclusive<f32> = 1e-9..=1e3;

/// A baked show, checked as a whole when it was opened.
///
/// ```
/// use sinew_core::{Body, Inertia, JointKind, Transform};
/// use sinew_firmware::show::{Show, ShowError, write};
/// let head = Body {
///     parent: None,
///     joint: JointKind::Spherical,
///     placement: Transform::IDENTITY,
///     inertia: Inertia::default(),
///     rotor_inertia: 0.0,
/// };
/// let frames = [[Transform::IDENTITY]; 3];
/// let mut flash = Vec::new();
/// write(&[head], 0.01, frames.iter().map(|frame| &frame[..]), |piece| {
///     flash.extend_from_slice(piece);
///     Ok::<(), ShowError>(())
/// })?;
/// let show = Show::parse(&flash)?;
/// assert_eq!((show.body_count(), show.frame_count(), show.dt_s()), (1, 3, 0.01));
/// assert_eq!(show.tree::<1>()?.bodies(), [head]);
/// // One bit of it has flipped.
/// flash[100] ^= 1;
/// assert!(matches!(Show::parse(&flash), Err(ShowError::Checksum { .. })));
/// # Ok::<(), ShowError>(())
/// ```
#[derive(Debug, Clone, Copy)]
pub struct Show<'a> {
    bodies: usize,
    frames: usize,
    dt_s: f32,
    rig: &'a [u8],
    performance: &'a [u8],
}

impl<'a> Show<'a> {
    /// Opens a show where it lies. O(size): everything is checked here, once, so that neither reading a frame nor a
    /// tick that performs it can fail. What else a rig must be is checked by [`Self::tree`].
    ///
    /// # Errors
    /// [`ShowError`] names what is wrong and where.
    pub fn parse(bytes: &'a [u8]) -> Result<Self, ShowError> {
        let mut header = Reader { bytes, at: 0 };
        let magic = [header.u8()?, header.u8()?, header.u8()?, header.u8()?];
        if magic != MAGIC {
            return Err(ShowError::Magic { found: magic });
        }
        let version = header.u16()?;
        if version != VERSION {
            return Err(ShowError::Version { found: version });
        }
        let bodies = usize::from(header.u16()?);
        let frames = usize::try_from(header.u32()?).map_err(|_| ShowError::Empty)?;
        let dt_s = header.f32()?;
        if bodies == 0 || frames == 0 {
            return Err(ShowError::Empty);
        }
        if !TIME_STEPS_S.contains(&dt_s) {
            return Err(ShowError::TimeStep { found: dt_s });
        }
        let rig_len = bodies.saturating_mul(BODY_LEN);
        let performance_len = frame_len(bodies).saturating_mul(frames);
        let expected = HEADER_LEN
            .saturating_add(rig_len)
            .saturating_add(performance_len)
            .saturating_add(CRC_LEN);
        if bytes.len() != expected {
            return Err(ShowError::Length { expected, found: bytes.len() });
        }
        let too_short = ShowError::Length { expected, found: bytes.len() };
        let (content, stored) = bytes.split_last_chunk::<CRC_LEN>().ok_or(too_short)?;
        let (stored, computed) = (u32::from_le_bytes(*stored), CHECKSUM.checksum(content));
        if stored != computed {
            return Err(ShowError::Checksum { stored, computed });
        }
        let body = content.get(HEADER_LEN..).ok_or(too_short)?;
        let (rig, performance) = body.split_at_checked(rig_len).ok_or(too_short)?;
        let show = Self { bodies, frames, dt_s, rig, performance };
        show.check_places()?;
        show.check_frames()?;
        Ok(show)
    }

    fn check_places(&self) -> Result<(), ShowError> {
        for body in 0..self.bodies {
            if !is_near(self.of_rig(body, PLACE_AT).vec3()?) {
                return Err(ShowError::Place { body });
            }
        }
        Ok(())
    }

    fn check_frames(&self) -> Result<(), ShowError> {
        for frame in 0..self.frames {
            for body in 0..self.bodies {
                let Transform { rotation, translation_m } = self.pose(frame, body);
                let squared = rotation.dot(rotation);
                // Written so that NaN is refused.
                let unit = (squared - 1.0).abs() <= UNIT_TOLERANCE;
                if !(unit && is_near(translation_m)) {
                    return Err(ShowError::Pose { frame, body });
                }
            }
        }
        Ok(())
    }

    /// Number of bodies, and of joints.
    pub fn body_count(&self) -> usize {
        self.bodies
    }

    /// Number of frames, at least one.
    pub fn frame_count(&self) -> usize {
        self.frames
    }

    /// Time from one frame to the next, s.
    pub fn dt_s(&self) -> f32 {
        self.dt_s
    }

    /// The rig, checked as every tree is.
    ///
    /// # Errors
    /// [`ShowError`] if a body cannot be, or there are more than `N`.
    pub fn tree<const N: usize>(&self) -> Result<Tree<N>, ShowError> {
        let mut tree = Tree::new();
        for body in 0..self.bodies {
            tree.push(self.rig_body(body)?).map_err(ShowError::Rig)?;
        }
        Ok(tree)
    }

    /// Poses of a frame by joint, as they were baked, with the performer's offsets; the last frame for any index
    /// beyond it. What is longer than the show has bodies is left alone.
    pub fn frame(&self, index: usize, out: &mut [Transform]) {
        let index = index.min(self.frames.saturating_sub(1));
        for (body, pose) in out.iter_mut().enumerate().take(self.bodies) {
            *pose = self.pose(index, body);
        }
    }

    /// A pose as it is stored. Indices are below the counts, and the lengths were checked: a reading past
    /// the end, which cannot be, would be zeros.
    fn pose(&self, frame: usize, body: usize) -> Transform {
        let start = frame_len(self.bodies).saturating_mul(frame);
        let mut at = Reader {
            bytes: self.performance,
            at: start.saturating_add(12).saturating_add(body.saturating_mul(16)),
        };
        let rotation = at.quat().unwrap_or(Quat::from_xyzw(0.0, 0.0, 0.0, 0.0));
        let mut at = if body == 0 {
            Reader { bytes: self.performance, at: start }
        } else {
            self.of_rig(body, OFFSET_AT)
        };
        Transform { rotation, translation_m: at.vec3().unwrap_or(Vec3::ZERO) }
    }

    /// The numbers of a body of the rig, from a byte of them on.
    fn of_rig(&self, body: usize, from: usize) -> Reader<'a> {
        Reader { bytes: self.rig, at: body.saturating_mul(BODY_LEN).saturating_add(from) }
    }

    fn rig_body(&self, body: usize) -> Result<Body, ShowError> {
        let mut at = self.of_rig(body, 0);
        let parent = match at.u16()?.cast_signed() {
            -1 => None,
            found => Some(usize::try_from(found).map_err(|_| ShowError::Parent { body, found })?),
        };
        let kind = at.u16()?;
        let (first, second) = (at.vec3()?, at.vec3()?);
        let joint = match kind {
            0 => JointKind::Fixed,
            1 => JointKind::Revolute { axis: first },
            2 => JointKind::Prismatic { axis: first },
            3 => JointKind::Universal { first, second },
            4 => JointKind::Spherical,
            5 => JointKind::Free,
            found => return Err(ShowError::JointKind { body, found }),
        };
        let placement = Transform::new(at.quat()?, at.vec3()?);
        at.vec3()?; // the performer's offset, read with the frames
        let mass_kg = at.f32()?;
        let center_of_mass_m = at.vec3()?;
        let rotational_kg_m2 = RotationalInertia {
            xx: at.f32()?,
            xy: at.f32()?,
            xz: at.f32()?,
            yy: at.f32()?,
            yz: at.f32()?,
            zz: at.f32()?,
        };
        let inertia = Inertia { mass_kg, center_of_mass_m, rotational_kg_m2 };
        Ok(Body { parent, joint, placement, inertia, rotor_inertia: 0.0 })
    }
}

/// Whether differences of a position can be taken. Written so that NaN is refused.
fn is_near(position_m: Vec3) -> bool {
    position_m.dot(position_m) <= FARTHEST_M * FARTHEST_M
}

const fn frame_len(bodies: usize) -> usize {
    bodies.saturating_mul(16).saturating_add(12)
}

/// Writes a show, piece by piece, to `sink`. Each frame has one pose per body; the translations of all
/// but the root are taken from the first frame, as the performer's offsets. Rotor inertias are not kept: those of the
/// figure, whose shows these are, are zero.
///
/// # Errors
/// What `sink` returns.
pub fn write<'f, E>(
    rig: &[Body],
    dt_s: f32,
    frames: impl ExactSizeIterator<Item = &'f [Transform]> + Clone,
    mut sink: impl FnMut(&[u8]) -> Result<(), E>,
) -> Result<(), E> {
    let mut digest = CHECKSUM.digest();
    let mut put = |bytes: &[u8]| {
        digest.update(bytes);
        sink(bytes)
    };
    put(&MAGIC)?;
    put(&VERSION.to_le_bytes())?;
    // Counts beyond the fields' range saturate, and such a show is refused when it is opened.
    put(&u16::try_from(rig.len()).unwrap_or(u16::MAX).to_le_bytes())?;
    put(&u32::try_from(frames.len()).unwrap_or(u32::MAX).to_le_bytes())?;
    put(&dt_s.to_le_bytes())?;
    let offsets = frames.clone().next().unwrap_or_default();
    for (index, body) in rig.iter().enumerate() {
        let parent = body.parent.and_then(|parent| i16::try_from(parent).ok()).unwrap_or(-1);
        let (kind, first, second) = match body.joint {
            JointKind::Fixed => (0u16, Vec3::ZERO, Vec3::ZERO),
            JointKind::Revolute { axis } => (1, axis, Vec3::ZERO),
            JointKind::Prismatic { axis } => (2, axis, Vec3::ZERO),
            JointKind::Universal { first, second } => (3, first, second),
            JointKind::Spherical => (4, Vec3::ZERO, Vec3::ZERO),
            JointKind::Free => (5, Vec3::ZERO, Vec3::ZERO),
        };
        put(&parent.to_le_bytes())?;
        put(&kind.to_le_bytes())?;
        let offset = offsets.get(index).map_or(Vec3::ZERO, |pose| pose.translation_m);
        let inertia = &body.inertia;
        let i = &inertia.rotational_kg_m2;
        let numbers = [first, second]
            .into_iter()
            .flat_map(|axis| axis.to_array())
            .chain(body.placement.rotation.to_array())
            .chain(body.placement.translation_m.to_array())
            .chain(offset.to_array())
            .chain([inertia.mass_kg])
            .chain(inertia.center_of_mass_m.to_array())
            .chain([i.xx, i.xy, i.xz, i.yy, i.yz, i.zz]);
        for number in numbers {
            put(&number.to_le_bytes())?;
        }
    }
    for frame in frames {
        let root = frame.first().map_or(Vec3::ZERO, |pose| pose.translation_m);
        for number in root
            .to_array()
            .into_iter()
            .chain(frame.iter().take(rig.len()).flat_map(|pose| pose.rotation.to_array()))
        {
            put(&number.to_le_bytes())?;
        }
    }
    let crc = digest.finalize();
    sink(&crc.to_le_bytes())
}

struct Reader<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl Reader<'_> {
    fn take<const K: usize>(&mut self) -> Result<[u8; K], ShowError> {
        let end = self.at.saturating_add(K);
        let field = self.bytes.get(self.at..end).and_then(|field| field.try_into().ok());
        let truncated = ShowError::Length { expected: end, found: self.bytes.len() };
        self.at = end;
        field.ok_or(truncated)
    }

    fn u8(&mut self) -> Result<u8, ShowError> {
        self.take().map(u8::from_le_bytes)
    }

    fn u16(&mut self) -> Result<u16, ShowError> {
        self.take().map(u16::from_le_bytes)
    }

    fn u32(&mut self) -> Result<u32, ShowError> {
        self.take().map(u32::from_le_bytes)
    }

    fn f32(&mut self) -> Result<f32, ShowError> {
        self.take().map(f32::from_le_bytes)
    }

    fn vec3(&mut self) -> Result<Vec3, ShowError> {
        Ok(Vec3::new(self.f32()?, self.f32()?, self.f32()?))
    }

    fn quat(&mut self) -> Result<Quat, ShowError> {
        Ok(Quat::from_xyzw(self.f32()?, self.f32()?, self.f32()?, self.f32()?))
    }
}

/// Why a show cannot be performed.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum ShowError {
    /// It does not begin with `SNWS`.
    Magic {
        /// How it begins.
        found: [u8; 4],
    },
    /// It is of another version than 1.
    Version {
        /// Its version.
        found: u16,
    },
    /// It has no bodies or no frames.
    Empty,
    /// The time step is not from 1e-9 s to 1000 s.
    TimeStep {
        /// What it is.
        found: f32,
    },
    /// It is shorter or longer than its header says.
    Length {
        /// Bytes there should be.
        expected: usize,
        /// Bytes there are.
        found: usize,
    },
    /// It was damaged.
    Checksum {
        /// The CRC it carries.
        stored: u32,
        /// The CRC of its content.
        computed: u32,
    },
    /// The parent of a body is neither a body nor the world.
    Parent {
        /// The body.
        body: usize,
        /// The number of its parent.
        found: i16,
    },
    /// A joint is of a kind that there is not.
    JointKind {
        /// The body.
        body: usize,
        /// The number of the kind.
        found: u16,
    },
    /// A body of the rig is more than 1000 m from its parent.
    Place {
        /// The body.
        body: usize,
    },
    /// A pose is more than 1000 m away, or its rotation not a unit quaternion.
    Pose {
        /// The frame.
        frame: usize,
        /// The body.
        body: usize,
    },
    /// The rig cannot be.
    Rig(TreeError),
}

impl fmt::Display for ShowError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Magic { found } => {
                write!(f, "not a show: it begins with {found:02x?} instead of `SNWS`")
            }
            Self::Version { found } => {
                write!(
                    f,
                    "the show is of version {found}; this firmware performs version {VERSION}"
                )
            }
            Self::Empty => f.write_str("the show has no bodies or no frames"),
            Self::TimeStep { found } => {
                let (least, most) = (TIME_STEPS_S.start(), TIME_STEPS_S.end());
                write!(
                    f,
                    "the show's time step is {found} s; it must be from {least:e} to {most} s"
                )
            }
            Self::Length { expected, found } => {
                write!(f, "the show has {found} bytes where its header asks for {expected}")
            }
            Self::Checksum { stored, computed } => write!(
                f,
                "the show is damaged: it carries CRC {stored:08x}, its content has {computed:08x}"
            ),
            Self::Parent { body, found } => write!(
                f,
                "body {body} has parent {found}; it must be the index of a body, or -1 for the world"
            ),
            Self::JointKind { body, found } => {
                write!(f, "body {body} has joint kind {found}; kinds are 0 to 5")
            }
            Self::Place { body } => {
                write!(
                    f,
                    "body {body} is not within {FARTHEST_M} m of its parent, by the show's rig"
                )
            }
            Self::Pose { frame, body } => write!(
                f,
                "frame {frame}, body {body}: the pose is not within {FARTHEST_M} m or its rotation not unit"
            ),
            Self::Rig(error) => write!(f, "the show's rig: {error}"),
        }
    }
}

impl core::error::Error for ShowError {}
