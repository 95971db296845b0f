//! A limit of the sum of all torques: one supply feeds all drives.

use core::fmt;

use glam::Vec3;
use heapless::Vec;

use crate::control::{LimitReason, Limited};
use crate::fixed;
use crate::joint::JointKind;
use crate::math;
use crate::transform::Wrench;
use crate::tree::Tree;

/// A bound of the sum of all joints' torques, and the rule by which they share it.
///
/// It is applied after the tick, by who has such a supply. The sum is of the lengths of the joints' moments: a
/// servo's current is proportional to its torque, and the supply delivers the sum of the currents. Forces of
/// prismatic joints have other units, and no servo drives a free joint: both are neither counted nor cut.
///
/// ```
/// use sinew_core::{Body, Inertia, JointKind, Transform, Tree, Wrench, glam::Vec3};
/// use sinew_core::{control::{LimitReason, Limited}, supply::{SupplyError, TorqueSupply}};
/// # let body = |parent| Body {
/// #     parent,
/// #     joint: JointKind::Spherical,
/// #     placement: Transform::IDENTITY,
/// #     inertia: Inertia::default(),
/// #     rotor_inertia: 0.0,
/// # };
/// let arm = Tree::<2>::from_bodies(&[body(None), body(Some(0))])?;
/// let wanted = [6.0, 2.0].map(|nm| Wrench::new(Vec3::Z * nm, Vec3::ZERO));
/// let mut torques = wanted.map(|value| Limited { value, reason: None });
/// TorqueSupply::new(&arm, 4.0)?.share(&mut torques);
/// assert_eq!(torques.map(|torque| torque.value.moment_nm.z), [3.0, 1.0]);
///
/// // A newton metre too few at the shoulder counts three times what it counts at the elbow.
/// let by_weight = TorqueSupply::new(&arm, 4.0)?.with_weights(&[3.0, 1.0])?;
/// let mut torques = wanted.map(|value| Limited { value, reason: None });
/// by_weight.share(&mut torques);
/// // The elbow has no more than 2 N m to give: all of it, and the shoulder the rest.
/// assert_eq!(torques.map(|torque| torque.value.moment_nm.z), [4.0, 0.0]);
/// assert_eq!(torques[0].reason, Some(LimitReason::Supply));
/// assert_eq!(TorqueSupply::new(&arm, -1.0), Err(SupplyError::Supply { nm: -1.0 }));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct TorqueSupply<const N: usize> {
    supply_nm: f32,
    rule: Rule,
    /// By joint, its part of what all give up: one over its weight, zero if it draws nothing from the supply.
    yields: Vec<f32, N>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
enum Rule {
    /// All are cut by the same factor.
    Uniform,
    /// The weighted sum of squares of what is cut is least.
    LeastSquares,
}

/// The range of weights: quotients of any two, and of torques and weights, stay within f32.
const WEIGHTS: core::ops::RangeInclusive<f32> = 1e-12..=1e12;

impl<const N: usize> TorqueSupply<N> {
    /// A supply of `supply_nm`, infinite for no bound. All joints are cut by the same factor.
    ///
    /// # Errors
    /// [`SupplyError::Supply`] if the supply is NaN or negative.
    pub fn new(tree: &Tree<N>, supply_nm: f32) -> Result<Self, SupplyError> {
        if supply_nm.is_nan() || supply_nm < 0.0 {
            return Err(SupplyError::Supply { nm: supply_nm });
        }
        let draws = |joint| if matches!(joint, JointKind::Free) { 0.0 } else { 1.0 };
        let yields = fixed::collect(tree.bodies().iter().map(|body| draws(body.joint)));
        Ok(Self { supply_nm, rule: Rule::Uniform, yields })
    }

    /// The same supply, shared so that `Σ aᵢ |τᵢ - τ_wanted,i|²` is least for the weights `aᵢ`: joint i gives up
    /// torque in proportion to `1 / aᵢ`, until none is left. O(n), up to O(n²) if joints run out of torque.
    ///
    /// # Errors
    /// [`SupplyError`] if there is not a weight for each joint, or one is not from 1e-12 to 1e12 (also of a joint that
    /// takes nothing from the supply).
    pub fn with_weights(self, weights: &[f32]) -> Result<Self, SupplyError> {
        if weights.len() != self.yields.len() {
            let (expected, found) = (self.yields.len(), weights.len());
            return Err(SupplyError::Count { expected, found });
        }
        for (joint, weight) in weights.iter().enumerate() {
            if !WEIGHTS.contains(weight) {
                return Err(SupplyError::Weight { joint, value: *weight });
            }
        }
        let draws = self.yields.iter().map(|of_joint| *of_joint > 0.0);
        let yields = draws.zip(weights).map(|(draws, a)| if draws { 1.0 / a } else { 0.0 });
        Ok(Self { rule: Rule::LeastSquares, yields: fixed::collect(yields), ..self })
    }

    /// The most that all joints may draw together, in N m.
    pub fn supply_nm(&self) -> f32 {
        self.supply_nm
    }

    /// Number of joints of its rig.
    pub(crate) fn joint_count(&self) -> usize {
        self.yields.len()
    }

    /// Whether [`Self::with_weights`] was called.
    pub(crate) fn has_weights(&self) -> bool {
        self.rule == Rule::LeastSquares
    }

    /// Cuts the torques of a tick to the supply. Moments keep their directions; those that are cut get
    /// [`LimitReason::Supply`]. If the supply suffices, no bit changes. The sum is within the supply up to rounding.
    ///
    /// A torque that is not finite becomes zero, with [`LimitReason::NotFinite`]. So do torques beyond the tree's
    /// joints, with [`LimitReason::NoRoom`].
    pub fn share(&self, torques: &mut [Limited<Wrench>]) {
        let (torques, beyond) = torques.split_at_mut(torques.len().min(self.yields.len()));
        beyond.fill(Limited { value: Wrench::ZERO, reason: Some(LimitReason::NoRoom) });
        let mut largest = 0.0_f32;
        for (torque, yields) in torques.iter_mut().zip(&self.yields) {
            if !torque.value.is_finite() {
                // Before any comparison: NaN passes a clamp.
                *torque = Limited { value: Wrench::ZERO, reason: Some(LimitReason::NotFinite) };
            }
            if *yields > 0.0 {
                largest = largest.max(torque.value.moment_nm.abs().max_element());
            }
        }
        if largest <= 0.0 {
            return;
        }
        // In units of the largest component: no square and no sum may overflow.
        let supply = self.supply_nm / largest;
        let wanted: Vec<f32, N> =
            fixed::collect(torques.iter().zip(&self.yields).map(|(torque, yields)| {
                let length = |v: Vec3| math::length(v / largest);
                if *yields > 0.0 { length(torque.value.moment_nm) } else { 0.0 }
            }));
        if wanted.iter().sum::<f32>() <= supply {
            return;
        }
        match self.rule {
            Rule::Uniform => cut(torques, &wanted, &wanted, supply),
            Rule::LeastSquares => cut(torques, &wanted, &self.yields, supply),
        }
    }
}

impl<const N: usize> TorqueSupply<N> {
    /// Cuts as [`Self::share`] does, but only what accelerates the rig: the part of each torque beyond its bias wrench
    /// ([`TorqueController::bias_wrenches`](crate::TorqueController::bias_wrenches)), of all joints by the same factor
    /// whatever the weights: `τ = τ_bias + s (τ_wanted - τ_bias)`.
    ///
    /// Wrenches that do not draw from the supply (of a free root, and forces) are scaled alike, so every joint gets
    /// the same share of its commanded acceleration. The sum of torques is convex in s: where the straight line
    /// between its ends meets the supply, the sum does not exceed it. So there is no search, and a little of the
    /// supply is left. If the bias wrenches alone take the whole supply, all is cut as [`Self::share`] does.
    ///
    /// Bias wrenches that are not finite, or missing, count as zero.
    pub fn share_acceleration(&self, torques: &mut [Limited<Wrench>], bias: &[Wrench]) {
        let mut largest = 0.0_f32;
        for (wanted_nm, bias_nm) in self.counted(torques, bias) {
            largest = largest.max(bias_nm.abs().max(wanted_nm.abs()).max_element());
        }
        let (mut sum, mut sum_bias) = (0.0, 0.0);
        for (wanted_nm, bias_nm) in self.counted(torques, bias) {
            sum += math::length(wanted_nm / largest);
            sum_bias += math::length(bias_nm / largest);
        }
        let supply = self.supply_nm / largest;
        // Written so that NaN, of torques that are all zero, is enough.
        if sum > supply && sum_bias < supply {
            let s = (supply - sum_bias) / (sum - sum_bias);
            for (joint, torque) in torques.iter_mut().enumerate() {
                let value = mixed(finite_or_zero(bias.get(joint)), torque.value, s);
                if torque.value.is_finite() && value != torque.value {
                    *torque = Limited { value, reason: Some(LimitReason::Supply) };
                }
            }
        }
        // What is not finite, a bias that is more than the supply, and what rounding has left above the supply.
        self.share(torques);
    }

    fn draws(&self, joint: usize) -> bool {
        self.yields.get(joint).is_some_and(|yields| *yields > 0.0)
    }

    /// Moments that count: the wanted one and its bias.
    fn counted<'a>(
        &'a self,
        torques: &'a [Limited<Wrench>],
        bias: &'a [Wrench],
    ) -> impl Iterator<Item = (Vec3, Vec3)> + 'a {
        let counts = |(joint, torque): &(usize, &Limited<Wrench>)| {
            self.draws(*joint) && torque.value.is_finite()
        };
        torques.iter().enumerate().filter(counts).map(|(joint, torque)| {
            (torque.value.moment_nm, finite_or_zero(bias.get(joint)).moment_nm)
        })
    }
}

fn finite_or_zero(wrench: Option<&Wrench>) -> Wrench {
    wrench.copied().filter(|wrench| wrench.is_finite()).unwrap_or(Wrench::ZERO)
}

/// `a + t (b - a)`: `b` itself where both are the same, or `t` is 1.
fn mixed(a: Wrench, b: Wrench, t: f32) -> Wrench {
    let mixed = |a: Vec3, b: Vec3| b - (b - a) * (1.0 - t);
    Wrench { moment_nm: mixed(a.moment_nm, b.moment_nm), force_n: mixed(a.force_n, b.force_n) }
}

/// Subtracts from each torque the same multiple of what its joint yields, so that the sum is the supply's.
fn cut(torques: &mut [Limited<Wrench>], wanted: &[f32], yields: &[f32], supply: f32) {
    let joints = || wanted.iter().zip(yields);
    let mut share = 0.0;
    // Each pass leaves out the joints that the last share takes all from; so those that are left give more, and none
    // comes back.
    for _ in wanted {
        let (mut sum, mut yielding) = (0.0, 0.0);
        for (wanted, yields) in joints().filter(|(wanted, yields)| share * **yields < **wanted) {
            sum += wanted;
            yielding += yields;
        }
        let next = (sum - supply).max(0.0) / yielding;
        // Written so that NaN, of no joint left, stops.
        if next > share {
            share = next;
        } else {
            break;
        }
    }
    let left = |wanted: f32, yields: f32| (wanted - share * yields).max(0.0);
    // What is left of large torques has lost the digits that a small supply is counted in.
    let sum: f32 = joints().map(|(wanted, yields)| left(*wanted, *yields)).sum();
    let rounding = if sum > supply { supply / sum } else { 1.0 };
    for (torque, (wanted, yields)) in torques.iter_mut().zip(joints()) {
        if share * yields > 0.0 && *wanted > 0.0 {
            torque.value.moment_nm *= left(*wanted, *yields) / wanted * rounding;
            torque.reason = Some(LimitReason::Supply);
        }
    }
}

/// Why a supply was refused.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum SupplyError {
    /// The supply is NaN or negative.
    Supply {
        /// The supply in N m.
        nm: f32,
    },
    /// There must be one weight for each joint.
    Count {
        /// Number of joints.
        expected: usize,
        /// Number of weights.
        found: usize,
    },
    /// The weight of a joint is not from 1e-12 to 1e12.
    Weight {
        /// The joint.
        joint: usize,
        /// The weight.
        value: f32,
    },
}

impl fmt::Display for SupplyError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Supply { nm } => write!(f, "the supply is {nm} N m; it must be zero or more"),
            Self::Count { expected, found } => {
                write!(f, "{expected} joints need as many weights, {found} were given")
            }
            Self::Weight { joint, value } => write!(
                f,
                "joint {joint}: the weight of its torque is {value}; it must be from 1e-12 to 1e12"
            ),
        }
    }
}

impl core::error::Error for SupplyError {}
