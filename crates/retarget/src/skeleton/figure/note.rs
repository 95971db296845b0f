//! How sure a proposal is.

/// How sure one body of a proposal is.
#[derive(Debug, Clone, PartialEq)]
pub struct Note {
    /// The body's name.
    pub body: String,
    /// That of the least sure landmark that it is made of.
    pub confidence: f64,
    /// Why it is no surer.
    pub reason: String,
    /// What was decided beyond the landmarks: a split spine, an end that the file does not tell.
    pub remarks: Vec<String>,
}
