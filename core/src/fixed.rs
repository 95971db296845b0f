//! Vectors of fixed capacity, made of iterators without a panic.

use heapless::Vec;

/// The items that fit, in their order. All do: there is one for each body of a tree of at most `N`, or for each axis
/// of a joint. `collect` cannot know that, and would panic otherwise.
pub(crate) fn collect<T, const N: usize>(items: impl IntoIterator<Item = T>) -> Vec<T, N> {
    let mut all = Vec::new();
    for item in items {
        if all.push(item).is_err() {
            break;
        }
    }
    all
}

/// Copies as many items as both slices have.
///
/// Apart: in line compilers forget that the two do not overlap, and take `memmove`, which images have for nothing else.
#[inline(never)]
pub(crate) fn copy<T: Copy>(from: &[T], to: &mut [T]) {
    for (slot, item) in to.iter_mut().zip(from) {
        *slot = *item;
    }
}
