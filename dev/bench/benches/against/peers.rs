//! Compares the core's kernels with those of libraries in other languages, in one run: first whether all results
//! agree, then the time of each.

use std::error::Error;
use std::ffi::OsStr;

use sinew_core::Tree;

use crate::interleaved::{Median, in_turns};
use crate::motion::RigMotion;
use crate::ours::Ours;
use crate::peer::{Kernel, Peer};
use crate::{BODIES, TOLERANCE, apart, options};

/// Largest allowed ratio of each kernel's time to that of Pinocchio in double precision.
const BOUNDS: [(Kernel, f64); 3] = [(Kernel::Rnea, 0.2), (Kernel::Aba, 0.5), (Kernel::Crba, 0.5)];
/// The peer to which the bounds refer.
const BOUND_BY: &str = "Pinocchio, double";

/// Prints a table of all kernels with a column for each peer; `programs` has the format of PATH.
pub(crate) fn compare(tree: &Tree<BODIES>, programs: &OsStr) -> Result<(), Box<dyn Error>> {
    let mut ours = Ours::new(tree);
    let mut peers = std::env::split_paths(programs)
        .map(|program| Peer::new(&program, tree.bodies()))
        .collect::<Result<Vec<_>, _>>()?;
    let (motions, rounds, calls) = if options::quick() { (3, 20, 20) } else { (100, 501, 100) };
    for seed in 0..motions {
        let motion = RigMotion::random(tree.bodies(), seed);
        ours.set(&motion);
        for peer in &mut peers {
            peer.set(&motion)?;
            agree(&mut ours, peer)?;
        }
    }
    let dofs = tree.dof_count();
    println!(
        "\nKernels, {BODIES} bodies, {dofs} degrees of freedom: median, ns, and ours as a part of it"
    );
    println!("all find the same in {motions} motions, to {TOLERANCE:.0e} of the largest number");
    print!("{:20}{:>10}", "", "sinew");
    for peer in &peers {
        print!("{:>26}", peer.name);
    }
    println!();
    for kernel in Kernel::ALL {
        let found = in_turns(rounds, peers.len() + 1, |index| match index.checked_sub(1) {
            None => Ok(ours.time_ns(kernel, calls)),
            Some(peer) => peers[peer].time_ns(kernel, calls),
        })?;
        let (of_ours, of_peers) = found.split_first().ok_or("nobody was timed")?;
        print!("{:20}{:>10.0}", kernel.name(), of_ours.time_ns);
        for Median { time_ns, to_first } in of_peers {
            print!("{time_ns:>19.0}{:>7.2}", 1.0 / to_first);
        }
        println!();
        let bound = BOUNDS.iter().find(|(of, _)| *of == kernel);
        let by = peers.iter().position(|peer| peer.name == BOUND_BY);
        if let (Some((_, bound)), Some(by)) = (bound, by) {
            let met = if 1.0 / of_peers[by].to_first <= *bound { "met" } else { "MISSED" };
            println!("{:20}at most {bound} of {BOUND_BY}: {met}", "");
        }
    }
    Ok(())
}

/// Checks that a peer has the same results.
fn agree(ours: &mut Ours, peer: &mut Peer) -> Result<(), Box<dyn Error>> {
    for kernel in Kernel::ALL {
        let (expected, found) = (ours.found(kernel), peer.found(kernel)?);
        // Moment and force of a root, and angular and linear acceleration, are compared separately, each relative to
        // its own size.
        let parts =
            if matches!(kernel, Kernel::Rnea | Kernel::Aba) { vec![0, 3, 6] } else { vec![0] };
        // Accelerations have larger errors: they are computed from rounded wrenches.
        let tolerance = if kernel == Kernel::Aba { 100.0 * TOLERANCE } else { TOLERANCE };
        for (index, start) in parts.iter().enumerate() {
            let end = parts.get(index + 1).copied().unwrap_or(expected.len());
            let of =
                |numbers: &[f64]| numbers.get(*start..end.min(numbers.len())).map(<[_]>::to_vec);
            let off = match (of(&expected), of(&found)) {
                (Some(a), Some(b)) if expected.len() == found.len() => apart(&a, &b),
                _ => f64::INFINITY,
            };
            if off > tolerance {
                let (name, kernel) = (&peer.name, kernel.name());
                return Err(format!(
                    "{kernel}: {name} is off by {off:.1e}, more than {tolerance:.0e}"
                )
                .into());
            }
        }
    }
    Ok(())
}
