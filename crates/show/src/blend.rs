//! Blends: motions from any pose into a show, or out of it, without a jump.

use core::fmt;

use crate::chart::{Coordinates, jets};
use crate::layout::LARGEST;
use crate::show::Show;
use crate::span::Jet;

/// Positions, speeds and accelerations of a rig, as defined in [`coordinates`](sinew_core::coordinates).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct State<'a> {
    /// Positions of the joints, nq numbers.
    pub q: &'a [f32],
    /// Speeds by dof, nv numbers.
    pub qd: &'a [f32],
    /// Accelerations by dof, nv numbers.
    pub qdd: &'a [f32],
}

/// Minimum duration of a blend, s.
const SHORTEST_S: f32 = 1e-3;
/// Maximum duration of a blend, s.
const LONGEST_S: f32 = 1e3;
/// Tolerance of a quaternion's squared length: deviation from 1.
const UNIT_TOLERANCE: f32 = 1e-3;
/// Number of intervals in which a blend of rotations is checked in advance.
const LOOKS: u16 = 64;
/// Minimum squared length of a blended quaternion. A shorter one turns too fast.
const SHORTEST_SQUARED: f32 = 0.04;

/// A motion from one state to another: a quintic in each channel, with continuous position, speed and acceleration at
/// both ends. For up to `COORDS` coordinates.
#[derive(Debug, Clone)]
pub struct Blend<'a, const COORDS: usize> {
    show: Show<'a>,
    duration_s: f32,
    /// Coefficients in powers of the elapsed share of the time, and of the remaining share: each end is exact to the
    /// last bits.
    powers: [[[f32; 6]; 2]; COORDS],
}

impl<'a, const COORDS: usize> Blend<'a, COORDS> {
    /// Creates a blend of a show's rig from one state to another. To blend into a show, let `to` be the show's state
    /// at the blend's end; the show continues from there. A ball joint takes the shorter way round. O(nq).
    ///
    /// # Errors
    /// [`BlendError`] if the show has more than `COORDS` coordinates, a slice does not fit the show's joints, a number
    /// is not from -1e6 to 1e6, a quaternion is not of length 1, the duration is not from 0.001 to 1000 s, or a ball
    /// joint would turn too far for a blend.
    pub fn new(
        show: Show<'a>,
        from: State<'_>,
        to: State<'_>,
        duration_s: f32,
    ) -> Result<Self, BlendError> {
        let (nq, nv) = (show.channel_count(), show.dof_count());
        for state in [from, to] {
            for (name, numbers, expected) in
                [("q", state.q, nq), ("qd", state.qd, nv), ("qdd", state.qdd, nv)]
            {
                let found = numbers.len();
                if found != expected {
                    return Err(BlendError::Count { name, expected, found });
                }
                let wrong = numbers.iter().position(|x| x.is_nan() || x.abs() > LARGEST);
                if let Some(index) = wrong {
                    let value = numbers.get(index).copied().unwrap_or_default();
                    return Err(BlendError::Number { name, index, value });
                }
            }
        }
        if nq > COORDS {
            return Err(BlendError::Capacity { found: nq, holds: COORDS });
        }
        if !(SHORTEST_S..=LONGEST_S).contains(&duration_s) {
            return Err(BlendError::Duration { found: duration_s });
        }
        let (mut begin, mut end) = ([Jet::default(); COORDS], [Jet::default(); COORDS]);
        let (mut at, mut v_at) = (0usize, 0usize);
        for joint in show.joints() {
            let (count, dofs) = (joint.coordinate_count(), joint.dof_count());
            let (next, v_next) = (at.saturating_add(count), v_at.saturating_add(dofs));
            for (state, all) in [(from, &mut begin), (to, &mut end)] {
                jets(
                    joint,
                    state.q.get(at..next).unwrap_or_default(),
                    state.qd.get(v_at..v_next).unwrap_or_default(),
                    state.qdd.get(v_at..v_next).unwrap_or_default(),
                    all.get_mut(at..next).unwrap_or_default(),
                );
            }
            if joint.turns_freely() {
                for state in [from, to] {
                    let rotation = state.q.get(at..at.saturating_add(4)).unwrap_or_default();
                    let squared = rotation.iter().fold(0.0, |sum, x| sum + x * x);
                    // All numbers are already finite.
                    if (squared - 1.0).abs() > UNIT_TOLERANCE {
                        return Err(BlendError::NotUnit { index: at, squared });
                    }
                }
                let rotation = at..at.saturating_add(4);
                let from = begin.get(rotation.clone()).unwrap_or_default();
                let to = end.get_mut(rotation).unwrap_or_default();
                let along = from.iter().zip(&*to).fold(0.0, |sum, (a, b)| sum + a[0] * b[0]);
                if along < 0.0 {
                    to.iter_mut().flatten().for_each(|x| *x = -*x);
                }
            }
            (at, v_at) = (next, v_next);
        }
        let mut powers = [[[0.0; 6]; 2]; COORDS];
        for ((powers, begin), end) in powers.iter_mut().zip(&begin).zip(&end) {
            let back = |[p, v, a]: Jet| [p, -v, a];
            let backwards = quintic(back(*end), back(*begin), duration_s);
            *powers = [quintic(*begin, *end, duration_s), backwards];
        }
        let blend = Self { show, duration_s, powers };
        blend.check_rotations()?;
        Ok(blend)
    }

    fn check_rotations(&self) -> Result<(), BlendError> {
        let mut at = 0usize;
        for (joint, kind) in self.show.joints().enumerate() {
            if kind.turns_freely() {
                let powers = self.powers.get(at..at.saturating_add(4)).unwrap_or_default();
                let squared = |look: u16| {
                    let share = f32::from(look) / f32::from(LOOKS);
                    let of = powers.iter().map(|powers| value(powers, share)[0]);
                    of.fold(0.0, |sum, p| sum + p * p)
                };
                // Written so that NaN is refused.
                if !(0..=LOOKS).all(|look| squared(look) >= SHORTEST_SQUARED) {
                    return Err(BlendError::Turns { joint });
                }
            }
            at = at.saturating_add(kind.coordinate_count());
        }
        Ok(())
    }

    /// Returns the duration, s.
    pub fn duration_s(&self) -> f32 {
        self.duration_s
    }

    /// Writes the state at a time from the start of the blend. Before the start this is the first state, after the
    /// end the last. Numbers that do not fit in a slice are left out. O(nq).
    pub fn state_at(&self, time_s: f32, q: &mut [f32], qd: &mut [f32], qdd: &mut [f32]) {
        let share = (time_s.max(0.0) / self.duration_s).min(1.0);
        let rate = 1.0 / self.duration_s;
        let mut to = Coordinates::new(q, qd, qdd);
        let mut powers = self.powers.iter();
        for joint in self.show.joints() {
            to.put(joint, || {
                let [p, v, a] =
                    powers.next().map(|powers| value(powers, share)).unwrap_or_default();
                [p, v * rate, a * rate * rate]
            });
        }
    }
}

/// Returns the quintic from one jet to another, in powers of the share of the time.
fn quintic(from: Jet, to: Jet, duration_s: f32) -> [f32; 6] {
    let scaled = |[p, v, a]: Jet| (p, v * duration_s, a * duration_s * duration_s);
    let ((p0, v0, a0), (p1, v1, a1)) = (scaled(from), scaled(to));
    // The remaining change of position, speed and acceleration.
    let p = p1 - p0 - v0 - 0.5 * a0;
    let v = v1 - v0 - a0;
    let a = a1 - a0;
    [
        p0,
        v0,
        0.5 * a0,
        10.0 * p - 4.0 * v + 0.5 * a,
        -15.0 * p + 7.0 * v - a,
        6.0 * p - 3.0 * v + 0.5 * a,
    ]
}

/// Returns a quintic and its derivatives, evaluated from the nearer end.
fn value([forwards, backwards]: &[[f32; 6]; 2], share: f32) -> Jet {
    let is_first_half = share <= 0.5;
    let x = if is_first_half { share } else { 1.0 - share };
    let [c0, c1, c2, c3, c4, c5] = *if is_first_half { forwards } else { backwards };
    let speed = c1 + x * (2.0 * c2 + x * (3.0 * c3 + x * (4.0 * c4 + x * (5.0 * c5))));
    [
        c0 + x * (c1 + x * (c2 + x * (c3 + x * (c4 + x * c5)))),
        if is_first_half { speed } else { -speed },
        2.0 * c2 + x * (6.0 * c3 + x * (12.0 * c4 + x * (20.0 * c5))),
    ]
}

/// An error in the arguments of a blend.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum BlendError {
    /// The length of a slice does not fit the show's joints.
    Count {
        /// Name of the slice.
        name: &'static str,
        /// Required length.
        expected: usize,
        /// Actual length.
        found: usize,
    },
    /// A number is NaN, or not from -1e6 to 1e6.
    Number {
        /// Name of the slice.
        name: &'static str,
        /// Index in the slice.
        index: usize,
        /// The invalid number.
        value: f32,
    },
    /// A quaternion is not of length 1.
    NotUnit {
        /// Index in `q` of the quaternion's first number.
        index: usize,
        /// Squared length of the quaternion.
        squared: f32,
    },
    /// The show has more coordinates than the capacity.
    Capacity {
        /// Number of coordinates of the show.
        found: usize,
        /// Maximum number of coordinates.
        holds: usize,
    },
    /// The duration is not from 0.001 to 1000 s.
    Duration {
        /// Duration, s.
        found: f32,
    },
    /// A ball joint would turn so far that the direct way is ambiguous: the blend is too long for the joint's speed.
    Turns {
        /// Index of the joint.
        joint: usize,
    },
}

impl fmt::Display for BlendError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Count { name, expected, found } => {
                write!(f, "{name} must have {expected} numbers for this show, not {found}")
            }
            Self::Number { name, index, value } => {
                write!(f, "{name}[{index}] is {value}; it must be a number from -1e6 to 1e6")
            }
            Self::NotUnit { index, squared } => write!(
                f,
                "the quaternion from q[{index}] on has squared length {squared}; it must be a unit quaternion"
            ),
            Self::Capacity { found, holds } => {
                write!(f, "the show has {found} joint coordinates, the board holds {holds}")
            }
            Self::Duration { found } => {
                write!(f, "the blend takes {found} s; it must take from 0.001 to 1000 s")
            }
            Self::Turns { joint } => write!(
                f,
                "joint {joint} turns too fast for so long a blend: choose a shorter one, or begin at rest"
            ),
        }
    }
}

impl core::error::Error for BlendError {}
