//! Serial ports with a controller.

use std::path::{Path, PathBuf};
use std::time::Duration;

use sinew_servo_tools::{Client, Protocol, SerialLine, ServiceError, Settings, anyone, usb_ports};

use crate::{Board, ClientError, SerialBoard, nonce};

/// Baud rates of boards, bit/s, in the order in which they are tried. USB ports and pseudo-terminals ignore the rate.
pub const BAUDS: [u32; 2] = [1_000_000, 115_200];

/// Longest wait for the answer of a controller, at each rate.
const PATIENCE: Duration = Duration::from_millis(1500);
/// Longest wait until a controller has lowered the rig of an ended program. By default, it takes 20 s: 2 s until the
/// link counts as lost, and 18 s of lowering. This program has locked the port, so no other program of this machine
/// drives the rig.
pub const TAKE_OVER: Duration = Duration::from_secs(30);
/// Time for a controller to answer on a port that probably has servos.
const GLANCE: Duration = Duration::from_millis(400);
/// Time for a servo to answer at each rate.
const SERVO_PATIENCE: Duration = Duration::from_millis(40);

/// Opens a port, and a session with its controller. If the program that drove the rig has ended before the rig is limp,
/// calls `waits`, and waits until the controller has lowered the rig.
///
/// # Errors
/// [`ClientError::Port`] if the port cannot be opened, or another program has it; [`ClientError::Servos`] if servos
/// answer there; [`ClientError::NoController`], [`ClientError::Misfit`].
pub fn open(path: &Path, waits: &dyn Fn()) -> Result<Board<SerialBoard>, ClientError> {
    let (board, is_busy) = open_any(path)?;
    take_over(board, is_busy, waits)
}

/// Opens a port like [`open`], but does not wait. Returns the board, and whether its rig belongs to another program, as
/// [`Board::connect_any`] does.
///
/// # Errors
/// As in [`open`].
pub fn open_any(path: &Path) -> Result<(Board<SerialBoard>, bool), ClientError> {
    match greet(path, PATIENCE) {
        Err(ClientError::NoController) => match servos(path)? {
            Some((protocol, baud)) => {
                Err(ClientError::Servos { path: path.to_owned(), protocol, baud })
            }
            None => Err(ClientError::NoController),
        },
        greeted => greeted,
    }
}

/// Opens the only candidate that has a controller, and returns its port and the session. `None` stands for all USB
/// ports. Waits as [`open`] does if the rig is not limp yet.
///
/// # Errors
/// [`ClientError::NoneFound`] with the ports that were tried; [`ClientError::Several`] with the ports that have a
/// controller; [`ClientError::Misfit`] if the version of a controller does not fit, or another program still uses its
/// rig after 30 s.
pub fn find(
    candidates: Option<&[PathBuf]>,
    waits: &dyn Fn(),
) -> Result<(PathBuf, Board<SerialBoard>), ClientError> {
    let of_usb;
    let candidates = if let Some(candidates) = candidates {
        candidates
    } else {
        of_usb = usb_ports();
        &of_usb[..]
    };
    let mut found = Vec::new();
    let mut not = Vec::new();
    for path in candidates {
        match greet(path, PATIENCE) {
            Ok(greeted) => found.push((path.clone(), greeted)),
            Err(ClientError::Port(ServiceError::Port { what, .. })) => {
                not.push(format!("{} ({what})", path.display()));
            }
            Err(ClientError::NoController | ClientError::Line(_)) => {
                not.push(path.display().to_string());
            }
            Err(error) => return Err(error),
        }
    }
    if found.len() > 1 {
        let names: Vec<_> = found.iter().map(|(path, _)| path.display().to_string()).collect();
        return Err(ClientError::Several(names.join(", ")));
    }
    let none = || match not.as_slice() {
        [] => "any USB port: there is none".to_owned(),
        not => not.join(", "),
    };
    let (path, (board, is_busy)) = found.pop().ok_or_else(|| ClientError::NoneFound(none()))?;
    Ok((path, take_over(board, is_busy, waits)?))
}

fn take_over(
    mut board: Board<SerialBoard>,
    is_busy: bool,
    waits: &dyn Fn(),
) -> Result<Board<SerialBoard>, ClientError> {
    if is_busy {
        waits();
        board.reconnect(TAKE_OVER)?;
    }
    Ok(board)
}

/// Returns `true` if a controller answers at a port, also one that refuses a session. Programs that look for servos
/// then leave this port out.
pub fn has_controller(path: &Path) -> bool {
    matches!(greet(path, GLANCE), Ok(_) | Err(ClientError::Misfit(_)))
}

fn greet(path: &Path, patience: Duration) -> Result<(Board<SerialBoard>, bool), ClientError> {
    let mut greeted = Err(ClientError::NoController);
    for baud in BAUDS {
        let line = SerialBoard::open(path, baud)?;
        greeted = Board::connect_any(line, nonce(), patience);
        if !matches!(greeted, Err(ClientError::NoController)) {
            break;
        }
    }
    greeted
}

/// Returns the protocol and the baud rate of the servos at a port; `None` if none answers.
fn servos(path: &Path) -> Result<Option<(Protocol, u32)>, ClientError> {
    let settings = Settings { patience: SERVO_PATIENCE, tries: 1 };
    let line = SerialLine::open(path)?;
    let [baud, ..] = Protocol::Dynamixel.bauds();
    let mut client = Client::new(line, Protocol::Dynamixel, baud, settings)?;
    Ok(anyone(&mut client)?)
}
