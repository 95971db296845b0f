//! Angles: degrees in files, radians in memory.

/// One angle that may be left out.
pub(super) mod degrees {
    use serde::{Deserialize, Deserializer, Serialize, Serializer};

    pub(in crate::description) fn serialize<S: Serializer>(
        rad: &Option<f64>,
        serializer: S,
    ) -> Result<S::Ok, S::Error> {
        rad.map(super::in_degrees).serialize(serializer)
    }

    pub(in crate::description) fn deserialize<'de, D: Deserializer<'de>>(
        deserializer: D,
    ) -> Result<Option<f64>, D::Error> {
        Ok(Option::<f64>::deserialize(deserializer)?.map(f64::to_radians))
    }
}

/// Pairs, such as the ends of a range.
pub(super) mod degree_pairs {
    use serde::{Deserialize, Deserializer, Serialize, Serializer};

    pub(in crate::description) fn serialize<S: Serializer>(
        rad: &[[f64; 2]],
        serializer: S,
    ) -> Result<S::Ok, S::Error> {
        let degrees: Vec<_> = rad.iter().map(|pair| pair.map(super::in_degrees)).collect();
        degrees.serialize(serializer)
    }

    pub(in crate::description) fn deserialize<'de, D: Deserializer<'de>>(
        deserializer: D,
    ) -> Result<Vec<[f64; 2]>, D::Error> {
        let degrees = Vec::<[f64; 2]>::deserialize(deserializer)?;
        Ok(degrees.into_iter().map(|pair| pair.map(f64::to_radians)).collect())
    }
}

/// To 1e-9 of a degree: what conversion adds beyond is noise that nobody wants to read.
fn in_degrees(rad: f64) -> f64 {
    let degrees = rad.to_degrees();
    let rounded = (degrees * 1e9).round() / 1e9;
    if rounded.is_finite() { rounded } else { degrees }
}
