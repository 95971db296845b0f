//! The surface area that each vertex of a mesh represents.

use super::mesh::Mesh;

/// The rule for the area of a vertex, from the triangles around it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum VertexArea {
    /// One third of the sum of the triangles' areas. The total over all vertices is the surface.
    #[default]
    Surface,
    /// The mean of the triangles' areas. Its total is not the surface (about half of it if six triangles meet at
    /// each vertex), but the list in D. Holden, "Joint Error Propagation" (2025), was made with it.
    Article,
}

impl Mesh {
    /// Returns whether any triangle has an area that is representable in f32.
    pub fn has_surface(&self) -> bool {
        self.triangle_areas_m2().iter().any(|area_m2| *area_m2 >= f64::from(f32::MIN_POSITIVE))
    }

    /// Returns the area of every triangle, in m².
    pub fn triangle_areas_m2(&self) -> Vec<f64> {
        let area_m2 = |triangle: &[usize; 3]| {
            let [a, b, c] = triangle.map(|vertex| self.positions_m[vertex]);
            0.5 * (b - a).cross(c - a).length()
        };
        self.triangles.iter().map(area_m2).collect()
    }

    /// Returns the area that every vertex represents, in m²; 0 for a vertex without triangles.
    pub fn vertex_areas_m2(&self, rule: VertexArea) -> Vec<f64> {
        let mut sums_m2 = vec![0.0; self.positions_m.len()];
        let mut counts = vec![0_u32; self.positions_m.len()];
        for (triangle, area_m2) in self.triangles.iter().zip(self.triangle_areas_m2()) {
            for vertex in *triangle {
                sums_m2[vertex] += area_m2;
                counts[vertex] += 1;
            }
        }
        let share = |(sum_m2, count): (f64, u32)| match rule {
            VertexArea::Surface => sum_m2 / 3.0,
            VertexArea::Article => sum_m2 / f64::from(count.max(1)),
        };
        sums_m2.into_iter().zip(counts).map(share).collect()
    }
}
