//! Where a board's frames come from.

use sinew_core::Transform;
use sinew_core::tracker::{Frame, FrameSource, before_the_first};

use crate::show::Show;

/// The frames of a baked show, read from where it lies. Before its first frame it moves on as in its first step,
/// after its last it stands.
///
/// ```
/// use sinew_core::Transform;
/// use sinew_core::tracker::{Settings, Timing, Tracker};
/// use sinew_firmware::{frames::ShowFrames, show::Show};
/// # let flash = {
/// #     use sinew_core::{Body, Inertia, JointKind};
/// #     let (parent, joint, placement) = (None, JointKind::Spherical, Transform::IDENTITY);
/// #     let head = Body { parent, joint, placement, inertia: Inertia::default(), rotor_inertia: 0.0 };
/// #     let (mut flash, frames) = (Vec::new(), [[Transform::IDENTITY]; 3]);
/// #     let sink = |piece: &[u8]| Ok::<(), std::fmt::Error>(flash.extend_from_slice(piece));
/// #     sinew_firmware::show::write(&[head], 0.002, frames.iter().map(|f| &f[..]), sink)?;
/// #     flash
/// # };
/// let show = Show::parse(&flash)?;
/// // 500 ticks a second; a torque acts two ticks late.
/// let timing = Timing { dt_s: show.dt_s(), latency_ticks: 2 };
/// let mut tracker = Tracker::<1, 8>::new(show.tree()?, &Settings::recommended(), timing)?;
/// let mut frames = ShowFrames::<1>::new(show);
/// let measured = [Transform::IDENTITY];
/// tracker.begin(&mut frames, 0, &measured)?;
/// for tick in 0..3 {
///     let tick = tracker.step(&mut frames, tick, &measured)?;
///     assert_eq!(tick.torques().len(), 1);
/// }
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ShowFrames<'a, const N: usize> {
    show: Show<'a>,
    poses: [Transform; N],
}

impl<'a, const N: usize> ShowFrames<'a, N> {
    /// The frames of a show of at most `N` bodies; of a larger one, [`Show::tree`] is refused.
    pub fn new(show: Show<'a>) -> Self {
        Self { show, poses: [Transform::IDENTITY; N] }
    }

    /// The show.
    pub fn show(&self) -> &Show<'a> {
        &self.show
    }
}

impl<const N: usize> FrameSource for ShowFrames<'_, N> {
    fn frame(&mut self, index: i32) -> Frame<'_> {
        match usize::try_from(index) {
            Ok(index) => self.show.frame(index, &mut self.poses),
            Err(_) => before(&self.show, index.unsigned_abs(), &mut self.poses),
        }
        let bodies = self.show.body_count().min(N);
        Frame::Poses(self.poses.get(..bodies).unwrap_or_default())
    }
}

/// A frame before the first.
// Only a beginning asks for it: apart, so that no tick pays for its stack.
#[inline(never)]
fn before<const N: usize>(show: &Show<'_>, frames: u32, out: &mut [Transform; N]) {
    let mut second = [Transform::IDENTITY; N];
    show.frame(1, &mut second);
    show.frame(0, out);
    for (pose, second) in out.iter_mut().zip(&second) {
        *pose = before_the_first(pose, second, frames);
    }
}
