//! Compares the window with a list of all received numbers.

#![expect(
    clippy::cast_possible_truncation,
    clippy::cast_possible_wrap,
    clippy::cast_sign_loss,
    reason = "numbers are small, and cut to the 16 bits of the wire"
)]

use std::collections::BTreeSet;

use sinew_link::{Order, Window};

use crate::common::Random;

#[test]
fn the_window_knows_what_came() {
    let mut random = Random(60);
    for _ in 0..200 {
        let mut window = Window::new();
        let mut came = BTreeSet::from([-1_i64]);
        let (mut fresh, mut late, mut duplicates, mut old) = (0, 0, 0, 0);
        for _ in 0..2000 {
            let newest = came.last().copied().expect("there is one");
            let jump = if random.chance(0.02) { random.below(32_000) } else { random.below(4) };
            let number = newest
                + if random.chance(0.5) { 1 + jump as i64 } else { -(random.below(40) as i64) };
            if number < 0 {
                continue;
            }
            let expected = if number > newest {
                fresh += 1;
                Order::Fresh { missing: (number - newest - 1) as u16 }
            } else if newest - number >= 32 {
                old += 1;
                Order::Old
            } else if came.contains(&number) {
                duplicates += 1;
                Order::Duplicate
            } else {
                late += 1;
                Order::Late
            };
            assert_eq!(window.take(number as u16), expected, "{number} after {newest}");
            came.insert(number);
        }
        let counts = window.counts();
        let counted = (counts.fresh, counts.late, counts.duplicates, counts.old);
        assert_eq!(counted, (fresh, late, duplicates, old));
        let newest = came.last().copied().expect("there is one");
        assert_eq!(i64::from(counts.lost + fresh + late), newest + 1);
    }
}
