//! `sinew servo` as a command.

#[cfg(unix)]
mod calibrate;
#[cfg(unix)]
mod ended;
#[cfg(unix)]
mod killed;
#[cfg(unix)]
mod on_bus;
#[cfg(unix)]
mod process;
mod refused;
#[cfg(unix)]
mod simulate;
mod tap;
