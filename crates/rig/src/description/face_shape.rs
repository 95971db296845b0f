//! Shapes of a face: poses of joints under the names that programs for faces use.

/// A shape of a face: positions of joints when the shape has weight 1. With weight 0 the joints are at home.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct FaceShape {
    /// Name of the shape, such as `jawOpen` or `aa`; unique among shapes.
    pub name: String,
    /// Joints with one axis, and their positions, rad or m. Empty: the rig cannot show the shape.
    pub pose: Vec<(String, f64)>,
}
