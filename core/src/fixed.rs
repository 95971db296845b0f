//! Vectors of fixed capacity, made of iterators without a panic.

use heapless::Vec;

/// What fits of the items, in their order. All do: they are one for each body of a tree of at most `N`, or for each axis of
/// a joint. But `collect`, which would panic otherwise, cannot know that.
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
pub(crate) fn copy<T: Copy>(from: &[T], to: &mut [T]) {
    for (slot, item) in to.iter_mut().zip(from) {
        *slot = *item;
    }
}
