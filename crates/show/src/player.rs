//! Plays a show.

use crate::channel::{Channel, Checked};
use crate::chart::Coordinates;
use crate::error::ShowError;
use crate::position::Position;
use crate::show::Show;

/// A player for a show of up to `COORDS` channels. It can start at any position. Playing forwards costs less than a
/// jump.
///
/// It stores about 100 bytes for each channel.
#[derive(Debug, Clone)]
pub struct Player<'a, const COORDS: usize> {
    show: Show<'a>,
    channels: [Channel; COORDS],
    checked: Checked,
}

impl<'a, const COORDS: usize> Player<'a, COORDS> {
    /// Creates a player for a show.
    ///
    /// # Errors
    /// [`ShowError::Capacity`] if the show has more than `COORDS` channels.
    pub fn new(show: Show<'a>) -> Result<Self, ShowError> {
        let found = show.channel_count();
        if found > COORDS {
            return Err(ShowError::Capacity { found, holds: COORDS });
        }
        Ok(Self { show, channels: [Channel::default(); COORDS], checked: Checked::NONE })
    }

    /// Returns the show.
    pub fn show(&self) -> &Show<'a> {
        &self.show
    }

    /// Writes the rig's coordinates at a position, with the exact derivatives of the same curve: `q` of nq numbers,
    /// `qd` and `qdd` of nv, as defined in [`coordinates`](sinew_core::coordinates). Numbers that do not fit are left
    /// out.
    ///
    /// After its end, a looped show starts its next round; any other show stays at its last pose, with the speed that
    /// it has there. A given position always gives the same bits, independent of earlier requests. From tick to tick
    /// O(channels); a jump to another position costs O(block).
    ///
    /// # Errors
    /// [`ShowError::Block`] or [`ShowError::Broken`] if a block for this position is damaged. Nothing is written then.
    pub fn state_at(
        &mut self,
        position: Position,
        q: &mut [f32],
        qd: &mut [f32],
        qdd: &mut [f32],
    ) -> Result<(), ShowError> {
        let position = self.show.within(position);
        let rate = self.show.rate().hz();
        let squared = rate * rate;
        for (index, channel) in self.channels.iter_mut().enumerate().take(self.show.channel_count())
        {
            channel.seek(&self.show, index, position, &mut self.checked)?;
        }
        let mut to = Coordinates::new(q, qd, qdd);
        let mut channels = self.channels.iter();
        for joint in self.show.joints() {
            to.put(joint, || {
                let [p, v, a] =
                    channels.next().map(|channel| channel.at(position)).unwrap_or_default();
                [p, v * rate, a * squared]
            });
        }
        Ok(())
    }
}
