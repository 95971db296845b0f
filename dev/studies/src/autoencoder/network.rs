//! The auto-encoder: one encoder layer and one decoder layer.

use candle_core::{Device, Result, Tensor, Var};

use sinew_host_util::random::{Random, Subject};

/// Encoder `h = ELU(x W1 + b1)`, decoder `y = h W2 + b2`.
#[derive(Debug, Clone)]
pub(super) struct Network {
    /// Names and values, in a fixed order.
    parameters: [(&'static str, Var); 4],
}

impl Network {
    /// Creates a network. Weights are drawn uniformly from -b to b, where b is 1 divided by the square root of the
    /// number of the layer's inputs; biases are zero.
    pub(super) fn new(numbers: usize, latent: usize, seed: u64) -> Result<Self> {
        let mut random = Random::new(seed, Subject::Network);
        let mut weights = |inputs: usize, outputs: usize| {
            let bound = (inputs as f64).sqrt().recip();
            #[expect(clippy::cast_possible_truncation, reason = "rounds to the network's f32")]
            let values: Vec<f32> =
                (0..inputs * outputs).map(|_| random.between(-bound, bound) as f32).collect();
            Var::from_vec(values, (inputs, outputs), &Device::Cpu)
        };
        let bias = |outputs: usize| Var::from_vec(vec![0_f32; outputs], outputs, &Device::Cpu);
        Ok(Self {
            parameters: [
                ("encoder.weight", weights(numbers, latent)?),
                ("encoder.bias", bias(latent)?),
                ("decoder.weight", weights(latent, numbers)?),
                ("decoder.bias", bias(numbers)?),
            ],
        })
    }

    pub(super) fn parameters(&self) -> &[(&'static str, Var)] {
        &self.parameters
    }

    /// Returns the reconstruction of a batch `[poses, numbers]`.
    pub(super) fn forward(&self, input: &Tensor) -> Result<Tensor> {
        let [encoder, encoder_bias, decoder, decoder_bias] =
            self.parameters.each_ref().map(|(_, value)| value.as_tensor());
        let latent = input.matmul(encoder)?.broadcast_add(encoder_bias)?.elu(1.0)?;
        latent.matmul(decoder)?.broadcast_add(decoder_bias)
    }
}
