//! Functions that read bytes and numbers from outside.

use core::hint::black_box;

use sinew_core::control::Limited;
use sinew_core::coordinates::nearest_turn;
use sinew_core::{JointKind, Transform, Wrench};

use super::{desired, measured, slice, slice_mut, tree};

#[inline(never)]
pub(crate) fn coordinates() {
    let joint = black_box(JointKind::Free);
    black_box(&joint.validate());
    black_box(&joint.state(black_box(Transform::IDENTITY), slice(), slice()));
    black_box((joint.dof_count(), joint.coordinate_count()));
    let tree = tree();
    black_box((tree.coordinate_count(), tree.dof_count()));
    black_box((tree.coordinates(black_box(1)), tree.dofs(black_box(1))));
    let (mut states, mut targets) = (measured(), desired());
    black_box(&states.set_coordinates(&tree, slice(), slice()));
    black_box(&states.set_coordinates_at_rest(&tree, slice()));
    black_box(&states.update_coordinates(&tree, slice(), black_box(0.01)));
    black_box(&states.coordinates(&tree, slice_mut(), slice_mut()));
    black_box(&targets.set_coordinates(&tree, slice(), slice(), slice()));
    black_box(&targets.coordinates(&tree, slice_mut(), slice_mut(), slice_mut()));
    black_box(&tree.accelerations(slice(), slice(), slice_mut()));
    black_box(&tree.efforts(slice(), slice::<Wrench>(), slice_mut()));
    black_box(&tree.efforts(slice(), slice::<Limited<Wrench>>(), slice_mut()));
    black_box(&tree.wrenches(slice(), slice(), slice_mut()));
    black_box(nearest_turn(black_box(1.0), black_box(2.0)));
}
