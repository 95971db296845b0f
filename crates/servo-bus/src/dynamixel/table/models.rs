//! The properties that differ between models.

use crate::table::is_kind_of;

/// A servo model.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Model {
    /// The maker's name for this model, such as `XL330-M288`.
    pub name: &'static str,
    /// Model number, at address 0.
    pub number: u16,
    /// Family, which decides the layout of the table.
    pub family: Family,
    /// Unit and limit of current; `None` if the model measures only load.
    pub current: Option<Current>,
    /// Minimum and maximum supply, 0.1 V: the factory's settings, which are also the allowed bounds.
    pub voltage_limits: [u8; 2],
    /// Factory temperature limit, degC.
    pub temperature_limit: u8,
    /// Factory velocity limit, in 0.229 rev/min.
    pub velocity_limit: u16,
    /// Factory shutdown mask.
    pub shutdown: u8,
    /// Factory position P gain.
    pub position_p: u16,
}

impl Model {
    /// Looks up a model by a servo kind as named in rig files, such as `XL330-M288-T`. Returns `None` if no model has
    /// this name.
    pub fn of_kind(kind: &str) -> Option<&'static Self> {
        MODELS.iter().find(|model| is_kind_of(model.name, kind))
    }
}

/// A family of models with the same table.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Family {
    /// XL330, XC330: 20 indirect addresses, and a PWM slope.
    X330,
    /// XL430, XC430, XM430, XH430: 56 indirect addresses.
    X430,
    /// XM540, XH540: they have external ports.
    X540,
    /// MX servos with protocol 2.0.
    Mx,
}

/// Unit and limit of a model's current.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Current {
    /// Current of one count, A.
    pub unit_a: f32,
    /// Factory limit, which is also the highest, in counts.
    pub limit: u16,
}

/// All models that this crate knows. Source: the page of each model in the e-manual.
pub const MODELS: &[Model] = &[
    Model {
        name: "MX-28",
        number: 30,
        family: Family::Mx,
        current: None,
        voltage_limits: [95, 160],
        temperature_limit: 80,
        velocity_limit: 380,
        shutdown: 52,
        position_p: 850,
    },
    Model {
        name: "MX-64",
        number: 311,
        family: Family::Mx,
        current: Some(Current { unit_a: 0.00336, limit: 1941 }),
        voltage_limits: [95, 160],
        temperature_limit: 80,
        velocity_limit: 435,
        shutdown: 52,
        position_p: 850,
    },
    Model {
        name: "MX-106",
        number: 321,
        family: Family::Mx,
        current: Some(Current { unit_a: 0.00336, limit: 2047 }),
        voltage_limits: [95, 160],
        temperature_limit: 80,
        velocity_limit: 360,
        shutdown: 52,
        position_p: 850,
    },
    Model {
        name: "XM430-W350",
        number: 1020,
        family: Family::X430,
        current: Some(Current { unit_a: 0.00269, limit: 1193 }),
        voltage_limits: [95, 160],
        temperature_limit: 80,
        velocity_limit: 350,
        shutdown: 52,
        position_p: 800,
    },
    Model {
        name: "XM430-W210",
        number: 1030,
        family: Family::X430,
        current: Some(Current { unit_a: 0.00269, limit: 1193 }),
        voltage_limits: [95, 160],
        temperature_limit: 80,
        velocity_limit: 330,
        shutdown: 52,
        position_p: 800,
    },
    Model {
        name: "XL430-W250",
        number: 1060,
        family: Family::X430,
        current: None,
        voltage_limits: [60, 140],
        temperature_limit: 72,
        velocity_limit: 265,
        shutdown: 52,
        position_p: 640,
    },
    Model {
        name: "XC430-W150",
        number: 1070,
        family: Family::X430,
        current: None,
        voltage_limits: [60, 160],
        temperature_limit: 80,
        velocity_limit: 460,
        shutdown: 52,
        position_p: 460,
    },
    Model {
        name: "XH540-W270",
        number: 1100,
        family: Family::X540,
        current: Some(Current { unit_a: 0.00269, limit: 2047 }),
        voltage_limits: [95, 160],
        temperature_limit: 80,
        velocity_limit: 167,
        shutdown: 52,
        position_p: 800,
    },
    Model {
        name: "XM540-W270",
        number: 1120,
        family: Family::X540,
        current: Some(Current { unit_a: 0.00269, limit: 2047 }),
        voltage_limits: [95, 160],
        temperature_limit: 80,
        velocity_limit: 128,
        shutdown: 52,
        position_p: 800,
    },
    Model {
        name: "XL330-M077",
        number: 1190,
        family: Family::X330,
        current: Some(Current { unit_a: 0.001, limit: 1750 }),
        voltage_limits: [31, 70],
        temperature_limit: 70,
        velocity_limit: 1620,
        shutdown: 53,
        position_p: 400,
    },
    Model {
        name: "XL330-M288",
        number: 1200,
        family: Family::X330,
        current: Some(Current { unit_a: 0.001, limit: 1750 }),
        voltage_limits: [31, 70],
        temperature_limit: 70,
        velocity_limit: 445,
        shutdown: 53,
        position_p: 400,
    },
    Model {
        name: "XC330-T288",
        number: 1220,
        family: Family::X330,
        current: Some(Current { unit_a: 0.001, limit: 910 }),
        voltage_limits: [55, 140],
        temperature_limit: 70,
        velocity_limit: 320,
        shutdown: 52,
        position_p: 900,
    },
    Model {
        name: "XC330-M288",
        number: 1240,
        family: Family::X330,
        current: Some(Current { unit_a: 0.001, limit: 2352 }),
        voltage_limits: [31, 70],
        temperature_limit: 70,
        velocity_limit: 350,
        shutdown: 52,
        position_p: 1100,
    },
];
