//! Dynamics of a mechanism for rows of coordinates, in f32, the core's precision.

use std::ops::Range;

use numpy::PyReadonlyArray2;
use sinew_core::coordinates::CoordinatesError;
use sinew_core::{JointStates, Tree, TreeError};
use sinew_rig::Mechanism;
use sinew_rig::mechanism::{BODY_COUNT_MAX, InverseDynamics, LANES};

use crate::arrays::{SingleRows, single};

/// Dynamics of a rig, and the buffers that they need.
#[derive(Debug)]
pub(crate) struct Dynamics {
    inverse: InverseDynamics,
    tree: SizedTree,
}

/// Positions, speeds and accelerations of consecutive rows, in groups of [`LANES`] rows that are computed at once. The
/// last group is filled up with its last row.
#[derive(Debug, Default)]
pub(crate) struct Piece {
    rows: Range<usize>,
    /// Numbers of each group, by coordinate.
    groups: Vec<[Vec<[f32; LANES]>; 3]>,
}

impl Piece {
    /// Number of rows that are copied at once: few enough for the processor's nearest caches.
    pub(crate) const ROWS: usize = 16 * LANES;

    /// Copies rows of positions, speeds and accelerations.
    pub(crate) fn fill(&mut self, motion: [&PyReadonlyArray2<'_, f64>; 3], rows: Range<usize>) {
        self.groups.resize_with(rows.len().div_ceil(LANES), Default::default);
        for (kind, array) in motion.into_iter().enumerate() {
            let array = array.as_array();
            for (group, first) in self.groups.iter_mut().zip(rows.clone().step_by(LANES)) {
                let lanes = &mut group[kind];
                lanes.resize(array.ncols(), [0.0; LANES]);
                for lane in 0..LANES {
                    let row = array.row((first + lane).min(rows.end - 1));
                    for (of_lanes, number) in lanes.iter_mut().zip(row) {
                        of_lanes[lane] = single(*number);
                    }
                }
            }
        }
        self.rows = rows;
    }
}

/// Tree of the core. Its capacity is near the number of bodies, because the core's use of the stack grows with the
/// capacity.
#[derive(Debug)]
enum SizedTree {
    Small(Box<Tree<16>>),
    Medium(Box<Tree<40>>),
    Large(Box<Tree<BODY_COUNT_MAX>>),
}

/// Evaluates an expression with a tree of any capacity.
macro_rules! sized {
    ($tree:expr, $name:ident => $body:expr) => {
        match $tree {
            SizedTree::Small($name) => $body,
            SizedTree::Medium($name) => $body,
            SizedTree::Large($name) => $body,
        }
    };
}

/// Error in a row of a batch.
#[derive(Debug)]
pub(crate) struct RowError {
    row: usize,
    is_single: bool,
    source: CoordinatesError,
}

impl std::fmt::Display for RowError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        if !self.is_single {
            write!(f, "row {}: ", self.row)?;
        }
        self.source.fmt(f)
    }
}

impl Dynamics {
    pub(crate) fn of(mechanism: &Mechanism) -> Result<Self, TreeError> {
        let tree = match mechanism.bodies.len() {
            0..=16 => SizedTree::Small(Box::new(mechanism.tree()?)),
            17..=40 => SizedTree::Medium(Box::new(mechanism.tree()?)),
            _ => SizedTree::Large(Box::new(mechanism.tree()?)),
        };
        Ok(Self { inverse: InverseDynamics::of(mechanism)?, tree })
    }

    /// Returns the number of dofs.
    pub(crate) fn dof_count(&self) -> usize {
        sized!(&self.tree, tree => tree.dof_count())
    }

    /// Refuses positions that are invalid for the core. `count`: number of rows in the batch.
    pub(crate) fn check(&self, q: &[f32], (row, count): (usize, usize)) -> Result<(), RowError> {
        let checked = sized!(&self.tree, tree => {
            JointStates::rest(tree).set_coordinates_at_rest(tree, q)
        });
        checked.map_err(|source| RowError { row, is_single: count == 1, source })
    }

    /// Appends the efforts of rows to `out`. The results are identical to those of single rows. `count`: number of rows
    /// in the batch.
    pub(crate) fn efforts(
        &mut self,
        piece: &Piece,
        count: usize,
        out: &mut Vec<f64>,
    ) -> Result<(), RowError> {
        for (group, first) in piece.groups.iter().zip(piece.rows.clone().step_by(LANES)) {
            let [q, qd, qdd] = group;
            let Ok(efforts) = self.inverse.efforts_side_by_side(q, qd, qdd) else {
                return self.find_error(group, (first, count));
            };
            for lane in 0..LANES.min(piece.rows.end - first) {
                out.extend(efforts.iter().map(|lanes| f64::from(lanes[lane])));
            }
        }
        Ok(())
    }

    /// Returns the error of the first row of a group that has an error.
    fn find_error(
        &mut self,
        group: &[Vec<[f32; LANES]>; 3],
        (first, count): (usize, usize),
    ) -> Result<(), RowError> {
        for lane in 0..LANES {
            let of_lane = |lanes: &Vec<[f32; LANES]>| lanes.iter().map(|of| of[lane]).collect();
            let [q, qd, qdd]: [Vec<f32>; 3] = group.each_ref().map(of_lane);
            self.row_efforts([&q, &qd, &qdd], (first + lane, count))?;
        }
        Ok(())
    }

    /// Returns the efforts of a row.
    pub(crate) fn row_efforts(
        &mut self,
        [q, qd, qdd]: [&[f32]; 3],
        (row, count): (usize, usize),
    ) -> Result<&[f32], RowError> {
        let efforts = self.inverse.efforts(q, qd, qdd);
        efforts.map_err(|source| RowError { row, is_single: count == 1, source })
    }

    /// Appends the accelerations that the efforts of a row cause.
    pub(crate) fn accelerations(
        &self,
        [q, qd, tau]: [&SingleRows; 3],
        (row, count): (usize, usize),
        out: &mut Vec<f64>,
    ) -> Result<(), RowError> {
        let mut qdd = vec![0.0; self.dof_count()];
        let computed = sized!(&self.tree, tree => {
            tree.forward_dynamics(q.row(row), qd.row(row), tau.row(row), &mut qdd)
        });
        computed.map_err(|source| RowError { row, is_single: count == 1, source })?;
        out.extend(qdd.into_iter().map(f64::from));
        Ok(())
    }

    /// Appends the mass matrix at the coordinates of a row.
    pub(crate) fn mass_matrix(
        &self,
        q: &SingleRows,
        (row, count): (usize, usize),
        out: &mut Vec<f64>,
    ) -> Result<(), RowError> {
        let nv = self.dof_count();
        let mut matrix = vec![0.0; nv * nv];
        let computed = sized!(&self.tree, tree => tree.mass_matrix(q.row(row), &mut matrix));
        computed.map_err(|source| RowError { row, is_single: count == 1, source })?;
        out.extend(matrix.into_iter().map(f64::from));
        Ok(())
    }
}
