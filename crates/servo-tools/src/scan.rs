//! Searches for servos on a line: all baud rates, all ids.

use std::ops::RangeInclusive;
use std::time::Duration;

use sinew_servo_bus::feetech::Family;
use sinew_servo_bus::{dynamixel, feetech};

use crate::client::packet;
use crate::left::{self, Left};
use crate::ping_reply::{Miss, Pong};
use crate::reply::{ReceivedReply, Reply};
use crate::{Client, Exchange, Protocol, ServiceError, Servo};

/// The range of a search.
#[derive(Debug, Clone, PartialEq)]
pub struct ScanSettings {
    /// Protocols to try.
    pub protocols: Vec<Protocol>,
    /// Baud rates to try; if empty, all rates of each protocol.
    pub bauds: Vec<u32>,
    /// Ids to try.
    pub ids: RangeInclusive<u8>,
    /// Whether to ask every id at every rate, even if nothing answers a common ping.
    pub thorough: bool,
}

impl Default for ScanSettings {
    fn default() -> Self {
        Self { protocols: Protocol::ALL.to_vec(), bauds: Vec::new(), ids: 0..=252, thorough: false }
    }
}

/// A servo that was found.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Found {
    /// Id of the servo.
    pub id: u8,
    /// Protocol of the servo.
    pub protocol: Protocol,
    /// Baud rate at which the servo answers, bits per second.
    pub baud: u32,
    /// The maker's name for the model; `None` if the model number is unknown.
    pub model: Option<&'static str>,
    /// Model number that the servo reports.
    pub model_number: u16,
    /// Firmware version.
    pub firmware: String,
}

/// An event during a scan.
#[derive(Debug, Clone, Copy)]
pub enum ScanEvent<'a> {
    /// The scan of a baud rate begins.
    Rate(Protocol, u32),
    /// The line does not support a baud rate.
    NoRate(u32, &'a ServiceError),
    /// A servo was found.
    Found(&'a Found),
    /// A servo was found that a program left in the middle of its work.
    Left(u8, &'a Left),
    /// The answer of an id is not a packet: two servos have this id.
    Collision(Protocol, u32, u8),
    /// Bytes arrived that are not a packet, but no id answers.
    Noise(Protocol, u32),
}

/// Wait for the answers to a common ping: the client of ROBOTIS gives each id 3 ms (`dynamixel-sdk` 4.1.0).
const ALL_ANSWER: Duration = Duration::from_millis(3 * 253);
/// Wait for the answers of Feetech servos to a common ping: they answer at the same time, or in a time slot each.
const FEETECH_ANSWER: Duration = Duration::from_millis(260);
/// Number of attempts to reach an id that is asked alone.
const TRIES: u32 = 2;

/// Scans all rates. At each rate, all servos are asked together. Each id is then asked alone if
/// [`ScanSettings::thorough`] is set, if damaged bytes arrived from Dynamixels, or if a Feetech answered, because its
/// common answer does not contain its model.
///
/// # Errors
/// An error if the line failed; [`ServiceError::Stopped`] after a signal. A rate that the line does not support is not
/// an error: `tell` receives an event.
pub fn scan<E: Exchange>(
    client: &mut Client<E>,
    settings: &ScanSettings,
    tell: &mut dyn FnMut(ScanEvent<'_>),
) -> Result<Vec<Found>, ServiceError> {
    let mut found = Vec::new();
    for protocol in &settings.protocols {
        client.set_protocol(*protocol);
        let all = protocol.bauds();
        let bauds = if settings.bauds.is_empty() { &all[..] } else { &settings.bauds[..] };
        for baud in bauds {
            match client.set_baud(*baud) {
                Ok(()) => tell(ScanEvent::Rate(*protocol, *baud)),
                Err(error @ ServiceError::Baud { .. }) => {
                    tell(ScanEvent::NoRate(*baud, &error));
                    continue;
                }
                Err(error) => return Err(error),
            }
            let here = scan_rate(client, settings, tell)?;
            for servo in here.iter().filter(|servo| servo.model.is_some()) {
                let left = client.open(servo.id, None).and_then(|servo| left::look(client, &servo));
                if let Ok(Some(left)) = left {
                    tell(ScanEvent::Left(servo.id, &left));
                }
            }
            found.extend(here);
        }
    }
    Ok(found)
}

fn scan_rate<E: Exchange>(
    client: &mut Client<E>,
    settings: &ScanSettings,
    tell: &mut dyn FnMut(ScanEvent<'_>),
) -> Result<Vec<Found>, ServiceError> {
    let (protocol, baud) = (client.protocol(), client.baud());
    let heard = ask_all(client)?;
    let mut found = Vec::new();
    let mut add = |tell: &mut dyn FnMut(ScanEvent<'_>), id: u8, pong: Pong| {
        let model = pong.table.map(|table| table.model());
        let Pong { number: model_number, firmware, .. } = pong;
        let servo = Found { id, protocol, baud, model, model_number, firmware };
        tell(ScanEvent::Found(&servo));
        found.push(servo);
    };
    let mut answered = Vec::new();
    // The answer of a Feetech does not contain its model.
    if protocol == Protocol::Dynamixel {
        for reply in heard.replies.iter().filter(|reply| settings.ids.contains(&reply.id)) {
            if let Some(pong) = Pong::of_dynamixel(reply).filter(|_| !answered.contains(&reply.id))
            {
                answered.push(reply.id);
                add(tell, reply.id, pong);
            }
        }
    }
    let is_empty = heard.replies.is_empty() && !heard.is_noisy;
    let ask_each = match protocol {
        _ if settings.thorough => true,
        Protocol::Dynamixel => heard.is_noisy,
        Protocol::Feetech => !is_empty,
    };
    if !ask_each {
        return Ok(found);
    }
    let mut collides = false;
    for id in settings.ids.clone().filter(|id| !answered.contains(id)) {
        match client.ping(id, TRIES)? {
            Ok(pong) => add(tell, id, pong),
            Err(Miss::Noise) => {
                collides = true;
                tell(ScanEvent::Collision(protocol, baud, id));
            }
            Err(Miss::Silence) => {}
        }
    }
    if heard.is_noisy && found.is_empty() && !collides {
        tell(ScanEvent::Noise(protocol, baud));
    }
    Ok(found)
}

/// Asks all servos at the present rate together.
fn ask_all<E: Exchange>(client: &mut Client<E>) -> Result<ReceivedReply, ServiceError> {
    let (request, time) = to_all(client.protocol())?;
    let patience = client.patience();
    client.ask(&request, 0, time + patience, |_| false)
}

/// Asks all servos together, and returns their answers.
pub(crate) fn answer_together<E: Exchange>(
    client: &mut Client<E>,
) -> Result<Vec<Reply>, ServiceError> {
    Ok(ask_all(client)?.replies)
}

/// Searches for any servo: returns protocol and rate at which something answers a common ping within the client's
/// patience. The answer may come from several servos that disturb each other.
///
/// # Errors
/// An error if the line failed; [`ServiceError::Stopped`] after a signal.
pub fn anyone<E: Exchange>(
    client: &mut Client<E>,
) -> Result<Option<(Protocol, u32)>, ServiceError> {
    for protocol in Protocol::ALL {
        client.set_protocol(protocol);
        for baud in protocol.bauds() {
            match client.set_baud(baud) {
                Ok(()) => {}
                Err(ServiceError::Baud { .. }) => continue,
                Err(error) => return Err(error),
            }
            let (request, _) = to_all(protocol)?;
            let heard =
                client.ask(&request, 0, client.patience(), |replies| !replies.is_empty())?;
            if !heard.replies.is_empty() {
                return Ok(Some((protocol, baud)));
            }
        }
    }
    Ok(None)
}

/// Returns a common ping to all servos, and the time for all answers.
fn to_all(protocol: Protocol) -> Result<(Vec<u8>, Duration), ServiceError> {
    Ok(match protocol {
        Protocol::Dynamixel => {
            let ping = dynamixel::Instruction::Ping;
            (packet(|out| ping.encode(dynamixel::BROADCAST, out))?, ALL_ANSWER)
        }
        Protocol::Feetech => {
            let ping = feetech::Instruction::Ping;
            (packet(|out| ping.encode(Family::Sts, feetech::BROADCAST, out))?, FEETECH_ANSWER)
        }
    })
}

/// Searches for one servo at all rates of the protocols, or at the rate `baud`, and stays at the rate where it answers.
///
/// # Errors
/// [`ServiceError::Nowhere`], or [`ServiceError::Silent`] if only one protocol and one rate are tried;
/// [`ServiceError::Noise`] if the answer is not a packet; [`ServiceError::Baud`] if the line does not support the only
/// rate; the errors of [`Client::open`].
pub fn find<E: Exchange>(
    client: &mut Client<E>,
    id: u8,
    protocols: &[Protocol],
    baud: Option<u32>,
    model: Option<&str>,
) -> Result<Servo, ServiceError> {
    let mut is_noisy = false;
    for protocol in protocols {
        client.set_protocol(*protocol);
        let all = protocol.bauds();
        let bauds = baud.as_ref().map_or(&all[..], std::slice::from_ref);
        for baud in bauds {
            match client.set_baud(*baud) {
                Ok(()) => {}
                // If all rates are tried, the servo cannot be at a rate that the adapter does not support.
                Err(ServiceError::Baud { .. }) if bauds.len() > 1 => continue,
                Err(error) => return Err(error),
            }
            // If there are many rates, a rate is tried again only after a damaged answer.
            let tries = if bauds.len() > 1 { 1 } else { TRIES };
            match client.ping(id, tries)? {
                Ok(_) => return client.open(id, model),
                Err(Miss::Noise) if client.ping(id, TRIES)?.is_ok() => {
                    return client.open(id, model);
                }
                Err(Miss::Noise) => is_noisy = true,
                Err(Miss::Silence) => {}
            }
        }
    }
    if is_noisy {
        return Err(ServiceError::Noise { id });
    }
    if let ([_], Some(baud)) = (protocols, baud) {
        return Err(ServiceError::Silent { id, baud });
    }
    let names: Vec<_> = protocols.iter().map(|protocol| protocol.name()).collect();
    Err(ServiceError::Nowhere { id, protocols: names.join(" and ") })
}
