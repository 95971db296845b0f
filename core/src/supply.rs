//! A limit of the sum of all torques, for rigs whose drives share a power supply.

use core::fmt;

use glam::Vec3;
use heapless::Vec;

use crate::control::{LimitReason, Limited};
use crate::fixed;
use crate::joint::JointKind;
use crate::math;
use crate::transform::Wrench;
use crate::tree::Tree;

/// A bound on the sum of all joints' torques, and the rule for sharing it.
///
/// The caller applies it after the tick. The sum is over the lengths of the joints' moments: a servo's current is
/// proportional to its torque, and the supply delivers the sum of the currents. Forces of prismatic joints have other
/// units, and no servo drives a free joint: both are neither counted nor reduced.
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
/// // A missing newton metre costs three times as much at the shoulder as at the elbow.
/// let by_weight = TorqueSupply::new(&arm, 4.0)?.with_weights(&[3.0, 1.0])?;
/// let mut torques = wanted.map(|value| Limited { value, reason: None });
/// by_weight.share(&mut torques);
/// // The elbow gives up all of its 2 N m, and the shoulder the rest.
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
    /// Share of each joint in the total reduction: one over its weight; zero if the joint draws nothing from the
    /// supply.
    yields: Vec<f32, N>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
enum Rule {
    /// All torques are reduced by the same factor.
    Uniform,
    /// The weighted sum of squared reductions is minimal.
    LeastSquares,
}

/// Range of weights, in which quotients of two weights, and of torques and weights, stay within f32.
const WEIGHTS: core::ops::RangeInclusive<f32> = 1e-12..=1e12;

impl<const N: usize> TorqueSupply<N> {
    /// Creates a supply of `supply_nm`, N m; infinite for no bound. All torques are reduced by the same factor.
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

    /// Sets the rule that minimises `Σ aᵢ |τᵢ - τ_wanted,i|²` with the weights `aᵢ`: joint i gives up torque in
    /// proportion to `1 / aᵢ`, until it has none left. O(n), up to O(n²) if joints run out of torque.
    ///
    /// # Errors
    /// [`SupplyError`] if the number of weights is not the number of joints, or a weight is not from 1e-12 to 1e12
    /// (also for a joint that draws nothing from the supply).
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

    /// Returns the maximum sum of all joints' torques, N m.
    pub fn supply_nm(&self) -> f32 {
        self.supply_nm
    }

    /// Returns the number of joints of the rig.
    pub(crate) fn joint_count(&self) -> usize {
        self.yields.len()
    }

    /// Returns `true` if [`Self::with_weights`] was called.
    pub(crate) fn has_weights(&self) -> bool {
        self.rule == Rule::LeastSquares
    }

    /// Reduces the torques of a tick to the supply. Moments keep their directions; reduced torques get
    /// [`LimitReason::Supply`]. If the supply suffices, no bit changes. The resulting sum exceeds the supply at
    /// most by rounding.
    ///
    /// A torque that is not finite becomes zero, with [`LimitReason::NotFinite`]. Torques beyond the tree's joints
    /// become zero, with [`LimitReason::NoRoom`].
    pub fn share(&self, torques: &mut [Limited<Wrench>]) {
        let (torques, beyond) = torques.split_at_mut(torques.len().min(self.yields.len()));
        beyond.fill(Limited { value: Wrench::ZERO, reason: Some(LimitReason::NoRoom) });
        let mut largest = 0.0_f32;
        for (torque, yields) in torques.iter_mut().zip(&self.yields) {
            if !torque.value.is_finite() {
                // Checked before any comparison, because NaN passes a clamp.
                *torque = Limited { value: Wrench::ZERO, reason: Some(LimitReason::NotFinite) };
            }
            if *yields > 0.0 {
                largest = largest.max(torque.value.moment_nm.abs().max_element());
            }
        }
        if largest <= 0.0 {
            return;
        }
        // Scaled by the largest component, so that no square and no sum overflows.
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
    /// Reduces torques like [`Self::share`], but only the part that accelerates the rig: the part beyond the bias
    /// wrench ([`TorqueController::bias_wrenches`](crate::TorqueController::bias_wrenches)). All joints get the same
    /// factor, whatever the weights: `τ = τ_bias + s (τ_wanted - τ_bias)`.
    ///
    /// Wrenches that do not draw from the supply (of a free root, and forces) get the same factor, so every joint
    /// gets the same share of its commanded acceleration. The sum of torques is convex in s. The function uses the
    /// s at which the straight line from the sum at s = 0 to the sum at s = 1 reaches the supply. The true sum is
    /// never above this line: the supply is not exceeded, no search is needed, and a little of the supply stays
    /// unused. If the bias wrenches alone exceed the supply, all torques are reduced as in [`Self::share`].
    ///
    /// Bias wrenches that are missing or not finite count as zero.
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
        // If all torques are zero, the sums are NaN; the condition is then false, and nothing is reduced.
        if sum > supply && sum_bias < supply {
            let s = (supply - sum_bias) / (sum - sum_bias);
            for (joint, torque) in torques.iter_mut().enumerate() {
                let value = mixed(finite_or_zero(bias.get(joint)), torque.value, s);
                if torque.value.is_finite() && value != torque.value {
                    *torque = Limited { value, reason: Some(LimitReason::Supply) };
                }
            }
        }
        // This handles torques that are not finite, bias wrenches that exceed the supply, and a sum above the
        // supply due to rounding.
        self.share(torques);
    }

    fn draws(&self, joint: usize) -> bool {
        self.yields.get(joint).is_some_and(|yields| *yields > 0.0)
    }

    /// Returns the moments that draw from the supply, each with its bias.
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

/// Returns `a + t (b - a)`: exactly `b` if both are equal, or `t` is 1.
fn mixed(a: Wrench, b: Wrench, t: f32) -> Wrench {
    let mixed = |a: Vec3, b: Vec3| b - (b - a) * (1.0 - t);
    Wrench { moment_nm: mixed(a.moment_nm, b.moment_nm), force_n: mixed(a.force_n, b.force_n) }
}

/// Subtracts from each torque the same multiple of its joint's yield, which reduces the sum to the supply.
fn cut(torques: &mut [Limited<Wrench>], wanted: &[f32], yields: &[f32], supply: f32) {
    let joints = || wanted.iter().zip(yields);
    let mut share = 0.0;
    // Each pass excludes the joints that lose all their torque at the last share. The remaining joints then give up
    // more, and no excluded joint returns.
    for _ in wanted {
        let (mut sum, mut yielding) = (0.0, 0.0);
        for (wanted, yields) in joints().filter(|(wanted, yields)| share * **yields < **wanted) {
            sum += wanted;
            yielding += yields;
        }
        let next = (sum - supply).max(0.0) / yielding;
        // Written so that NaN, when no joint remains, stops the loop.
        if next > share {
            share = next;
        } else {
            break;
        }
    }
    let left = |wanted: f32, yields: f32| (wanted - share * yields).max(0.0);
    // The remainders of large torques have too few digits for a small supply, so their sum is corrected by a
    // factor.
    let sum: f32 = joints().map(|(wanted, yields)| left(*wanted, *yields)).sum();
    let rounding = if sum > supply { supply / sum } else { 1.0 };
    for (torque, (wanted, yields)) in torques.iter_mut().zip(joints()) {
        if share * yields > 0.0 && *wanted > 0.0 {
            torque.value.moment_nm *= left(*wanted, *yields) / wanted * rounding;
            torque.reason = Some(LimitReason::Supply);
        }
    }
}

/// An error in a supply.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum SupplyError {
    /// The supply is NaN or negative.
    Supply {
        /// Supply, N m.
        nm: f32,
    },
    /// The number of weights is not the number of joints.
    Count {
        /// Number of joints.
        expected: usize,
        /// Number of weights.
        found: usize,
    },
    /// The weight of a joint is not from 1e-12 to 1e12.
    Weight {
        /// Index of the joint.
        joint: usize,
        /// Weight of the joint.
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
