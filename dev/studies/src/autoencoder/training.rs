//! Trains a single network.

use std::f64::consts::PI;

use candle_core::backprop::GradStore;
use candle_core::{Device, Result, Tensor};
use serde::{Deserialize, Serialize};
use sinew_host_util::random::{Random, Subject};

use super::adamw::Moments;
use super::loss::Loss;
use super::network::Network;
use super::samples::{Rows, Samples};

/// Training settings, equal for every method.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Schedule {
    /// Steps of a training.
    pub steps: usize,
    /// Poses per step. The framework spreads operations on more than 65536 numbers over its own threads, which only
    /// slow down small steps: forward kinematics of 31 joints has that many numbers with 235 poses.
    pub batch: usize,
    /// Learning rate at the beginning; it falls to zero along half a cosine.
    pub rate: f64,
    /// Decay of the parameters per unit of the rate.
    pub decay: f64,
    /// Weight of a metre of global position in the forward-kinematics loss, relative to a number of a rotation's
    /// column.
    pub position_per_m: f64,
}

impl Default for Schedule {
    fn default() -> Self {
        Self { steps: 5_000, batch: 128, rate: 1e-3, decay: 1e-3, position_per_m: 1.0 }
    }
}

/// A network, the state of its optimizer, and its step. The next step depends on nothing else: the order of the poses
/// is a function of the seed and the step.
#[derive(Debug, Clone)]
pub(super) struct Training {
    pub(super) network: Network,
    pub(super) moments: Vec<Moments>,
    pub(super) step: usize,
    seed: u64,
    /// The order of an epoch, stored so that it is not drawn again in every step.
    order: Option<(usize, Vec<u32>)>,
}

impl Training {
    pub(super) fn new(numbers: usize, latent: usize, seed: u64) -> Result<Self> {
        let network = Network::new(numbers, latent, seed)?;
        let moments = network.parameters().iter().map(|(_, value)| Moments::zero(value));
        Ok(Self { moments: moments.collect::<Result<_>>()?, network, step: 0, seed, order: None })
    }

    /// Runs one step of the training on the next batch.
    pub(super) fn advance(
        &mut self,
        samples: &Samples,
        loss: &Loss,
        schedule: &Schedule,
    ) -> Result<()> {
        let batch = self.batch(&samples.train, schedule.batch)?;
        let gradients = self.loss(samples, &batch, loss)?.backward()?;
        self.update(&gradients, schedule)
    }

    /// Returns the poses of the next step. An epoch uses all poses in its own order, except those that do not fill a
    /// batch.
    pub(super) fn batch(&mut self, rows: &Rows, batch: usize) -> Result<Rows> {
        let count = rows.len()?;
        let batch = batch.min(count);
        let batches = count / batch;
        let (epoch, place) = (self.step / batches, self.step % batches);
        let order = match self.order.take() {
            Some((of, order)) if of == epoch => order,
            _ => {
                let mut order: Vec<u32> =
                    (0..u32::try_from(count).expect("fewer than 2^32")).collect();
                Random::numbered(self.seed, epoch as u64, Subject::Batches).shuffle(&mut order);
                order
            }
        };
        let indices = Tensor::from_slice(&order[place * batch..][..batch], batch, &Device::Cpu)?;
        self.order = Some((epoch, order));
        rows.at(&indices)
    }

    /// Returns the loss of a batch for the present network.
    pub(super) fn loss(&self, samples: &Samples, batch: &Rows, loss: &Loss) -> Result<Tensor> {
        loss.mean(&self.reconstruct(samples, batch)?, batch)
    }

    /// Returns the columns that the network reconstructs for poses.
    pub(super) fn reconstruct(&self, samples: &Samples, rows: &Rows) -> Result<Tensor> {
        samples.columns(&self.network.forward(&rows.input)?)
    }

    pub(super) fn update(&mut self, gradients: &GradStore, schedule: &Schedule) -> Result<()> {
        let share = self.step as f64 / schedule.steps as f64;
        let rate = schedule.rate * 0.5 * (1.0 + libm::cos(PI * share));
        self.step += 1;
        for ((_, value), moments) in self.network.parameters().iter().zip(&mut self.moments) {
            moments.update(value, gradients, self.step, rate, schedule.decay)?;
        }
        Ok(())
    }
}
