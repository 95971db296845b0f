//! Shapes of a face: poses of joints, with the names that programs for faces use.

/// A shape of a face: positions of joints at weight 1. At weight 0, these joints are at home.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct FaceShape {
    /// Name of the shape, such as `jawOpen` or `aa`; unique among shapes.
    pub name: String,
    /// Joints of one dof and their positions, rad or m. An empty pose means that the rig cannot show the shape.
    pub pose: Vec<(String, f64)>,
}
