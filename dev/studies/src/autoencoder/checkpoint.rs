//! Trainings on disk: parameters, moments and step as safetensors, with the identity of the training.

use std::collections::HashMap;
use std::fs;
use std::path::{Path, PathBuf};

use candle_core::{DType, Device, Tensor, WithDType, safetensors};

use super::adamw::Moments;
use super::training::Training;

/// Error of a training that cannot be saved or resumed.
#[derive(Debug, thiserror::Error)]
pub enum CheckpointError {
    /// The file cannot be written.
    #[error("{}: cannot be written: {source}", file.display())]
    Write {
        /// Path of the file.
        file: PathBuf,
        /// Error of the system.
        source: std::io::Error,
    },
    /// The file does not contain a complete training.
    #[error("{}: {source}: expected the parameters of a training that was stopped", file.display())]
    Tensors {
        /// Path of the file.
        file: PathBuf,
        /// Error of the reader.
        source: candle_core::Error,
    },
    /// A tensor is invalid for a training.
    #[error("{}: tensor {tensor}: expected {expected}, found {found}; delete the file", file.display())]
    Tensor {
        /// Path of the file.
        file: PathBuf,
        /// Name of the tensor.
        tensor: String,
        /// Description of valid content.
        expected: String,
        /// Description of the content in the file.
        found: String,
    },
    /// The file belongs to another training.
    #[error(
        "{}: is of another training: expected {expected}, found {found}; take another folder, or delete the file",
        file.display()
    )]
    Other {
        /// Path of the file.
        file: PathBuf,
        /// Identity of the training that should be resumed.
        expected: String,
        /// Identity in the file.
        found: String,
    },
}

const IDENTITY: &str = "identity";
const STEP: &str = "step";

/// Writes a training with its `identity`. The file is complete, or unchanged after a failure.
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

/// Resumes a training from `file`; without such a file, the training stays at its beginning. A refused file leaves
/// the training unchanged.
pub(super) fn take_up(
    training: &mut Training,
    identity: &str,
    file: &Path,
) -> Result<(), CheckpointError> {
    if !file.exists() {
        return Ok(());
    }
    let failed = |source| CheckpointError::Tensors { file: file.to_path_buf(), source };
    let saved = Saved { file, tensors: safetensors::load(file, &Device::Cpu).map_err(failed)? };
    let found = saved.identity()?;
    if found != identity {
        let expected = identity.to_owned();
        return Err(CheckpointError::Other { file: file.to_path_buf(), expected, found });
    }
    let step = saved.step()?;
    let mut values = Vec::new();
    let mut moments = Vec::new();
    for (name, value) in training.network.parameters() {
        values.push(saved.numbers(name, value, Numbers::Finite)?);
        moments.push(Moments {
            first: saved.numbers(&format!("{name}.first_moment"), value, Numbers::Finite)?,
            second: saved.numbers(&format!("{name}.second_moment"), value, Numbers::NotNegative)?,
        });
    }
    for ((_, parameter), value) in training.network.parameters().iter().zip(&values) {
        parameter.set(value).map_err(failed)?;
    }
    training.moments = moments;
    training.step = step;
    Ok(())
}

/// Requirement for a tensor's numbers.
#[derive(Debug, Clone, Copy)]
enum Numbers {
    Finite,
    /// Finite and not negative: means of squares, whose root is taken.
    NotNegative,
}

impl Numbers {
    fn holds(self, number: f32) -> bool {
        number.is_finite() && (matches!(self, Self::Finite) || number >= 0.0)
    }

    const fn as_str(self) -> &'static str {
        match self {
            Self::Finite => "finite numbers",
            Self::NotNegative => "finite numbers from 0",
        }
    }
}

/// Content of a file, by name.
struct Saved<'a> {
    file: &'a Path,
    tensors: HashMap<String, Tensor>,
}

impl Saved<'_> {
    fn refused(&self, tensor: &str, expected: &str, found: String) -> CheckpointError {
        CheckpointError::Tensor {
            file: self.file.to_path_buf(),
            tensor: tensor.to_owned(),
            expected: expected.to_owned(),
            found,
        }
    }

    /// Returns the tensor with a name. Refuses a tensor of another type or, if a shape is given, of another shape.
    fn tensor(
        &self,
        name: &str,
        dtype: DType,
        shape: Option<&[usize]>,
    ) -> Result<&Tensor, CheckpointError> {
        let kind = |dtype: DType, shape: &[usize]| format!("{} {shape:?}", dtype.as_str());
        let expected =
            || shape.map_or_else(|| format!("{} [..]", dtype.as_str()), |shape| kind(dtype, shape));
        let tensor = self
            .tensors
            .get(name)
            .ok_or_else(|| self.refused(name, &expected(), "nothing".to_owned()))?;
        if tensor.dtype() == dtype && shape.unwrap_or(tensor.dims()) == tensor.dims() {
            Ok(tensor)
        } else {
            Err(self.refused(name, &expected(), kind(tensor.dtype(), tensor.dims())))
        }
    }

    /// Returns the numbers of a tensor with the type and shape, in order.
    fn values<T: WithDType>(
        &self,
        name: &str,
        shape: Option<&[usize]>,
    ) -> Result<Vec<T>, CheckpointError> {
        let failed = |source| CheckpointError::Tensors { file: self.file.to_path_buf(), source };
        let tensor = self.tensor(name, T::DTYPE, shape)?;
        tensor.flatten_all().and_then(|flat| flat.to_vec1()).map_err(failed)
    }

    fn identity(&self) -> Result<String, CheckpointError> {
        Ok(String::from_utf8_lossy(&self.values::<u8>(IDENTITY, None)?).into_owned())
    }

    fn step(&self) -> Result<usize, CheckpointError> {
        let steps: Vec<u32> = self.values(STEP, Some(&[1]))?;
        Ok(usize::try_from(steps[0]).unwrap_or(usize::MAX))
    }

    /// Returns the tensor with a name. Refuses a tensor that does not have the shape of `like`, or whose numbers do not
    /// fulfil `must`.
    fn numbers(&self, name: &str, like: &Tensor, must: Numbers) -> Result<Tensor, CheckpointError> {
        let numbers: Vec<f32> = self.values(name, Some(like.dims()))?;
        match numbers.iter().position(|number| !must.holds(*number)) {
            Some(index) => {
                let found = format!("{} at {index}", numbers[index]);
                Err(self.refused(name, must.as_str(), found))
            }
            None => Ok(self.tensors[name].clone()),
        }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// Returns the message for a file in which one tensor is replaced.
    fn refusal(name: &str, tensor: Option<Tensor>) -> String {
        let new = || Training::new(12, 3, 1).unwrap();
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("training.safetensors");
        save(&new(), "this one", &file).unwrap();
        take_up(&mut new(), "this one", &file).unwrap();
        let mut tensors = safetensors::load(&file, &Device::Cpu).unwrap();
        assert!(tensors.remove(name).is_some(), "{name}");
        tensors.extend(tensor.map(|tensor| (name.to_owned(), tensor)));
        safetensors::save(&tensors, &file).unwrap();
        let mut training = new();
        let error = take_up(&mut training, "this one", &file).unwrap_err();
        assert!(matches!(error, CheckpointError::Tensor { .. }), "{error}");
        let numbers = |training: &Training| -> Vec<Vec<f32>> {
            let values = training.network.parameters().iter();
            values.map(|(_, v)| v.flatten_all().unwrap().to_vec1().unwrap()).collect()
        };
        assert_eq!(numbers(&training), numbers(&new()), "it is as it was");
        let error = error.to_string();
        assert!(error.starts_with(&*file.to_string_lossy()), "{error}");
        error.split_once("tensor ").unwrap().1.to_owned()
    }

    fn f32s(shape: &[usize], last: f32) -> Tensor {
        let mut numbers = vec![0.5; shape.iter().product()];
        *numbers.last_mut().unwrap() = last;
        Tensor::from_vec(numbers, shape, &Device::Cpu).unwrap()
    }

    #[test]
    fn what_is_no_step_is_refused() {
        let none = Tensor::from_vec(Vec::<u32>::new(), 0, &Device::Cpu).unwrap();
        let told = refusal("step", Some(none));
        assert_eq!(told, "step: expected u32 [1], found u32 [0]; delete the file");
        let told = refusal("step", Some(f32s(&[1], 3.0)));
        assert_eq!(told, "step: expected u32 [1], found f32 [1]; delete the file");
        let told = refusal("step", None);
        assert_eq!(told, "step: expected u32 [1], found nothing; delete the file");
        let told = refusal("identity", Some(f32s(&[2], 3.0)));
        assert_eq!(told, "identity: expected u8 [..], found f32 [2]; delete the file");
    }

    #[test]
    fn parameters_and_moments_of_another_shape_are_refused() {
        let told = refusal("decoder.weight", Some(f32s(&[12, 3], 0.0)));
        assert_eq!(
            told,
            "decoder.weight: expected f32 [3, 12], found f32 [12, 3]; delete the file"
        );
        let told = refusal("encoder.bias.first_moment", Some(f32s(&[4], 0.0)));
        assert_eq!(
            told,
            "encoder.bias.first_moment: expected f32 [3], found f32 [4]; delete the file"
        );
        let doubles = f32s(&[3], 0.0).to_dtype(DType::F64).unwrap();
        let told = refusal("encoder.bias", Some(doubles));
        assert_eq!(told, "encoder.bias: expected f32 [3], found f64 [3]; delete the file");
    }

    #[test]
    fn what_is_not_finite_is_refused() {
        for (name, shape, last, found) in [
            ("encoder.bias", vec![3], f32::NAN, "NaN at 2"),
            ("decoder.weight", vec![3, 12], f32::INFINITY, "inf at 35"),
            ("decoder.bias.first_moment", vec![12], f32::NAN, "NaN at 11"),
        ] {
            let told = refusal(name, Some(f32s(&shape, last)));
            assert_eq!(
                told,
                format!("{name}: expected finite numbers, found {found}; delete the file")
            );
        }
        let told = refusal("encoder.bias.second_moment", Some(f32s(&[3], -1.0)));
        assert_eq!(
            told,
            "encoder.bias.second_moment: expected finite numbers from 0, found -1 at 2; \
             delete the file"
        );
    }

    /// Damage to a file: for each change, its place, the number of replaced bytes, and the new bytes; then the file's
    /// length.
    fn damage() -> impl Strategy<Value = (Vec<(usize, usize, Vec<u8>)>, usize)> {
        let odd = prop_oneof![
            prop::collection::vec(any::<u8>(), 0..9),
            Just(b"18446744073709551615".to_vec()),
            Just(b"-1".to_vec()),
            Just(b"{\"".to_vec()),
            Just(u64::MAX.to_le_bytes().to_vec()),
            Just(f32::NAN.to_le_bytes().to_vec()),
        ];
        // The head, with sizes and offsets, is a part of the file.
        let place = prop_oneof![0_usize..64, 0_usize..1 << 12];
        (
            prop::collection::vec((place, 0_usize..9, odd), 1..4),
            prop_oneof![4 => Just(usize::MAX), 1 => 0_usize..1 << 12],
        )
    }

    proptest! {
        #[test]
        fn a_damaged_file_is_refused_or_a_whole_training((changes, length) in damage()) {
            let new = || Training::new(12, 3, 1).unwrap();
            let folder = tempfile::tempdir().unwrap();
            let file = folder.path().join("training.safetensors");
            save(&new(), "this one", &file).unwrap();
            let mut bytes = fs::read(&file).unwrap();
            for (place, count, odd) in changes {
                let from = place.min(bytes.len());
                bytes.splice(from..(from + count).min(bytes.len()), odd);
            }
            bytes.truncate(length);
            fs::write(&file, &bytes).unwrap();
            let mut training = new();
            match take_up(&mut training, "this one", &file) {
                Ok(()) => for (name, value) in training.network.parameters() {
                    let numbers: Vec<f32> = value.flatten_all().unwrap().to_vec1().unwrap();
                    prop_assert!(numbers.iter().all(|number| number.is_finite()), "{name}");
                },
                Err(error) => prop_assert!(error.to_string().starts_with(&*file.to_string_lossy()), "{error}"),
            }
        }
    }
}
