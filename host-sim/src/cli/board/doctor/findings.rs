//! Findings of the doctor, one line each.

/// The verdict of a finding.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Verdict {
    Ok,
    Doubtful,
    Wrong,
}

/// The lines of a report.
#[derive(Debug, Default)]
pub(super) struct Findings {
    pub(super) lines: String,
    pub(super) is_wrong: bool,
}

impl Findings {
    /// Adds a line. `todo` is the remedy; it is printed unless the verdict is ok.
    pub(super) fn add(&mut self, verdict: Verdict, what: &str, found: &str, todo: &str) {
        let word = match verdict {
            Verdict::Ok => "ok",
            Verdict::Doubtful => "doubtful",
            Verdict::Wrong => "wrong",
        };
        self.is_wrong |= verdict == Verdict::Wrong;
        self.lines.extend([format!("{word:<9} {what}: {found}\n")]);
        if verdict != Verdict::Ok && !todo.is_empty() {
            self.lines.extend([format!("          {todo}\n")]);
        }
    }

    /// Adds a line with the verdict ok if `is_well`, otherwise with the verdict `other`.
    pub(super) fn expect(
        &mut self,
        is_well: bool,
        other: Verdict,
        what: &str,
        found: &str,
        todo: &str,
    ) {
        self.add(if is_well { Verdict::Ok } else { other }, what, found, todo);
    }
}
