//! Tests of the link between a host and a controller: bytes, sessions, bad lines.

mod common;
mod decoders;
mod frames;
mod hostile;
mod line;
mod live;
mod page;
mod sender;
mod telemetry;
mod window;
