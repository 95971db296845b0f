//! What reads bytes and numbers from outside.

use core::hint::black_box;

use sinew_core::{Body, JointKind, Transform};
use sinew_firmware::show::{self, Show};

use super::{N, slice, slice_mut};

#[inline(never)]
pub(crate) fn show() {
    let Ok(show) = Show::parse(slice()) else { return };
    let show = black_box(show);
    show.frame(black_box(0), slice_mut());
    black_box((show.body_count(), show.frame_count(), show.dt_s()));
    black_box(&show.tree::<N>());
    let frames: &[&[Transform]] = slice();
    let sink = |bytes: &[u8]| black_box(if bytes.is_empty() { Err(()) } else { Ok(()) });
    black_box(&show::write(slice::<Body>(), black_box(1.0), frames.iter().copied(), sink));
}

#[inline(never)]
pub(crate) fn coordinates() {
    let joint = black_box(JointKind::Free);
    black_box(&joint.validate());
    black_box(&joint.state(black_box(Transform::IDENTITY), slice(), slice()));
    black_box((joint.degrees_of_freedom(), joint.coordinate_count()));
}
