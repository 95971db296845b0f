//! Linear drives.

use heapless::Vec;
use sinew_core::math;

use super::error::DriveError;
use super::numbers::{
    DRIVE_CAPACITY, LARGEST, LEAST_MOTION, MATRIX_CAPACITY, Numbers, bounded, collect, dot,
};
use super::pseudo_inverse::pseudo_inverse;

/// The largest condition number that is accepted. What is above moves the joint a hundred times more in one direction
/// than in another: no transmission is built so. Below, positions keep five of the seven digits of f32, far more than
/// an encoder of 4096 steps has.
const CONDITION_MOST: f32 = 100.0;

/// `q = G s + offset`, a row a dof, a column a servo; of full rank.
///
/// One servo on one joint is `[[1]]`, two that face each other on one joint `[[0.5, -0.5]]`, a mimic joint
/// `[[1], [0.5]]`, a differential pair `[[0.5, 0.5], [0.5, -0.5]]`.
///
/// The inverse is the pseudo-inverse of the matrix with rows scaled to length 1, so that it does not depend on units.
/// Its condition number (the largest over the least singular value, of that matrix) must be at most 100.
#[derive(Debug, Clone, PartialEq)]
pub struct Matrix {
    servos: usize,
    /// Row after row.
    rows: Vec<f32, MATRIX_CAPACITY>,
    /// Rows of the inverse: a row a servo.
    inverse: Vec<f32, MATRIX_CAPACITY>,
    pub(super) offset: Numbers,
    ball: bool,
}

impl Matrix {
    /// A drive of joints with axes. `offset`: one number a row, or none for zeros, rad or m.
    ///
    /// # Errors
    /// [`DriveError`] if the matrix is empty, too large, ragged, singular or not of numbers.
    pub fn new(rows: &[impl AsRef<[f32]>], offset: &[f32]) -> Result<Self, DriveError> {
        let dofs = rows.len();
        let servos = rows.first().map_or(0, |row| row.as_ref().len());
        for (what, found) in [("dofs", dofs), ("servos", servos)] {
            if found == 0 {
                return Err(DriveError::TooFew { what, found, least: 1 });
            }
            if found > DRIVE_CAPACITY {
                return Err(DriveError::TooMany { what, found, most: DRIVE_CAPACITY });
            }
        }
        let found = dofs.saturating_mul(servos);
        if found > MATRIX_CAPACITY {
            return Err(DriveError::TooMany { what: "numbers", found, most: MATRIX_CAPACITY });
        }
        for (index, row) in rows.iter().enumerate() {
            length("row", index, row.as_ref().len(), servos)?;
            for (column, number) in row.as_ref().iter().enumerate() {
                bounded("number of the matrix, of column", column, *number, [-LARGEST, LARGEST])?;
            }
        }
        if !offset.is_empty() {
            length("offset", 0, offset.len(), dofs)?;
        }
        for (index, number) in offset.iter().enumerate() {
            bounded("offset", index, *number, [-LARGEST, LARGEST])?;
        }
        let rows = collect(rows.iter().flat_map(|row| row.as_ref().iter().copied()));
        let offset = collect(offset.iter().copied().chain(core::iter::repeat(0.0)).take(dofs));
        let mut matrix = Self { servos, rows, inverse: Vec::new(), offset, ball: false };
        matrix.check_motion()?;
        matrix.invert()?;
        Ok(matrix)
    }

    /// A drive of a ball joint, whose rotation vector is `G s + offset`: three rows, at least three columns.
    ///
    /// # Errors
    /// As [`Self::new`], and [`DriveError::Ball`] if it has not three rows and at least three columns.
    pub fn of_ball(rows: &[impl AsRef<[f32]>], offset: &[f32]) -> Result<Self, DriveError> {
        let matrix = Self::new(rows, offset)?;
        let (dofs, servos) = (matrix.dofs(), matrix.servos);
        if dofs != 3 || servos < 3 {
            return Err(DriveError::Ball { dofs, servos });
        }
        Ok(Self { ball: true, ..matrix })
    }

    /// How many dofs it moves.
    pub fn dofs(&self) -> usize {
        self.offset.len()
    }

    /// How many servos it has.
    pub fn servos(&self) -> usize {
        self.servos
    }

    /// Whether it moves a ball joint.
    pub fn is_ball(&self) -> bool {
        self.ball
    }

    /// The rows.
    pub fn rows(&self) -> impl Iterator<Item = &[f32]> {
        // Not zero: checked by the constructor.
        self.rows.chunks_exact(self.servos.max(1))
    }

    /// One number a row, rad or m.
    pub fn offset(&self) -> &[f32] {
        &self.offset
    }

    fn check_motion(&self) -> Result<(), DriveError> {
        for (dof, row) in self.rows().enumerate() {
            let largest = largest(row.iter());
            if largest < LEAST_MOTION {
                return Err(DriveError::Unmoved { dof, largest });
            }
        }
        for servo in 0..self.servos {
            let largest = largest(column(&self.rows, self.servos, servo));
            if largest < LEAST_MOTION {
                return Err(DriveError::Idle { servo, largest });
            }
        }
        Ok(())
    }

    fn invert(&mut self) -> Result<(), DriveError> {
        let lengths = self.row_lengths();
        let scaled: Vec<f32, MATRIX_CAPACITY> = collect(
            self.rows().zip(&lengths).flat_map(|(row, length)| row.iter().map(move |x| x / length)),
        );
        let (inverse, condition) = pseudo_inverse(&scaled, self.dofs(), self.servos);
        // NaN is not within.
        if !(0.0..=CONDITION_MOST).contains(&condition) {
            return Err(DriveError::Singular { condition, most: CONDITION_MOST });
        }
        self.inverse = collect(
            inverse.iter().zip(lengths.iter().cycle()).map(|(number, length)| number / length),
        );
        Ok(())
    }

    pub(super) fn row_lengths(&self) -> Numbers {
        collect(self.rows().map(|row| {
            // In units of the largest: no square may vanish.
            let largest = largest(row.iter());
            let squares: f32 = row.iter().map(|x| (x / largest) * (x / largest)).sum();
            largest * math::sqrt(squares)
        }))
    }

    /// `G ṡ`.
    pub(super) fn joints_of(&self, servos: &[f32]) -> Numbers {
        collect(self.rows().map(|row| dot(row, servos)))
    }

    /// `G⁺ q̇`.
    pub(super) fn servos_of(&self, joints: &[f32]) -> Numbers {
        collect(self.inverse.chunks_exact(self.dofs().max(1)).map(|row| dot(row, joints)))
    }

    /// `Gᵀ τ`.
    pub(super) fn torques_of(&self, efforts: &[f32]) -> Numbers {
        transposed_times(&self.rows, self.servos, efforts)
    }

    /// `G⁺ᵀ τ`.
    pub(super) fn efforts_of(&self, torques: &[f32]) -> Numbers {
        transposed_times(&self.inverse, self.dofs(), torques)
    }
}

fn length(
    what: &'static str,
    index: usize,
    found: usize,
    expected: usize,
) -> Result<(), DriveError> {
    if found == expected {
        Ok(())
    } else {
        Err(DriveError::Length { what, index, found, expected })
    }
}

fn column(rows: &[f32], width: usize, index: usize) -> impl Iterator<Item = &f32> {
    rows.iter().skip(index).step_by(width.max(1))
}

fn transposed_times(rows: &[f32], width: usize, factors: &[f32]) -> Numbers {
    collect(
        (0..width).map(|index| column(rows, width, index).zip(factors).map(|(a, b)| a * b).sum()),
    )
}

fn largest<'a>(numbers: impl Iterator<Item = &'a f32>) -> f32 {
    numbers.fold(0.0, |largest, number| largest.max(number.abs()))
}
