//! A show as the tracker's frames.

use sinew_core::tracker::{Frame, FrameSource};

use crate::error::ShowError;
use crate::player::Player;
use crate::position::{Pace, Position};
use crate::show::Show;

/// The frames of a show with up to `COORDS` coordinates, one per tick.
///
/// Before the first frame, and after the last frame of a show without a loop, the rig rests in that frame: speeds and
/// accelerations are zero. To enter a show that does not start at rest, use a [run-in](Self::run_in), or from another
/// pose a [`Blend`](crate::Blend).
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
    /// Creates the frames of a show, `dt_s` apart. O(size): all blocks are checked once, so that playing finds no block
    /// that was already damaged.
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

    /// Returns the show.
    pub fn show(&self) -> &Show<'a> {
        self.player.show()
    }

    /// Returns the position of the show in a frame; the start for a negative index.
    pub fn position(&self, index: i32) -> Position {
        self.pace.position(u32::try_from(index).unwrap_or(0))
    }

    /// Returns the position of the show in a tick of a [run-in](Self::run_in).
    pub fn run_in_position(&self, tick: u32, of: u32) -> Position {
        let share = share(tick, of);
        // The integral of a rate that rises smoothly from 0 to 1: 3 s² - 2 s³.
        let ticks = of as f32 * share * share * share * (1.0 - 0.5 * share);
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "0 to of / 2")]
        let whole = ticks as u32;
        self.pace.position_within(whole, ticks - whole as f32)
    }

    /// Returns a frame of a run-in: from rest in the first frame, the show reaches its full pace within `of` ticks.
    /// It is then at frame `of / 2`, and continues from there if `of` is even. Each pose is a pose of the show, and
    /// no joint is faster than in the show. The change of pace adds an acceleration of at most 1.5 times the show's
    /// speed, divided by the duration of the run-in.
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

    /// Returns the error that made the last frame stand still in the middle of the show: the memory has changed since
    /// it was checked.
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

    /// Returns the coordinates read at a position. The rig rests if the show has ended, or cannot be read.
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

/// Returns the elapsed share of `of` ticks, 0 to 1.
fn share(tick: u32, of: u32) -> f32 {
    tick.min(of) as f32 / of.max(1) as f32
}
