//! A show as the tracker's frames.

use sinew_core::tracker::{Frame, FrameSource};

use crate::error::ShowError;
use crate::player::Player;
use crate::position::{Pace, Position};
use crate::show::Show;

/// The frames of a show of at most `C` coordinates, one a tick.
///
/// Before the first frame and behind the last one of a show without a loop, the rig rests in that frame: speeds and
/// accelerations are zero there. A show that does not begin at rest is entered by a [`Blend`](crate::Blend).
#[derive(Debug, Clone)]
pub struct ShowFrames<'a, const C: usize> {
    player: Player<'a, C>,
    pace: Pace,
    freedoms: usize,
    q: [f32; C],
    qd: [f32; C],
    qdd: [f32; C],
    fault: Option<ShowError>,
}

impl<'a, const C: usize> ShowFrames<'a, C> {
    /// The frames of a show, `dt_s` apart. O(size): all blocks are checked here, once, so that playing does not meet
    /// one that was damaged before.
    ///
    /// # Errors
    /// [`ShowError`] if a block is damaged, or the show has more than `C` coordinates.
    pub fn new(show: Show<'a>, dt_s: f32) -> Result<Self, ShowError> {
        show.check_blocks()?;
        let mut frames = Self {
            player: Player::new(show)?,
            pace: show.pace(dt_s),
            freedoms: show.degrees_of_freedom(),
            q: [0.0; C],
            qd: [0.0; C],
            qdd: [0.0; C],
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

    /// Why the last frame stands still in the middle of the show: memory that was whole has changed since.
    pub fn fault(&self) -> Option<ShowError> {
        self.fault
    }

    fn read(&mut self, position: Position) {
        let Self { player, q, qd, qdd, .. } = self;
        self.fault = player.state_at(position, q, qd, qdd).err();
    }

    fn rest(&mut self) {
        (self.qd, self.qdd) = ([0.0; C], [0.0; C]);
    }
}

impl<const C: usize> FrameSource for ShowFrames<'_, C> {
    fn frame(&mut self, index: i32) -> Frame<'_> {
        let position = self.position(index);
        self.read(position);
        let show = self.player.show();
        let end = Position::from_samples(show.length());
        if index < 0 || self.fault.is_some() || (position > end && !show.is_loop()) {
            self.rest();
        }
        let coordinates = self.player.show().channel_count();
        Frame::Coordinates {
            q: self.q.get(..coordinates).unwrap_or_default(),
            qd: self.qd.get(..self.freedoms).unwrap_or_default(),
            qdd: self.qdd.get(..self.freedoms).unwrap_or_default(),
        }
    }
}
