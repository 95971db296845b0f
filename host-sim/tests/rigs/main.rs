//! Users' rigs with their servos and boards, from a new file to a performance.

#[cfg(unix)]
mod board;
#[path = "../common/mod.rs"]
mod common;
#[cfg(unix)]
mod console;
mod evaluate;
mod first_rig;
#[cfg(unix)]
mod hostile;
#[cfg(unix)]
mod killed;
#[cfg(unix)]
mod other_terminals;
mod rig;
mod servo;
mod shows;
mod teach;
#[cfg(unix)]
mod watched;
