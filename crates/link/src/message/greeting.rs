//! The handshake. These messages keep their form in all versions.

use core::fmt;

use serde::{Deserialize, Serialize};

/// A version of the messages.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Version {
    /// Another one does not understand this one.
    pub major: u8,
    /// A higher one has more messages.
    pub minor: u8,
}

impl Version {
    /// Of this crate.
    pub const CURRENT: Self = Self { major: 1, minor: 2 };

    /// What a controller of this version says to a host of version `host`: the minor version that both speak, or the
    /// misfit.
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
    /// What the host speaks.
    pub protocol: Version,
    /// Any number, new for each session: with the same one the same session goes on.
    pub nonce: u32,
}

/// The answer to a [`Hello`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Welcome {
    /// The number of the greeting.
    pub nonce: u32,
    /// The number that commands and streams of the host carry from now on; 0, which no session has, if there is none.
    pub session: u16,
    /// Who answers.
    pub about: About,
    /// The minor version that both speak, or why there is no session.
    pub verdict: Result<u8, Misfit>,
}

/// Who a controller is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct About {
    /// What it speaks.
    pub protocol: Version,
    /// Version of its firmware.
    pub firmware: Release,
    /// Its rig: the CRC that the rig's compact form ends with; 0 if there is none.
    pub rig: u32,
    /// What it has room for.
    pub capacities: Capacities,
}

/// A version of a firmware.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Release {
    /// Major.
    pub major: u8,
    /// Minor.
    pub minor: u8,
    /// Patch.
    pub patch: u8,
}

impl fmt::Display for Release {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}.{}.{}", self.major, self.minor, self.patch)
    }
}

/// What a board has room for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Capacities {
    /// Bodies of a rig.
    pub bodies: u16,
    /// Numbers of its pose.
    pub coordinates: u16,
    /// Its degrees of freedom.
    pub dofs: u16,
    /// Its servos.
    pub servos: u16,
    /// Shows.
    pub slots: u8,
    /// Bytes of the longest show.
    pub slot_bytes: u32,
}

/// Why there is no session.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Misfit {
    /// They do not understand each other.
    Version {
        /// What the controller speaks.
        controller: Version,
        /// What the host speaks.
        host: Version,
    },
    /// Another program has the rig.
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
