//! Looks up servo kinds by the names that people use.

use sinew_rig::description::ServoModel;
use thiserror::Error;

use crate::model::{Parameters, ParametersError};
use crate::registers::RegisterTable;

/// A servo kind, with the part of it that is simulated.
#[derive(Debug, Clone, PartialEq)]
pub enum Kind {
    /// Motor, gear, temperature, firmware and registers.
    Servo(Box<Parameters>),
    /// Only registers: the rest of this kind is unknown, or not wanted.
    Registers(RegisterTable),
}

/// The reason why a kind was not found.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum KindError {
    /// No kind has a name with this beginning.
    #[error(
        "there is no servo called {found:?}; there are {with_physics}, and as registers only {registers}"
    )]
    Unknown {
        /// Name that was given.
        found: String,
        /// Kinds with physics.
        with_physics: String,
        /// Kinds with registers only.
        registers: String,
    },
    /// The kind has no bus.
    #[error("{0} is driven by pulses: it is not on a bus, and cannot be queried")]
    NoBus(String),
    /// The figures of the kind contradict each other.
    #[error(transparent)]
    Parameters(#[from] ParametersError),
}

impl Kind {
    /// Looks up a kind by name, or the first kind whose name begins like this. Ignores case and all characters except
    /// letters and digits. Kinds with physics come first, in the order of the documentation.
    ///
    /// # Errors
    /// [`KindError`] lists the known kinds.
    pub fn named(name: &str) -> Result<Self, KindError> {
        let wanted = plain(name);
        let fits = |known: &&str| !wanted.is_empty() && plain(known).starts_with(&wanted);
        if let Some(known) = ServoModel::built_in_names().find(fits) {
            if RegisterTable::of(known).is_none() {
                return Err(KindError::NoBus(known.to_owned()));
            }
            return Ok(Self::Servo(Box::new(Parameters::built_in(known)?)));
        }
        let table = RegisterTable::names().find(fits).and_then(RegisterTable::of);
        table.map(Self::Registers).ok_or_else(|| KindError::Unknown {
            found: name.to_owned(),
            with_physics: with_physics().collect::<Vec<_>>().join(", "),
            registers: registers_only().collect::<Vec<_>>().join(", "),
        })
    }

    /// Returns the maker's name of the kind.
    pub fn name(&self) -> &str {
        match self {
            Self::Servo(parameters) => &parameters.name,
            Self::Registers(table) => table.name(),
        }
    }

    /// Returns the register table of the kind, or `None` if it has none.
    pub fn registers(&self) -> Option<RegisterTable> {
        match self {
            Self::Servo(parameters) => RegisterTable::of(&parameters.name),
            Self::Registers(table) => Some(*table),
        }
    }
}

/// Returns the names of kinds with physics.
fn with_physics() -> impl Iterator<Item = &'static str> {
    ServoModel::built_in_names().filter(|name| RegisterTable::of(name).is_some())
}

/// Returns the names of kinds with registers only.
fn registers_only() -> impl Iterator<Item = &'static str> {
    let is_known = |name: &str| with_physics().any(|known| plain(known).starts_with(&plain(name)));
    RegisterTable::names().filter(move |name| !is_known(name))
}

fn plain(name: &str) -> String {
    let letters = name.chars().filter(char::is_ascii_alphanumeric);
    letters.map(|letter| letter.to_ascii_lowercase()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn people_need_not_know_the_whole_name() {
        for (name, known) in [
            ("xl330", "XL330-M288-T"),
            ("XL330-m288-t", "XL330-M288-T"),
            ("sts3215", "STS3215-7.4V"),
            ("sts3215 12v", "STS3215-12V"),
            ("mx-64", "MX-64"),
        ] {
            let kind = Kind::named(name).unwrap();
            assert!(matches!(&kind, Kind::Servo(_)) && kind.name() == known, "{name}: {kind:?}");
            assert!(kind.registers().is_some());
        }
        for (name, known) in
            [("scs0009", "SCS0009"), ("xc330", "XC330-T288"), ("XL330-M077", "XL330-M077")]
        {
            let kind = Kind::named(name).unwrap();
            assert!(
                matches!(&kind, Kind::Registers(_)) && kind.name() == known,
                "{name}: {kind:?}"
            );
        }
    }

    #[test]
    fn what_there_is_not_is_refused_with_what_there_is() {
        let message = |name| Kind::named(name).unwrap_err().to_string();
        for name in ["ax12", "", "-"] {
            let message = message(name);
            assert!(message.contains("XL330-M288-T, XL430-W250-T"), "{message}");
            assert!(message.contains("only MX-106") && message.ends_with("SCS0009"), "{message}");
            assert!(!message.contains("MG90S"), "{message}");
        }
        assert!(message("mg90s").contains("is driven by pulses"));
    }
}
