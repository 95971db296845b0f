//! Trainings on disk: parameters, moments and step as safetensors, and whose they are.

use std::collections::HashMap;
use std::fs;
use std::path::{Path, PathBuf};

use candle_core::{Device, Tensor, safetensors};

use super::training::Training;

/// A training cannot be saved or taken up again.
#[derive(Debug, thiserror::Error)]
pub enum CheckpointError {
    /// The file cannot be written.
    #[error("{}: cannot be written: {source}", file.display())]
    Write {
        /// The file.
        file: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
    /// The file is no complete training.
    #[error("{}: {source}: expected the parameters of a training that was stopped", file.display())]
    Tensors {
        /// The file.
        file: PathBuf,
        /// What is wrong with it.
        source: candle_core::Error,
    },
    /// The training is another one.
    #[error(
        "{}: is of another training: expected {expected}, found {found}; take another folder, or delete the file",
        file.display()
    )]
    Other {
        /// The file.
        file: PathBuf,
        /// What is to be trained.
        expected: String,
        /// What was.
        found: String,
    },
}

const IDENTITY: &str = "identity";
const STEP: &str = "step";

/// Writes a training; `identity` says what it is. The file is complete or as it was before.
pub(super) fn save(
    training: &Training,
    identity: &str,
    file: &Path,
) -> Result<(), CheckpointError> {
    let failed = |source| CheckpointError::Tensors { file: file.to_path_buf(), source };
    let unwritten = |source| CheckpointError::Write { file: file.to_path_buf(), source };
    let scalars = || {
        let step = u32::try_from(training.step).map_err(candle_core::Error::wrap)?;
        let bytes = identity.as_bytes();
        Ok([
            (IDENTITY.to_owned(), Tensor::from_slice(bytes, bytes.len(), &Device::Cpu)?),
            (STEP.to_owned(), Tensor::new(&[step], &Device::Cpu)?),
        ])
    };
    let mut tensors = HashMap::from(scalars().map_err(failed)?);
    for ((name, value), moments) in training.network.parameters().iter().zip(&training.moments) {
        tensors.insert((*name).to_owned(), value.as_tensor().clone());
        tensors.insert(format!("{name}.first_moment"), moments.first.clone());
        tensors.insert(format!("{name}.second_moment"), moments.second.clone());
    }
    if let Some(folder) = file.parent() {
        fs::create_dir_all(folder).map_err(unwritten)?;
    }
    let unfinished = file.with_extension("unfinished");
    safetensors::save(&tensors, &unfinished).map_err(failed)?;
    fs::rename(&unfinished, file).map_err(unwritten)
}

/// Takes a training up where `file` has it, or leaves it at its beginning if there is no such file.
pub(super) fn take_up(
    training: &mut Training,
    identity: &str,
    file: &Path,
) -> Result<(), CheckpointError> {
    if !file.exists() {
        return Ok(());
    }
    let failed = |source| CheckpointError::Tensors { file: file.to_path_buf(), source };
    let tensors = safetensors::load(file, &Device::Cpu).map_err(failed)?;
    let tensor = |name: &str| {
        let missing = || candle_core::Error::Msg(format!("there is no {name}"));
        tensors.get(name).ok_or_else(missing)
    };
    let bytes = tensor(IDENTITY).and_then(Tensor::to_vec1::<u8>).map_err(failed)?;
    let found = String::from_utf8_lossy(&bytes).into_owned();
    if found != identity {
        let expected = identity.to_owned();
        return Err(CheckpointError::Other { file: file.to_path_buf(), expected, found });
    }
    let mut read = || {
        for ((name, value), moments) in
            training.network.parameters().iter().zip(&mut training.moments)
        {
            value.set(tensor(name)?)?;
            moments.first = tensor(&format!("{name}.first_moment"))?.clone();
            moments.second = tensor(&format!("{name}.second_moment"))?.clone();
        }
        let step = tensor(STEP)?.to_vec1::<u32>()?;
        training.step = usize::try_from(step[0]).unwrap_or(usize::MAX);
        Ok(())
    };
    read().map_err(failed)
}
