//! The force of one actuator of an MJCF, from its element and the defaults of its class.
//!
//! MuJoCo stores all kinds of actuators as `general`: `gain · control + bias`, each within its range, times the gear.
//! The defaults of every kind change these same values. An element of a certain kind then replaces gain and bias by
//! those of its kind.

use roxmltree::Node;

use super::super::error::ImportError;
use super::super::{none, xml};

/// Element names of actuators whose force is linear in their control.
pub(super) const TAGS: [&str; 7] =
    ["position", "motor", "general", "velocity", "intvelocity", "damper", "cylinder"];

/// The terms of a gain or a bias: a constant, a factor of the length (rad or m), and a factor of the speed.
type Terms = [f64; 3];

/// Values of an actuator.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct ActuatorForce {
    gear: f64,
    gain: Terms,
    /// Whether the gain depends on length and speed.
    is_gain_affine: bool,
    bias: Terms,
    has_bias: bool,
    control: Limit,
    force: Limit,
    activation: Limit,
    dynamics: Dynamics,
    /// Width of the control range as a share of the joint's range; 0 if the control range does not follow from the
    /// joint's range.
    inherited: f64,
    /// Whether the force has a form that is not linear in the control.
    is_other: bool,
}

/// A range, and the file's flag that states whether the range is a limit; `None` for `auto`.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
struct Limit {
    range: [f64; 2],
    is_limited: Option<bool>,
}

/// Dynamics between control and force.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Dynamics {
    None,
    /// The activation becomes the control after some time.
    Filter,
    /// The control changes the activation.
    Integrator,
}

impl Limit {
    /// Returns the range if it is a limit; otherwise infinite ends. It is a limit if the flag is true or, without a
    /// flag, if `auto_limits` is true and the range rises. Ends that stand for "none" are infinite, too.
    fn ends(self, auto_limits: bool) -> [f64; 2] {
        let [least, most] = self.range;
        if !self.is_limited.unwrap_or(auto_limits && least < most) {
            return [f64::NEG_INFINITY, f64::INFINITY];
        }
        let end = |end: f64| if none::is_endless(end) { end * f64::INFINITY } else { end };
        [end(least), end(most)]
    }

    fn take(&mut self, node: Node<'_, '_>, range: &str, word: &str) -> Result<(), ImportError> {
        match xml::any_numbers(node, range, 2)?.as_deref() {
            None => {}
            Some([least, most]) => self.range = [*least, *most],
            Some(_) => {
                let expected = "two numbers, the least and the most";
                return Err(xml::refuse_value(node, range, expected));
            }
        }
        self.is_limited = match node.attribute(word).map(str::trim) {
            None => self.is_limited,
            Some("auto") => None,
            Some("true") => Some(true),
            Some("false") => Some(false),
            Some(_) => return Err(xml::refuse_value(node, word, "true, false or auto")),
        };
        Ok(())
    }

    /// Refuses a range that does not rise although the flag states that it is a limit.
    fn check(self, node: Node<'_, '_>, range: &str) -> Result<(), ImportError> {
        let [least, most] = self.range;
        if self.is_limited == Some(true) && least >= most {
            return Err(xml::refuse_value(node, range, "two numbers, the least and the most"));
        }
        Ok(())
    }
}

impl ActuatorForce {
    /// Reads an actuator from its elements: defaults first, the actuator itself last.
    pub(super) fn read(nodes: &[Node<'_, '_>]) -> Result<Self, ImportError> {
        let mut force = Self {
            gear: 1.0,
            gain: [1.0, 0.0, 0.0],
            is_gain_affine: false,
            bias: [0.0; 3],
            has_bias: false,
            control: Limit::default(),
            force: Limit::default(),
            activation: Limit::default(),
            dynamics: Dynamics::None,
            inherited: 0.0,
            is_other: false,
        };
        for node in nodes {
            force.take(*node)?;
        }
        if let Some(node) = nodes.last() {
            force.control.check(*node, "ctrlrange")?;
            force.force.check(*node, "forcerange")?;
            force.activation.check(*node, "actrange")?;
        }
        Ok(force)
    }

    fn take(&mut self, node: Node<'_, '_>) -> Result<(), ImportError> {
        if let Some(gear) = xml::numbers(node, "gear", 6)? {
            self.gear = gear.first().copied().unwrap_or(1.0);
        }
        self.control.take(node, "ctrlrange", "ctrllimited")?;
        self.force.take(node, "forcerange", "forcelimited")?;
        self.activation.take(node, "actrange", "actlimited")?;
        let number = |name: &str| xml::any_number(node, name);
        match node.tag_name().name() {
            "general" => self.take_general(node)?,
            "motor" => self.set([1.0, 0.0, 0.0], None),
            "position" | "intvelocity" => {
                let kp = number("kp")?.unwrap_or(self.gain[0]);
                let damping = number("kv")?.map_or(self.bias[2], |kv| 0.0 - kv);
                self.set([kp, 0.0, 0.0], Some([self.bias[0], 0.0 - kp, damping]));
                if node.has_tag_name("intvelocity") {
                    self.dynamics = Dynamics::Integrator;
                } else if number("timeconst")?.is_some_and(|time_s| time_s > 0.0) {
                    self.dynamics = Dynamics::Filter;
                }
                self.inherited = number("inheritrange")?.unwrap_or(self.inherited);
            }
            "velocity" => {
                let kv = number("kv")?.unwrap_or(self.gain[0]);
                self.set([kv, 0.0, 0.0], Some([0.0, 0.0, 0.0 - kv]));
            }
            "damper" => {
                let kv = number("kv")?.unwrap_or(0.0);
                self.set([0.0, 0.0, 0.0 - kv], None);
                self.is_gain_affine = true;
            }
            "cylinder" => self.take_cylinder(node)?,
            _ => {}
        }
        Ok(())
    }

    fn set(&mut self, gain: Terms, bias: Option<Terms>) {
        (self.gain, self.is_gain_affine) = (gain, false);
        (self.bias, self.has_bias) = (bias.unwrap_or(self.bias), bias.is_some());
        self.dynamics = Dynamics::None;
        self.is_other = false;
    }

    fn take_general(&mut self, node: Node<'_, '_>) -> Result<(), ImportError> {
        let word = |name: &str| node.attribute(name).map(str::trim);
        match word("gaintype") {
            None => {}
            Some(kind @ ("fixed" | "affine")) => self.is_gain_affine = kind == "affine",
            Some(_) => self.is_other = true,
        }
        match word("biastype") {
            None => {}
            Some(kind @ ("none" | "affine")) => self.has_bias = kind == "affine",
            Some(_) => self.is_other = true,
        }
        match word("dyntype") {
            None => {}
            Some("none") => self.dynamics = Dynamics::None,
            Some("filter" | "filterexact") => self.dynamics = Dynamics::Filter,
            Some("integrator") => self.dynamics = Dynamics::Integrator,
            Some(_) => self.is_other = true,
        }
        for (terms, name) in [(&mut self.gain, "gainprm"), (&mut self.bias, "biasprm")] {
            let given = xml::any_numbers(node, name, 10)?.unwrap_or_default();
            terms.iter_mut().zip(given).for_each(|(term, given)| *term = given);
        }
        Ok(())
    }

    fn take_cylinder(&mut self, node: Node<'_, '_>) -> Result<(), ImportError> {
        let diameter = xml::any_number(node, "diameter")?;
        let area = xml::any_number(node, "area")?.unwrap_or(self.gain[0]);
        let area = diameter.map_or(area, |m| std::f64::consts::FRAC_PI_4 * m * m);
        let mut bias = self.bias;
        let given = xml::any_numbers(node, "bias", 3)?.unwrap_or_default();
        bias.iter_mut().zip(given).for_each(|(term, given)| *term = given);
        self.set([area, 0.0, 0.0], Some(bias));
        self.dynamics = Dynamics::Filter;
        Ok(())
    }

    /// Returns whether the force is not linear in the control, as a muscle's.
    pub(super) fn is_other(&self) -> bool {
        self.is_other
    }

    /// Returns the lowest and the highest force in the direction of the transmission, N m or N, at rest at a position
    /// of the transmission without gear, rad or m. `range`: that of the joint.
    pub(super) fn ends(
        &self,
        position: f64,
        range: Option<[f64; 2]>,
        auto_limits: bool,
    ) -> [f64; 2] {
        let length = self.gear * position;
        let gain = self.gain[0] + if self.is_gain_affine { self.gain[1] * length } else { 0.0 };
        let bias = if self.has_bias { self.bias[0] + self.bias[1] * length } else { 0.0 };
        let [least, most] = self.force.ends(auto_limits);
        let force = |control: f64| {
            // A gain of zero and an endless control are no force.
            let driven = if gain.abs() > 0.0 { gain * control } else { 0.0 };
            let joint = self.gear * (driven + bias).max(least).min(most);
            if self.gear.abs() > 0.0 { joint } else { 0.0 }
        };
        let [a, b] = self.controls(range, auto_limits).map(force);
        [a.min(b), a.max(b)]
    }

    /// Returns the ends of the control after its dynamics.
    fn controls(&self, range: Option<[f64; 2]>, auto_limits: bool) -> [f64; 2] {
        let activation = self.activation.ends(auto_limits);
        let mut control = self.control.ends(auto_limits);
        if let Some([least, most]) = range.filter(|_| self.inherited > 0.0) {
            let (middle, half) = (0.5 * (least + most), 0.5 * self.inherited * (most - least));
            control = [middle - half, middle + half];
        }
        match self.dynamics {
            Dynamics::None => control,
            Dynamics::Integrator => activation,
            Dynamics::Filter => control.map(|end| end.max(activation[0]).min(activation[1])),
        }
    }

    /// Returns the gains of a feedback as text; `None` without feedback.
    pub(super) fn gains(&self) -> Option<String> {
        let [_, on_length, on_speed] = self.bias;
        if self.has_bias && on_length.abs() > 0.0 {
            return Some(format!("kp {}, kv {}", self.gain[0], 0.0 - on_speed));
        }
        if self.has_bias && on_speed.abs() > 0.0 {
            return Some(format!("kv {}", 0.0 - on_speed));
        }
        let is_damper = self.is_gain_affine && self.gain[2].abs() > 0.0;
        is_damper.then(|| format!("kv {}", 0.0 - self.gain[2]))
    }
}
