//! `AdamW` (Loshchilov and Hutter, *Decoupled Weight Decay Regularization*, 2019). Its moments can be saved, unlike
//! those of `candle-nn`.

use candle_core::backprop::GradStore;
use candle_core::{Result, Tensor, Var};

const BETA1: f64 = 0.9;
const BETA2: f64 = 0.999;
const EPSILON: f64 = 1e-8;

/// Running means of a parameter's gradient and of its square.
#[derive(Debug, Clone)]
pub(super) struct Moments {
    pub(super) first: Tensor,
    pub(super) second: Tensor,
}

impl Moments {
    pub(super) fn zero(parameter: &Var) -> Result<Self> {
        Ok(Self { first: parameter.zeros_like()?, second: parameter.zeros_like()? })
    }

    /// Moves a parameter by its gradient in step `step`, counted from 1; `decay` is the share of the parameter that
    /// is lost per unit of `rate`. A parameter without a gradient is unchanged.
    pub(super) fn update(
        &mut self,
        parameter: &Var,
        gradients: &GradStore,
        step: usize,
        rate: f64,
        decay: f64,
    ) -> Result<()> {
        let Some(gradient) = gradients.get(parameter) else { return Ok(()) };
        // A gradient keeps its computation graph; without this, the moments would keep those of all steps.
        let gradient = &gradient.detach();
        self.first = ((&self.first * BETA1)? + (gradient * (1.0 - BETA1))?)?;
        self.second = ((&self.second * BETA2)? + (gradient.sqr()? * (1.0 - BETA2))?)?;
        // Both means begin at zero: this is the correction for the first steps.
        let lack = |beta: f64| 1.0 - libm::pow(beta, step as f64);
        let scale = (self.second.affine(lack(BETA2).recip(), 0.0)?.sqrt()? + EPSILON)?;
        let change = (self.first.affine(rate / lack(BETA1), 0.0)? / scale)?;
        parameter.set(&(parameter.affine(1.0 - rate * decay, 0.0)? - change)?)
    }
}

#[cfg(test)]
mod tests {
    use candle_core::Device;
    use candle_nn::{AdamW, Optimizer as _, ParamsAdamW};

    use super::*;

    #[test]
    fn agrees_with_candles_own() {
        let start = [0.3_f32, -1.2, 2.0];
        let ours = Var::new(&start, &Device::Cpu).unwrap();
        let theirs = Var::new(&start, &Device::Cpu).unwrap();
        let params = ParamsAdamW { lr: 0.02, weight_decay: 0.1, ..ParamsAdamW::default() };
        let mut adamw = AdamW::new(vec![theirs.clone()], params).unwrap();
        let mut moments = Moments::zero(&ours).unwrap();
        let loss = |x: &Var| x.sqr().unwrap().mul(x.as_tensor()).unwrap().abs().unwrap().sum_all();
        for step in 1..=50 {
            adamw.backward_step(&loss(&theirs).unwrap()).unwrap();
            let gradients = loss(&ours).unwrap().backward().unwrap();
            moments.update(&ours, &gradients, step, 0.02, 0.1).unwrap();
        }
        let [ours, theirs] = [ours, theirs].map(|x| x.to_vec1::<f32>().unwrap());
        for (ours, theirs) in ours.iter().zip(&theirs) {
            assert!((ours - theirs).abs() < 1e-5, "{ours} {theirs}");
        }
        assert!((ours[0] - start[0]).abs() > 0.1, "it has moved");
    }
}
