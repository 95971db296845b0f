//! The handshake. These messages keep their form in all versions.

use core::fmt;

use serde::{Deserialize, Serialize};

/// Version of the messages.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Version {
    /// Major version: different major versions are incompatible.
    pub major: u8,
    /// Minor version: a higher minor version has more messages.
    pub minor: u8,
}

impl Version {
    /// Version of this crate.
    pub const CURRENT: Self = Self { major: 1, minor: 3 };

    /// Returns the minor version that a controller of this version and a host of version `host` both support, or
    /// the reason why there is none.
    ///
    /// # Errors
    /// [`Misfit::Version`] if the major versions differ.
    ///
    /// ```
    /// # use sinew_link::message::Version;
    /// let controller = Version { major: 1, minor: 2 };
    /// assert_eq!(controller.fit(Version { major: 1, minor: 5 }), Ok(2));
    /// let misfit = controller.fit(Version { major: 2, minor: 0 }).unwrap_err();
    /// assert!(misfit.to_string().ends_with("the controller 1.2: flash a newer firmware, or use an older program"));
    /// ```
    pub fn fit(self, host: Self) -> Result<u8, Misfit> {
        if self.major == host.major {
            Ok(self.minor.min(host.minor))
        } else {
            Err(Misfit::Version { controller: self, host })
        }
    }
}

impl fmt::Display for Version {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}.{}", self.major, self.minor)
    }
}

/// The first message of a host.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Hello {
    /// Version of the host's messages.
    pub protocol: Version,
    /// Any number, new for each session. A repeated number continues the same session.
    pub nonce: u32,
}

/// The answer to a [`Hello`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Welcome {
    /// Nonce of the greeting.
    pub nonce: u32,
    /// Number for all commands and streams of the host from now on; 0, which no session has, if there is no session.
    pub session: u16,
    /// Description of the controller.
    pub about: About,
    /// Minor version that both ends support, or the reason that there is no session.
    pub verdict: Result<u8, Misfit>,
}

/// Description of a controller.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct About {
    /// Version of the controller's messages.
    pub protocol: Version,
    /// Version of the controller's firmware.
    pub firmware: Release,
    /// CRC at the end of the rig's compact form; 0 without a rig.
    pub rig: u32,
    /// Capacities of the board.
    pub capacities: Capacities,
}

/// Version of a firmware.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Release {
    /// Major version.
    pub major: u8,
    /// Minor version.
    pub minor: u8,
    /// Patch version.
    pub patch: u8,
}

impl fmt::Display for Release {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}.{}.{}", self.major, self.minor, self.patch)
    }
}

/// Capacities of a board.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Capacities {
    /// Maximum number of a rig's bodies.
    pub bodies: u16,
    /// Maximum number of a pose's coordinates.
    pub coordinates: u16,
    /// Maximum number of a rig's dofs.
    pub dofs: u16,
    /// Maximum number of a rig's servos.
    pub servos: u16,
    /// Number of slots for shows.
    pub slots: u8,
    /// Maximum length of a show, in bytes.
    pub slot_bytes: u32,
}

/// A reason for which there is no session.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Misfit {
    /// The major versions differ.
    Version {
        /// Version of the controller.
        controller: Version,
        /// Version of the host.
        host: Version,
    },
    /// Another host uses the rig.
    Busy,
}

impl fmt::Display for Misfit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Version { controller, host } => {
                let what = if host.major > controller.major {
                    "flash a newer firmware, or use an older program"
                } else {
                    "use a newer program, or flash an older firmware"
                };
                write!(
                    f,
                    "the program speaks version {host} of the link, the controller {controller}: {what}"
                )
            }
            Self::Busy => f.write_str("another program has the rig: end it, or disarm"),
        }
    }
}

impl core::error::Error for Misfit {}
