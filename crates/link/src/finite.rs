//! Serializes and deserializes finite numbers only: `#[serde(with = "finite")]` on every `f32` of a message.

use serde::de::Error as _;
use serde::ser::Error as _;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

const NOT_FINITE: &str = "a number is not finite";

#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde calls it so")]
pub(crate) fn serialize<S: Serializer>(value: &f32, serializer: S) -> Result<S::Ok, S::Error> {
    if value.is_finite() {
        serializer.serialize_f32(*value)
    } else {
        Err(S::Error::custom(NOT_FINITE))
    }
}

pub(crate) fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<f32, D::Error> {
    let value = f32::deserialize(deserializer)?;
    if value.is_finite() { Ok(value) } else { Err(D::Error::custom(NOT_FINITE)) }
}

/// A finite number, as an item of a list.
#[derive(Serialize, Deserialize)]
struct Finite(#[serde(with = "self")] f32);

/// Serializes and deserializes lists of finite numbers: `#[serde(with = "finite::list")]`.
pub(crate) mod list {
    use core::fmt;
    use core::marker::PhantomData;

    use heapless::Vec;
    use serde::de::{Error as _, SeqAccess, Visitor};
    use serde::{Deserializer, Serializer};

    use super::Finite;

    pub(crate) fn serialize<S: Serializer, const N: usize>(
        values: &Vec<f32, N>,
        serializer: S,
    ) -> Result<S::Ok, S::Error> {
        serializer.collect_seq(values.iter().map(|&value| Finite(value)))
    }

    pub(crate) fn deserialize<'de, D: Deserializer<'de>, const N: usize>(
        deserializer: D,
    ) -> Result<Vec<f32, N>, D::Error> {
        deserializer.deserialize_seq(Numbers(PhantomData))
    }

    struct Numbers<const N: usize>(PhantomData<[f32; N]>);

    impl<'de, const N: usize> Visitor<'de> for Numbers<N> {
        type Value = Vec<f32, N>;

        fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
            write!(f, "at most {N} numbers")
        }

        fn visit_seq<A: SeqAccess<'de>>(self, mut seq: A) -> Result<Self::Value, A::Error> {
            let mut values = Vec::new();
            while let Some(Finite(value)) = seq.next_element()? {
                values.push(value).map_err(|_| A::Error::custom("too many numbers"))?;
            }
            Ok(values)
        }
    }
}
