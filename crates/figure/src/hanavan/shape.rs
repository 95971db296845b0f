//! Shapes of the model's segments. A shape gives the cross-sections; the length is separate.

use glam::DVec3;

use crate::cut::CutDisc;
use crate::solids::{self, Solid};

/// Shape of a segment. Semi-axes `a_m` are along the transverse axis, `b_m` along the sagittal one. In a pair, the
/// first number is for the end at the body's joint.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Shape {
    /// Ellipsoid of revolution about the longitudinal axis.
    Ellipsoid {
        /// Radius in metres.
        radius_m: f64,
    },
    /// Truncated circular cone.
    Cone {
        /// Radii of the two ends in metres.
        radius_m: [f64; 2],
    },
    /// Elliptical solid.
    Elliptical {
        /// Transverse semi-axes in metres.
        a_m: [f64; 2],
        /// Sagittal semi-axes in metres.
        b_m: [f64; 2],
    },
    /// Elliptical column, or a piece of one.
    Column {
        /// Transverse semi-axis of the whole column in metres.
        a_m: f64,
        /// Sagittal semi-axis of the whole column in metres.
        b_m: f64,
        /// The piece of the column that forms the segment.
        piece: Piece,
    },
}

/// A piece of an elliptical column that two sagittal planes cut.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Piece {
    /// The whole column.
    Whole,
    /// The part between the planes.
    Middle,
    /// The part on one side.
    Side,
}

impl Shape {
    /// Returns a name for tables.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Ellipsoid { .. } => "ellipsoid",
            Self::Cone { .. } => "cone",
            Self::Elliptical { .. } => "elliptical",
            Self::Column { piece: Piece::Whole, .. } => "column",
            Self::Column { piece: Piece::Middle, .. } => "column core",
            Self::Column { piece: Piece::Side, .. } => "column side",
        }
    }

    /// Returns the solid with this shape and length. x is the transverse axis, y the sagittal and z the
    /// longitudinal axis. The centre is measured along z from the end at the body's joint.
    pub fn solid(&self, length_m: f64) -> Solid {
        match *self {
            Self::Ellipsoid { radius_m } => {
                let c_m = 0.5 * length_m;
                Solid { center_z_m: c_m, ..solids::ellipsoid(radius_m, radius_m, c_m) }
            }
            Self::Cone { radius_m } => solids::truncated_cone(radius_m, length_m),
            Self::Elliptical { a_m, b_m } => solids::elliptical_solid(a_m, b_m, length_m),
            Self::Column { a_m, b_m, piece } => {
                let column = solids::elliptical_column(a_m, b_m, length_m);
                let disc = CutDisc::new();
                let [across, along] = disc.outer;
                match piece {
                    Piece::Whole => column,
                    Piece::Middle => part(column, a_m, b_m, disc.middle_share(), disc.middle),
                    Piece::Side => {
                        let about_center = [across - disc.center * disc.center, along];
                        part(column, a_m, b_m, disc.share, about_center)
                    }
                }
            }
        }
    }

    /// Returns the distance of the centre of mass from the middle of the whole column, in metres, if this is a
    /// column's side piece; otherwise zero.
    pub fn center_to_side_m(&self) -> f64 {
        match *self {
            Self::Column { a_m, piece: Piece::Side, .. } => a_m * CutDisc::new().center,
            _ => 0.0,
        }
    }
}

/// Returns the part of a column that has `share` of its area. `mean_squares` are those of the part's two
/// coordinates about its centre, on the unit disc.
fn part(column: Solid, a_m: f64, b_m: f64, share: f64, mean_squares: [f64; 2]) -> Solid {
    let (x2, y2) = (a_m * a_m * mean_squares[0], b_m * b_m * mean_squares[1]);
    let z2 = 4.0 * column.center_z_m * column.center_z_m / 12.0;
    Solid {
        volume_m3: share * column.volume_m3,
        center_z_m: column.center_z_m,
        inertia_over_mass_m2: DVec3::new(y2 + z2, x2 + z2, x2 + y2),
    }
}
