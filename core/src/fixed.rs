//! Vectors of fixed capacity, filled from iterators without a panic.

use heapless::Vec;

/// Collects the items in their order, up to the capacity. All fit: there is one item for each body of a tree of at
/// most `N`, or for each axis of a joint. Plain `collect` would contain a panic.
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
/// Never inlined: in inlined code, the compiler no longer knows that the slices do not overlap, and calls
/// `memmove`, which board images need for nothing else.
#[inline(never)]
pub(crate) fn copy<T: Copy>(from: &[T], to: &mut [T]) {
    for (slot, item) in to.iter_mut().zip(from) {
        *slot = *item;
    }
}
