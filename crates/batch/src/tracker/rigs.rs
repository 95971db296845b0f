//! Constants of the rigs and of their controllers.

use glam::Vec3;
use sinew_core::control::{self, TorqueLimit};
use sinew_core::state_error::{Aim, Compensation, Method};

use super::TRACKER_LANES as L;
use crate::lanes::{Numbers, OwnInertias};

/// A body with its joint in each rig.
#[derive(Debug)]
pub(super) struct Link {
    /// Place of the parent among the world, place 0, and the bodies.
    pub(super) parent: usize,
    /// Whether the joint is free; other joints are ball joints.
    pub(super) is_free: bool,
    pub(super) inertias: OwnInertias<L>,
    pub(super) gains: Gains,
    pub(super) limits: [TorqueLimit; L],
}

/// Gains of a joint in each rig.
#[derive(Debug)]
pub(super) struct Gains {
    kp: Numbers<L>,
    kd: Numbers<L>,
    linear_kp: Numbers<L>,
    linear_kd: Numbers<L>,
}

impl Gains {
    pub(super) fn new(gains: [control::Gains; L]) -> Self {
        Self {
            kp: gains.map(control::Gains::kp),
            kd: gains.map(control::Gains::kd),
            linear_kp: gains.map(control::Gains::linear_kp),
            linear_kd: gains.map(control::Gains::linear_kd),
        }
    }

    /// Returns the angular acceleration that corrects an error.
    #[inline(always)]
    pub(super) fn turn(&self, lane: usize, error_rad: Vec3, rate_rad_s: Vec3) -> Vec3 {
        error_rad * self.kp[lane] + rate_rad_s * self.kd[lane]
    }

    /// Returns the linear acceleration that corrects an error.
    #[inline(always)]
    pub(super) fn slide(&self, lane: usize, error_m: Vec3, rate_m_s: Vec3) -> Vec3 {
        error_m * self.linear_kp[lane] + rate_m_s * self.linear_kd[lane]
    }
}

/// Method of the state errors, the same for all rigs.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Errors {
    Local,
    World,
    /// Linear Compensation with full compensation (β = 1), and the child at whose goal each body aims.
    LinearCompensation {
        aims: Vec<Option<usize>>,
        settings: Compensation,
    },
}

impl Errors {
    /// Returns the method if it can be computed in lanes.
    pub(super) fn new<const N: usize>(method: &Method<N>) -> Option<Self> {
        Some(match method {
            Method::Local => Self::Local,
            Method::World => Self::World,
            #[expect(clippy::float_cmp, reason = "a setting is compared")]
            Method::LinearCompensation { aims, settings } if settings.beta == 1.0 => {
                let child = |aim: &Aim| match *aim {
                    Aim::None => Some(None),
                    Aim::Child(child) => Some(Some(child)),
                    Aim::Children(_) | Aim::Point(_) => None,
                };
                let aims = aims.as_slice().iter().map(child).collect::<Option<_>>()?;
                Self::LinearCompensation { aims, settings: *settings }
            }
            _ => return None,
        })
    }
}
