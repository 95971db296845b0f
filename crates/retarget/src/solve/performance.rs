//! A clip with its performer, frame by frame.

use sinew_mocap::{Clip, JointSample};

use crate::performer::{Performer, PerformerFrame};

/// A clip that is converted to performer frames on demand, because these are larger than the clip's frames.
pub(super) struct Performance<'a> {
    pub(super) performer: &'a Performer,
    pub(super) clip: &'a Clip,
}

impl Performance<'_> {
    /// Returns all frames in turn.
    pub(super) fn frames(&self) -> impl Iterator<Item = PerformerFrame> {
        self.frames_of(0..self.clip.frames.len())
    }

    /// Returns the frames with these indices.
    pub(super) fn frames_of(
        &self,
        indices: impl Iterator<Item = usize>,
    ) -> impl Iterator<Item = PerformerFrame> {
        let mut world: Vec<JointSample> = Vec::with_capacity(self.performer.joint_count());
        indices.map(move |index| self.performer.frame(&self.clip.frames[index], &mut world))
    }
}
