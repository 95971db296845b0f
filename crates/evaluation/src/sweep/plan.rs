//! The plan of a sweep: cells, clips, and the share of one machine.

use std::fmt;
use std::str::FromStr;

use serde::{Deserialize, Serialize};
use sha2::{Digest as _, Sha256};

use super::file::{Cell, SweepFile};
use crate::motion::{EvaluatedMotion, count_steps};

/// The plan of a sweep.
#[derive(Debug, Clone, PartialEq)]
pub struct Plan {
    /// Text of the sweep file, for the record.
    pub text: String,
    /// All cells, including those of other shards.
    pub cells: Vec<Cell>,
    /// Clips of the sweep.
    pub clips: Vec<ClipIdentity>,
    /// Duration of the part of every clip that is used, from its beginning, in seconds; `None` for whole clips.
    pub seconds: Option<f64>,
    /// Share of the cells that this machine computes.
    pub shard: Shard,
}

/// The identity of a clip, by its content.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ClipIdentity {
    /// Name of the clip.
    pub name: String,
    /// Time step of the clip in seconds.
    pub dt_s: f64,
    /// SHA-256 of the motion and its rig, the first 16 hexadecimal digits.
    pub sha256: String,
}

/// One cell on one clip.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Unit {
    /// Index of the cell.
    pub cell: usize,
    /// Index of the clip.
    pub clip: usize,
}

/// A share of the cells: every `count`-th, beginning with the `index`-th.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Shard {
    index: usize,
    count: usize,
}

impl Shard {
    /// The shard that contains all cells.
    pub const WHOLE: Self = Self { index: 1, count: 1 };

    fn has(self, cell: usize) -> bool {
        cell % self.count == self.index - 1
    }
}

impl FromStr for Shard {
    type Err = &'static str;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        const EXPECTED: &str = "expected I/N with I from 1 to N, such as 3/16";
        let (index, count) = text.split_once('/').ok_or(EXPECTED)?;
        let number = |text: &str| text.trim().parse::<usize>().map_err(|_| EXPECTED);
        let shard = Self { index: number(index)?, count: number(count)? };
        if (1..=shard.count).contains(&shard.index) { Ok(shard) } else { Err(EXPECTED) }
    }
}

impl fmt::Display for Shard {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}/{}", self.index, self.count)
    }
}

impl Plan {
    /// Creates a plan with all clips.
    pub fn new(
        file: SweepFile,
        motions: &[impl EvaluatedMotion],
        seconds: Option<f64>,
        shard: Shard,
    ) -> Self {
        let clips = motions.iter().map(ClipIdentity::of).collect();
        Self { text: file.text, cells: file.cells, clips, seconds, shard }
    }

    /// Returns the indices of this shard's cells.
    pub fn shard_cells(&self) -> impl Iterator<Item = usize> + '_ {
        (0..self.cells.len()).filter(|cell| self.shard.has(*cell))
    }

    /// Returns the units of this shard, by cell, then by clip.
    pub fn units(&self) -> impl Iterator<Item = Unit> + '_ {
        self.shard_cells()
            .flat_map(|cell| (0..self.clips.len()).map(move |clip| Unit { cell, clip }))
    }

    /// Counts the steps of the units of this shard.
    pub fn count_steps(&self, motions: &[impl EvaluatedMotion]) -> usize {
        self.units().map(|unit| count_steps(&motions[unit.clip], self.seconds)).sum()
    }

    /// Returns the SHA-256 of all setups, in hexadecimal. It does not depend on how the grids are written, only on
    /// the setups.
    pub(super) fn cells_sha256(&self) -> String {
        let mut hash = Sha256::new();
        for cell in &self.cells {
            hash.update(cell.key.as_bytes());
            hash.update([0]);
        }
        hex(hash)
    }
}

impl ClipIdentity {
    fn of(motion: &impl EvaluatedMotion) -> Self {
        let mut hash = Sha256::new();
        let mut add = |values: &[f64]| {
            for value in values {
                hash.update(value.to_le_bytes());
            }
        };
        add(&[motion.dt_s()]);
        motion.visit_numbers(&mut add);
        Self { name: motion.name().to_owned(), dt_s: motion.dt_s(), sha256: hex(hash) }
    }
}

fn hex(hash: Sha256) -> String {
    let start = hash.finalize().iter().take(8).fold(0, |value, byte| value << 8 | u64::from(*byte));
    format!("{start:016x}")
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use proptest::prelude::*;

    use super::*;

    /// Returns a grid with lists of these lengths.
    fn text(lengths: &[usize]) -> String {
        let keys = ["controller.kp", "dimensions.scale", "dimensions.trunk"];
        let line = |(key, length): (&str, &usize)| {
            let values: Vec<_> = (1..=*length).map(|value| value.to_string()).collect();
            format!("{key} = [{}]", values.join(", "))
        };
        let lines: Vec<_> = keys.into_iter().zip(lengths).map(line).collect();
        format!("[[grid]]\n{}\n", lines.join("\n"))
    }

    proptest! {
        #[test]
        fn shards_share_out_the_cells_of_any_grids_evenly(
            grids in prop::collection::vec(prop::collection::vec(1..5usize, 0..=3), 1..4),
            clips in 0..3usize,
            count in 1..9usize,
        ) {
            let file = SweepFile::parse(grids.iter().map(|grid| text(grid)).collect(), Path::new("s.toml"), None).unwrap();
            let products: usize = grids.iter().map(|grid| grid.iter().product::<usize>()).sum();
            prop_assert_eq!(file.cells.len() + file.repeated, products);
            let setups: std::collections::BTreeSet<_> = file.cells.iter().map(|cell| &cell.key).collect();
            prop_assert_eq!(setups.len(), file.cells.len());

            let clip = |clip: usize| ClipIdentity { name: clip.to_string(), dt_s: 0.01, sha256: String::new() };
            let plan = |shard| Plan {
                text: String::new(),
                cells: file.cells.clone(),
                clips: (0..clips).map(clip).collect(),
                seconds: None,
                shard,
            };
            let whole: Vec<Unit> = plan(Shard::WHOLE).units().collect();
            let shards = (1..=count).map(|index| plan(format!("{index}/{count}").parse().unwrap()));
            let (mut units, mut sizes) = (Vec::new(), Vec::new());
            for shard in shards {
                sizes.push(shard.shard_cells().count());
                units.extend(shard.units());
            }
            units.sort_unstable();
            prop_assert_eq!(units, whole);
            prop_assert!(sizes.iter().max().unwrap() - sizes.iter().min().unwrap() <= 1);
        }
    }
}
