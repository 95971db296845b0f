//! Dynamics of a mechanism for rows of coordinates, in f32, the core's precision.

use sinew_core::coordinates::CoordinatesError;
use sinew_core::{JointStates, Tree, TreeError};
use sinew_rig::Mechanism;
use sinew_rig::mechanism::{BODY_COUNT_MAX, InverseDynamics, LANES};

use crate::arrays::SingleRows;

/// Dynamics of a rig, and the buffers that they need.
#[derive(Debug)]
pub(crate) struct Dynamics {
    inverse: InverseDynamics,
    tree: SizedTree,
    nq: usize,
    nv: usize,
    lanes: [Vec<[f32; LANES]>; 3],
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
        let nv = sized!(&tree, tree => tree.dof_count());
        let nq = mechanism.coordinate_count();
        let lanes = [nq, nv, nv].map(|width| vec![[0.0; LANES]; width]);
        Ok(Self { inverse: InverseDynamics::of(mechanism)?, tree, nq, nv, lanes })
    }

    /// Refuses positions that are invalid for the core. `count`: number of rows in the batch.
    pub(crate) fn check(&self, q: &[f32], (row, count): (usize, usize)) -> Result<(), RowError> {
        let checked = sized!(&self.tree, tree => {
            JointStates::rest(tree).set_coordinates_at_rest(tree, q)
        });
        checked.map_err(|source| RowError { row, is_single: count == 1, source })
    }

    /// Appends the efforts of rows to `out`. Groups of [`LANES`] rows are computed side by side; their results are
    /// identical to those of single rows.
    pub(crate) fn efforts(
        &mut self,
        [q, qd, qdd]: [&SingleRows; 3],
        (rows, count): (std::ops::Range<usize>, usize),
        out: &mut Vec<f64>,
    ) -> Result<(), RowError> {
        let mut row = rows.start;
        while row + LANES <= rows.end {
            for (of, lanes) in [q, qd, qdd].into_iter().zip(&mut self.lanes) {
                for lane in 0..LANES {
                    for (slot, number) in lanes.iter_mut().zip(of.row(row + lane)) {
                        slot[lane] = *number;
                    }
                }
            }
            let [q_lanes, qd_lanes, qdd_lanes] = &self.lanes;
            if let Ok(efforts) = self.inverse.efforts_side_by_side(q_lanes, qd_lanes, qdd_lanes) {
                for lane in 0..LANES {
                    out.extend(efforts.iter().map(|lanes| f64::from(lanes[lane])));
                }
            } else {
                // Computing single rows finds the row with the error.
                self.one_by_one([q, qd, qdd], (row..row + LANES, count), out)?;
            }
            row += LANES;
        }
        self.one_by_one([q, qd, qdd], (row..rows.end, count), out)
    }

    fn one_by_one(
        &mut self,
        [q, qd, qdd]: [&SingleRows; 3],
        (rows, count): (std::ops::Range<usize>, usize),
        out: &mut Vec<f64>,
    ) -> Result<(), RowError> {
        for row in rows {
            let efforts = self.inverse.efforts(q.row(row), qd.row(row), qdd.row(row));
            let efforts =
                efforts.map_err(|source| RowError { row, is_single: count == 1, source })?;
            out.extend(efforts.iter().copied().map(f64::from));
        }
        Ok(())
    }

    /// Appends the accelerations that the efforts of a row cause.
    pub(crate) fn accelerations(
        &self,
        [q, qd, tau]: [&SingleRows; 3],
        (row, count): (usize, usize),
        out: &mut Vec<f64>,
    ) -> Result<(), RowError> {
        let mut qdd = vec![0.0; self.nv];
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
        let mut matrix = vec![0.0; self.nv * self.nv];
        let computed = sized!(&self.tree, tree => tree.mass_matrix(q.row(row), &mut matrix));
        computed.map_err(|source| RowError { row, is_single: count == 1, source })?;
        out.extend(matrix.into_iter().map(f64::from));
        Ok(())
    }

    pub(crate) fn nq(&self) -> usize {
        self.nq
    }

    pub(crate) fn nv(&self) -> usize {
        self.nv
    }
}
