//! Linear drives.

use heapless::Vec;
use sinew_core::math;

use super::error::DriveError;
use super::numbers::{
    DRIVE_CAPACITY, LARGEST, LEAST_MOTION, MATRIX_CAPACITY, Numbers, bounded, collect, dot,
};
use super::pseudo_inverse::pseudo_inverse;

/// Maximum accepted condition number. Above it, the servos move the joints a hundred times more in one direction
/// than in another, which no real transmission does. Below it, positions keep five of the seven digits of f32, far
/// more than an encoder of 4096 steps has.
const CONDITION_MOST: f32 = 100.0;

/// A linear drive `q = G s + offset`: one row for each dof, one column for each servo, of full rank.
///
/// One servo on one joint is `[[1]]`, two that face each other on one joint are `[[0.5, -0.5]]`, a mimic joint is
/// `[[1], [0.5]]`, a differential pair is `[[0.5, 0.5], [0.5, -0.5]]`.
///
/// The inverse is the pseudo-inverse of the matrix whose rows are scaled to length 1, so that it does not depend on
/// units. The condition number of that matrix (its largest singular value over its smallest) must be at most 100.
#[derive(Debug, Clone, PartialEq)]
pub struct Matrix {
    servos: usize,
    /// Elements of `G`, row after row.
    rows: Vec<f32, MATRIX_CAPACITY>,
    /// Elements of the inverse, row after row; each row belongs to a servo.
    inverse: Vec<f32, MATRIX_CAPACITY>,
    pub(super) offset: Numbers,
    ball: bool,
}

impl Matrix {
    /// Creates a drive of joints with axes. `offset` has one number for each row (rad or m), or is empty for zeros.
    ///
    /// # Errors
    /// [`DriveError`] if the matrix is empty, too large or nearly singular, rows or `offset` have a wrong length, a
    /// number is not finite or above 1e6 in absolute value, or a dof has no servo that moves it, or a servo no dof.
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

    /// Creates a drive of a ball joint, whose rotation vector is `G s + offset`.
    ///
    /// # Errors
    /// Those of [`Self::new`], and [`DriveError::Ball`] unless there are three rows and at least three columns.
    pub fn of_ball(rows: &[impl AsRef<[f32]>], offset: &[f32]) -> Result<Self, DriveError> {
        let matrix = Self::new(rows, offset)?;
        let (dofs, servos) = (matrix.dofs(), matrix.servos);
        if dofs != 3 || servos < 3 {
            return Err(DriveError::Ball { dofs, servos });
        }
        Ok(Self { ball: true, ..matrix })
    }

    /// Returns the number of dofs.
    pub fn dofs(&self) -> usize {
        self.offset.len()
    }

    /// Returns the number of servos.
    pub fn servos(&self) -> usize {
        self.servos
    }

    /// Returns whether the drive moves a ball joint.
    pub fn is_ball(&self) -> bool {
        self.ball
    }

    /// Returns the rows of `G`, one for each dof.
    pub fn rows(&self) -> impl Iterator<Item = &[f32]> {
        // The constructor has ensured at least one servo.
        self.rows.chunks_exact(self.servos.max(1))
    }

    /// Returns the offset of each row, rad or m.
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
        // NaN is not in the range either.
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
            // Divided by the largest number, so that no square underflows.
            let largest = largest(row.iter());
            let squares: f32 = row.iter().map(|x| (x / largest) * (x / largest)).sum();
            largest * math::sqrt(squares)
        }))
    }

    /// Returns `G ṡ`.
    pub(super) fn joints_of(&self, servos: &[f32]) -> Numbers {
        collect(self.rows().map(|row| dot(row, servos)))
    }

    /// Returns `G⁺ q̇`.
    pub(super) fn servos_of(&self, joints: &[f32]) -> Numbers {
        collect(self.inverse.chunks_exact(self.dofs().max(1)).map(|row| dot(row, joints)))
    }

    /// Returns `Gᵀ τ`.
    pub(super) fn torques_of(&self, efforts: &[f32]) -> Numbers {
        transposed_times(&self.rows, self.servos, efforts)
    }

    /// Returns `G⁺ᵀ τ`.
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
