//! The readers' targets, on what bolero thinks of.

#![cfg(feature = "bolero")]

#[path = "../../tests/files/readers/targets.rs"]
mod targets;

/// The target that `SINEW_TARGET` names; without a name all of them, by the first byte.
#[test]
fn readers() {
    let wanted = std::env::var("SINEW_TARGET").ok();
    bolero::check!().for_each(|bytes: &[u8]| {
        let Some((first, rest)) = bytes.split_first() else { return };
        match &wanted {
            Some(wanted) => {
                let named = targets::TARGETS.iter().find(|(name, _)| name == wanted);
                named.expect("SINEW_TARGET names a target").1(bytes);
            }
            None => targets::TARGETS[usize::from(*first) % targets::TARGETS.len()].1(rest),
        }
    });
}
