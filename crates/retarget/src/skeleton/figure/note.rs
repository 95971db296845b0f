//! Confidence of a proposal.

/// Confidence of one body of a proposal.
#[derive(Debug, Clone, PartialEq)]
pub struct Note {
    /// Name of the body.
    pub body: String,
    /// Confidence of the least certain landmark of the body, 0 to 1.
    pub confidence: f64,
    /// Reason why the confidence is not higher.
    pub reason: String,
    /// Decisions beyond the landmarks: a split spine, or an end that is not in the file.
    pub remarks: Vec<String>,
}
