//! The paper's numbers, for comparison with ours: D. Notman, P. Carlisle & R. Manning, "Methods for Measuring
//! State Error for Control of Animated Human Figures" (2011), tables 1 to 4.
//!
//! The paper's motion, about 80 punches and 40 kicks of one actor, is not available: only directions and
//! approximate sizes of the normalised numbers can be compared.

use super::MethodName;

/// The paper's numbers for one method on one figure: mean angular error, mean linear error, maximum angular error,
/// maximum linear error.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Row {
    /// Errors over all joints.
    pub all: [f64; 4],
    /// Errors over the leaves.
    pub leaf: [f64; 4],
}

/// The paper's figures by scale, with the numbers of their normalised and their numerical tables.
const FIGURES: [Figure; 2] = [
    Figure {
        scale: 1.0,
        tables: [1, 3],
        normalised: [
            row([1.0, 1.0, 1.0, 1.0], [1.0, 1.0, 1.0, 1.0]),
            row([0.872, 0.880, 0.984, 0.902], [0.846, 0.818, 0.984, 0.902]),
            row([0.999, 0.856, 0.932, 1.049], [0.888, 0.866, 0.932, 1.049]),
        ],
        numerical: [
            row([1.21, 0.53, 52.91, 13.49], [1.57, 0.74, 52.91, 13.49]),
            row([1.05, 0.47, 52.09, 12.16], [1.33, 0.60, 52.09, 12.16]),
            row([1.21, 0.46, 49.30, 14.14], [1.40, 0.64, 49.30, 14.14]),
        ],
    },
    Figure {
        scale: 1.1,
        tables: [2, 4],
        normalised: [
            row([1.0, 1.0, 1.0, 1.0], [1.0, 1.0, 1.0, 1.0]),
            row([0.877, 1.002, 0.979, 0.933], [0.858, 1.006, 0.979, 0.933]),
            row([2.516, 0.786, 0.948, 0.937], [0.909, 0.798, 0.948, 0.937]),
        ],
        numerical: [
            row([1.23, 4.26, 55.31, 18.80], [1.63, 6.89, 55.31, 18.80]),
            row([1.08, 4.27, 54.16, 17.55], [1.40, 6.93, 54.16, 17.55]),
            row([3.09, 3.35, 52.43, 17.62], [1.48, 5.50, 52.43, 17.62]),
        ],
    },
];

/// A figure of the paper. Rows are in the order local, world, linear compensation.
#[derive(Debug, Clone, Copy)]
pub struct Figure {
    scale: f64,
    tables: [u8; 2],
    normalised: [Row; 3],
    numerical: [Row; 3],
}

/// The two kinds of table: normalised by the method Local, or in degrees and centimetres.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// Errors divided by those of the method Local.
    Normalised,
    /// Errors in degrees and centimetres.
    Numerical,
}

impl Kind {
    /// Returns the number of decimals to print: the paper's, or two more for the smaller errors of a user's rig.
    pub fn decimals(self, of_rig: bool) -> usize {
        match (self, of_rig) {
            (Self::Normalised, _) => 3,
            (Self::Numerical, false) => 2,
            (Self::Numerical, true) => 4,
        }
    }
}

impl Figure {
    /// Returns the paper's figure of this scale, if it has one.
    pub fn of_scale(scale: f64) -> Option<&'static Self> {
        FIGURES.iter().find(|figure| (figure.scale - scale).abs() < 1e-9)
    }

    /// Returns the number of the figure's table of this kind.
    pub fn table(&self, kind: Kind) -> u8 {
        match kind {
            Kind::Normalised => self.tables[0],
            Kind::Numerical => self.tables[1],
        }
    }

    /// Returns a row of the figure's table of this kind, if the paper has the method.
    pub fn row(&self, kind: Kind, method: MethodName) -> Option<Row> {
        let rows = match kind {
            Kind::Normalised => &self.normalised,
            Kind::Numerical => &self.numerical,
        };
        match method {
            MethodName::Local => Some(rows[0]),
            MethodName::World => Some(rows[1]),
            MethodName::LinearCompensation => Some(rows[2]),
            _ => None,
        }
    }
}

const fn row(all: [f64; 4], leaf: [f64; 4]) -> Row {
    Row { all, leaf }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Checks the tables against each other: a typing error in one table contradicts the other.
    #[test]
    fn the_two_kinds_of_table_agree_within_their_rounding() {
        for figure in &FIGURES {
            let local = figure.row(Kind::Numerical, MethodName::Local).unwrap();
            for method in MethodName::PAPER {
                let numerical = figure.row(Kind::Numerical, method).unwrap();
                let normalised = figure.row(Kind::Normalised, method).unwrap();
                for (n, r, l) in [
                    (numerical.all, normalised.all, local.all),
                    (numerical.leaf, normalised.leaf, local.leaf),
                ] {
                    for column in 0..4 {
                        // Half a unit of the last decimal of both numbers and of the ratio.
                        let slack = 0.005 / l[column] * (1.0 + r[column]) + 0.0005;
                        let difference = (n[column] / l[column] - r[column]).abs();
                        assert!(difference <= slack, "{method} {column}: {difference} {slack}");
                    }
                }
            }
        }
    }
}
