//! Checks that cost grows at most linearly with the number of bodies: time per body at each size, relative to that of
//! [`REFERENCE`] bodies. All sizes of a kernel take turns.

#[path = "common/interleaved.rs"]
mod interleaved;
#[path = "common/kernels.rs"]
mod kernels;
#[path = "common/options.rs"]
mod options;

use interleaved::{Median, medians};

/// The size to which the others are compared.
const REFERENCE: usize = 18;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let rounds = if options::quick() { 50 } else { 1000 };
    let mut order = kernels::SIZES;
    order.sort_by_key(|bodies| *bodies != REFERENCE);
    let mut sizes = Vec::new();
    for bodies in order {
        sizes.push(kernels::of_size(bodies)?.into_iter());
    }

    println!("\nmedian time per body, as a multiple of that with {REFERENCE} bodies");
    println!(
        "(1.00 is linear, as all should be but mass_matrix: bodies times depth, and a square to clear)"
    );
    print!("{:32}{:>14}", "", "ns a body");
    for bodies in kernels::SIZES {
        print!("{bodies:>8}");
    }
    println!();
    loop {
        let row: Option<Vec<_>> = sizes.iter_mut().map(Iterator::next).collect();
        let Some(mut row) = row else { return Ok(()) };
        let name = row.first().map_or("", |kernel| kernel.name);
        let mut runs: Vec<_> =
            row.iter_mut().map(|kernel| &mut *kernel.run as &mut dyn FnMut()).collect();
        let found = medians(rounds, &mut runs);
        let reference = found.first().map_or(f64::NAN, |median| median.time_ns);
        print!("{name:32}{:>14.1}", reference / REFERENCE as f64);
        for bodies in kernels::SIZES {
            let place = order.iter().zip(&found).find(|(size, _)| **size == bodies);
            let to_first = place.map_or(f64::NAN, |(_, Median { to_first, .. })| *to_first);
            print!("{:>8.2}", to_first * REFERENCE as f64 / bodies as f64);
        }
        println!();
    }
}
