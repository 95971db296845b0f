//! Who is on a line: all rates, all ids.

use std::ops::RangeInclusive;
use std::time::Duration;

use sinew_servo_bus::feetech::Family;
use sinew_servo_bus::{dynamixel, feetech};

use crate::client::packet;
use crate::left::{self, Left};
use crate::ping_reply::{Miss, Pong};
use crate::reply::{ReceivedReply, Reply};
use crate::{Client, Exchange, Protocol, ServiceError, Servo};

/// Where to look.
#[derive(Debug, Clone, PartialEq)]
pub struct ScanSettings {
    /// Which protocols.
    pub protocols: Vec<Protocol>,
    /// Which rates; all of each protocol where empty.
    pub bauds: Vec<u32>,
    /// Which ids.
    pub ids: RangeInclusive<u8>,
    /// Ask every id at every rate, also where nothing answers a question to all.
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
    /// Its id.
    pub id: u8,
    /// Its protocol.
    pub protocol: Protocol,
    /// At what rate it answers, bits per second.
    pub baud: u32,
    /// The maker's name of its model; none if it is not in the list.
    pub model: Option<&'static str>,
    /// What it says that it is.
    pub model_number: u16,
    /// Its firmware.
    pub firmware: String,
}

/// What happens during a scan.
#[derive(Debug, Clone, Copy)]
pub enum ScanEvent<'a> {
    /// A rate begins.
    Rate(Protocol, u32),
    /// The line does not do a rate.
    NoRate(u32, &'a ServiceError),
    /// A servo was found.
    Found(&'a Found),
    /// A servo that was found is as a program left it that was ended.
    Left(u8, &'a Left),
    /// An id answers with what is no packet: two servos of one id.
    Collision(Protocol, u32, u8),
    /// Something was heard that is no packet, and no id answers.
    Noise(Protocol, u32),
}

/// The client of ROBOTIS gives each id 3 ms to answer a ping to all: `dynamixel-sdk` 4.1.0.
const ALL_ANSWER: Duration = Duration::from_millis(3 * 253);
/// Feetech servos answer a ping to all at once, or each in a time of its own.
const FEETECH_ANSWER: Duration = Duration::from_millis(260);
/// Ids are asked as often, where not all is as it should be.
const TRIES: u32 = 2;

/// Looks at all rates. At each all are asked together, and where that brings anything but a servo's answer, each id by
/// itself.
///
/// # Errors
/// If the line is gone. A rate that the line does not do is told to `tell`.
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
    // A Feetech's answer does not say what it is.
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

/// Asks all servos of a rate together.
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

/// Whether any servo is there: in which protocol and at what rate something answers a question to all, within the time
/// of a client's patience. It may be of servos that stand in each other's way.
///
/// # Errors
/// If the line is gone.
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

/// A question to all servos, and how long all answers take.
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

/// Looks for one servo at all rates of the protocols, or at those that are told, and stays where it answers.
///
/// # Errors
/// [`ServiceError::Nowhere`], and [`ServiceError::Noise`] if something answers with what is no packet.
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
                // Where all rates are tried, one that the adapter does not do is none of the servo's.
                Err(ServiceError::Baud { .. }) if bauds.len() > 1 => continue,
                Err(error) => return Err(error),
            }
            // Of many rates each is tried once more only where something was heard.
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
