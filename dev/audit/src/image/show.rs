//! Shows: decoded from arbitrary bytes, used as the tracker's frames, and begun with a blend.

use core::hint::black_box;

use sinew_core::JointKind;
use sinew_core::tracker::FrameSource;
use sinew_show::{Blend, Joint, Player, Position, Show, ShowFrames, State};

use super::{N, slice, slice_mut};

#[inline(never)]
pub(crate) fn decoder() {
    let Ok(show) = Show::open(slice()) else { return };
    let show = black_box(show);
    black_box((&show.check_blocks(), &show.check_rig(black_box(1))));
    black_box(&show.check_joints(slice::<JointKind>().iter().copied()));
    black_box((show.channel_count(), show.dof_count(), show.rig(), show.is_loop()));
    black_box((show.length(), show.duration_s(), show.block_count(), show.largest_error()));
    black_box(show.time_code().map(|code| (code.is_time(), code.after(black_box(1)))));
    black_box((show.time_code_at(black_box(1)), show.course().count()));
    black_box((show.rate().hz(), show.position_at_us(black_box(1)).sample()));
    let (from, to) = (Position::from_samples(black_box(1)), Position::from_samples(black_box(2)));
    for cue in show.cues().chain(show.cues_between(from, to)) {
        black_box(cue.name);
    }
    for joint in show.joints() {
        black_box((joint.code(), joint.turns_freely(), Joint::of_code(black_box(1))));
    }
    let Ok(player) = Player::<N>::new(show) else { return };
    let mut player = black_box(player);
    let position = show.pace(black_box(0.01)).position(black_box(1));
    black_box(&player.state_at(position, slice_mut(), slice_mut(), slice_mut()));
}

#[inline(never)]
pub(crate) fn frames() {
    let Ok(show) = Show::open(slice()) else { return };
    let Ok(frames) = ShowFrames::<N>::new(black_box(show), black_box(0.01)) else { return };
    let mut frames = black_box(frames);
    black_box(&frames.frame(black_box(1)));
    black_box((frames.position(black_box(1)), &frames.fault(), frames.show()));
}

#[inline(never)]
pub(crate) fn blend() {
    let Ok(show) = Show::open(slice()) else { return };
    let state = || State { q: slice(), qd: slice(), qdd: slice() };
    let Ok(blend) = Blend::<N>::new(black_box(show), state(), state(), black_box(1.0)) else {
        return;
    };
    let blend = black_box(blend);
    blend.state_at(black_box(0.5), slice_mut(), slice_mut(), slice_mut());
    black_box(blend.duration_s());
}
