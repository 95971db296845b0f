//! The ground of a stage.

use core::f64::consts::PI;

use glam::DVec3;
use maud::{Markup, html};
use serde::Serialize;

use super::camera::Camera;
use crate::chart::line;

/// A horizontal disk with a grid, in metres.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Ground {
    /// Height of the disk.
    pub height_m: f64,
    /// Radius of the disk.
    pub radius_m: f64,
    /// Spacing of the grid, whose lines are fixed in the world.
    pub grid_m: f64,
}

impl Ground {
    /// Returns the ground for a human figure.
    pub fn at(height_m: f64) -> Self {
        Self { height_m, radius_m: 1.6, grid_m: 0.5 }
    }

    /// Returns the ground for a rig of `size_m` times a human figure, with a grid spacing of 1, 2 or 5 times a
    /// power of ten.
    pub(crate) fn of_size(height_m: f64, size_m: f64) -> Self {
        let widest_m = 0.55 * size_m;
        let power_m = libm::pow(10.0, libm::floor(libm::log10(widest_m)));
        let fits = |factor: &f64| factor * power_m <= widest_m;
        let factor = [5.0, 2.0, 1.0].into_iter().find(fits).unwrap_or(1.0);
        Self { height_m, radius_m: 1.6 * size_m, grid_m: factor * power_m }
    }

    /// Draws the ground around the camera's target.
    pub(super) fn draw(&self, camera: &Camera) -> Markup {
        let Self { height_m, radius_m, grid_m } = *self;
        let place = |point_m: DVec3| {
            let seen = camera.project(point_m);
            (seen.x, seen.y)
        };
        let center = DVec3::new(camera.target_m.x, height_m, camera.target_m.z);
        let rim = (0..48).map(|index| {
            let (sin, cos) = libm::sincos(f64::from(index) * PI / 24.0);
            place(center + DVec3::new(sin, 0.0, cos) * radius_m)
        });
        let mut lines = String::new();
        let most = libm::ceil(radius_m / grid_m + 0.5);
        let mut step = -most;
        while step <= most {
            for across in [DVec3::X, DVec3::Z] {
                let along = DVec3::new(across.z, 0.0, across.x);
                let middle = libm::round(center.dot(across) / grid_m) * grid_m + step * grid_m;
                let off = middle - center.dot(across);
                if off.abs() >= radius_m {
                    continue;
                }
                let half = libm::sqrt(radius_m * radius_m - off * off);
                let at = |way: f64| place(center + across * off + along * (half * way));
                lines += &line([at(-1.0), at(1.0)]);
            }
            step += 1.0;
        }
        html! {
            path class="ground" d={ (line(rim)) "Z" } {}
            path class="ground-line" d=(lines) {}
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_grid_is_of_round_lengths_and_right_for_its_size() {
        for (size_m, grid_m) in [(1.0, 0.5), (0.9, 0.2), (0.1, 0.05), (0.03, 0.01), (20.0, 10.0)] {
            let found_m = Ground::of_size(0.0, size_m).grid_m;
            assert!((found_m / grid_m - 1.0).abs() < 1e-9, "{size_m}: {found_m}");
        }
    }
}
