//! A show as the tracker's frames.

use sinew_core::tracker::{Frame, FrameSource};

use crate::error::ShowError;
use crate::player::Player;
use crate::position::{Pace, Position};
use crate::show::Show;

/// The frames of a show of at most `COORDS` coordinates, one a tick.
///
/// Before the first frame and behind the last one of a show without a loop, the rig rests in that frame: speeds and
/// accelerations are zero there. A show that does not begin at rest is entered by a [run-in](Self::run_in), or from
/// elsewhere by a [`Blend`](crate::Blend).
#[derive(Debug, Clone)]
pub struct ShowFrames<'a, const COORDS: usize> {
    player: Player<'a, COORDS>,
    pace: Pace,
    dt_s: f32,
    dofs: usize,
    q: [f32; COORDS],
    qd: [f32; COORDS],
    qdd: [f32; COORDS],
    fault: Option<ShowError>,
}

impl<'a, const COORDS: usize> ShowFrames<'a, COORDS> {
    /// The frames of a show, `dt_s` apart. O(size): all blocks are checked here, once, so that playing does not meet
    /// one that was damaged before.
    ///
    /// # Errors
    /// [`ShowError`] if a block is damaged, or the show has more than `COORDS` coordinates.
    pub fn new(show: Show<'a>, dt_s: f32) -> Result<Self, ShowError> {
        show.check_blocks()?;
        let mut frames = Self {
            player: Player::new(show)?,
            pace: show.pace(dt_s),
            dt_s,
            dofs: show.dof_count(),
            q: [0.0; COORDS],
            qd: [0.0; COORDS],
            qdd: [0.0; COORDS],
            fault: None,
        };
        frames.read(Position::default());
        frames.fault.map_or(Ok(frames), Err)
    }

    /// The show.
    pub fn show(&self) -> &Show<'a> {
        self.player.show()
    }

    /// Where the show is in a frame.
    pub fn position(&self, index: i32) -> Position {
        self.pace.position(u32::try_from(index).unwrap_or(0))
    }

    /// Where the show is in a tick of a [run-in](Self::run_in).
    pub fn run_in_position(&self, tick: u32, of: u32) -> Position {
        let share = share(tick, of);
        // The integral of a rate from 0 to 1, smooth at both ends: 3 s² - 2 s³.
        let ticks = of as f32 * share * share * share * (1.0 - 0.5 * share);
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "0 to of / 2")]
        let whole = ticks as u32;
        self.pace.position_within(whole, ticks - whole as f32)
    }

    /// A frame of a run-in: from standing in the first frame, the show gains its pace within `of` ticks, and is at
    /// frame `of / 2` then, to go on there if `of` is even. Each pose is one of the show's, no joint is faster than
    /// there, and what the pace adds to its acceleration is at most 1.5 times its speed over the time of the run-in.
    pub fn run_in(&mut self, tick: u32, of: u32) -> Frame<'_> {
        self.read(self.run_in_position(tick, of));
        let share = share(tick, of);
        let rate = share * share * (3.0 - 2.0 * share);
        let change = 6.0 * share * (1.0 - share) / (of.max(1) as f32 * self.dt_s);
        for (qd, qdd) in self.qd.iter_mut().zip(&mut self.qdd) {
            (*qd, *qdd) = (*qd * rate, *qdd * rate * rate + *qd * change);
        }
        self.coordinates(self.run_in_position(tick, of))
    }

    /// Why the last frame stands still in the middle of the show: memory that was whole has changed since.
    pub fn fault(&self) -> Option<ShowError> {
        self.fault
    }

    fn read(&mut self, position: Position) {
        let Self { player, q, qd, qdd, .. } = self;
        self.fault = player.state_at(position, q, qd, qdd).err();
    }

    fn rest(&mut self) {
        (self.qd, self.qdd) = ([0.0; COORDS], [0.0; COORDS]);
    }

    /// What was read at a position; the rig rests where the show has ended, or cannot be read.
    fn coordinates(&mut self, position: Position) -> Frame<'_> {
        let show = self.player.show();
        let end = Position::from_samples(show.length());
        if self.fault.is_some() || (position > end && !show.is_loop()) {
            self.rest();
        }
        let coordinates = self.player.show().channel_count();
        Frame::Coordinates {
            q: self.q.get(..coordinates).unwrap_or_default(),
            qd: self.qd.get(..self.dofs).unwrap_or_default(),
            qdd: self.qdd.get(..self.dofs).unwrap_or_default(),
        }
    }
}

impl<const COORDS: usize> FrameSource for ShowFrames<'_, COORDS> {
    fn frame(&mut self, index: i32) -> Frame<'_> {
        let position = self.position(index);
        self.read(position);
        if index < 0 {
            self.rest();
        }
        self.coordinates(position)
    }
}

/// What part of so many ticks has gone, 0 to 1.
fn share(tick: u32, of: u32) -> f32 {
    tick.min(of) as f32 / of.max(1) as f32
}
