//! The hardware watchdog, which resets a board that completes no more ticks.

use sinew_core::tracker::Tick;

/// Proof that a tick was complete and valid, which feeds the watchdog.
/// [`MotionController::end`](crate::controller::MotionController::end) creates it for a tick of the loop; on a board
/// without the loop, a tracker's tick is converted to it.
#[derive(Debug)]
#[must_use = "it feeds the watchdog"]
pub struct Complete(());

impl Complete {
    pub(crate) fn new() -> Self {
        Self(())
    }
}

/// Only a tick that was not refused has a [`Tick`]. It is consumed, so a tick feeds only once.
impl<const N: usize, const D: usize, const R: usize> From<Tick<'_, N, D, R>> for Complete {
    fn from(_: Tick<'_, N, D, R>) -> Self {
        Self::new()
    }
}

/// A board's watchdog, which only a complete tick feeds: it owns the function that feeds the hardware.
///
/// ```
/// use sinew_firmware::watchdog::Watchdog;
/// # use sinew_core::tracker::{Frame, FrameSource, Settings, Timing, Tracker};
/// # use sinew_core::{Body, Inertia, JointKind, Transform, Tree};
/// # let (parent, joint, placement) = (None, JointKind::Spherical, Transform::IDENTITY);
/// # let head = Body { parent, joint, placement, inertia: Inertia::default(), rotor_inertia: 0.0 };
/// # struct Still;
/// # impl FrameSource for Still {
/// #     fn frame(&mut self, _: i32) -> Frame<'_> {
/// #         Frame::Poses(&[Transform::IDENTITY])
/// #     }
/// # }
/// # let timing = Timing { dt_s: 0.01, latency_ticks: 0 };
/// # let mut tracker =
/// #     Tracker::<1>::new(Tree::from_bodies(&[head])?, &Settings::default(), timing)?;
/// # let (mut show, measured) = (Still, [Transform::IDENTITY]);
/// # let mut fed = 0;
/// let mut watchdog = Watchdog::new(|| fed += 1);
/// match tracker.step(&mut show, 0, &measured) {
///     Ok(asked) => watchdog.feed(asked.into()),
///     Err(refused) => eprintln!("not fed: {refused}"),
/// }
/// # assert_eq!(fed, 1);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// Without a tick, feeding does not compile:
///
/// ```compile_fail
/// use sinew_firmware::watchdog::{Complete, Watchdog};
/// let mut watchdog = Watchdog::new(|| ());
/// watchdog.feed(Complete(()));
/// ```
#[derive(Debug)]
pub struct Watchdog<F>(F);

impl<F: FnMut()> Watchdog<F> {
    /// Creates the wrapper of a watchdog that runs. `feed` must be the only function that feeds it.
    pub fn new(feed: F) -> Self {
        Self(feed)
    }

    /// Feeds the watchdog for a tick. O(1).
    #[expect(clippy::needless_pass_by_value, reason = "a tick feeds once")]
    pub fn feed(&mut self, tick: Complete) {
        let Complete(()) = tick;
        (self.0)();
    }
}
