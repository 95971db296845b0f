//! Writes the result as one JSON object, schema `sinew-evaluate/1`.

use serde::{Serialize, Serializer};
use sinew_figure::plant::Description;

use super::super::{
    ClipLength, ErrorTotals, Evaluation, FigureResult, Likeness, MethodName, MethodResult, Setup,
    WeightedTotals,
};

#[derive(Serialize)]
struct Document<'a> {
    schema: &'static str,
    #[serde(skip_serializing_if = "Option::is_none")]
    rig: Option<&'a str>,
    /// Support of the base of a user's rig, in words.
    #[serde(skip_serializing_if = "Option::is_none")]
    base: Option<&'static str>,
    plant: Description,
    setup: &'a Setup,
    frames: usize,
    figures: Vec<Figure>,
    clips: &'a [ClipLength],
}

#[derive(Serialize)]
struct Figure {
    scale: f64,
    methods: Methods,
}

/// A JSON object with a key for each method, in the protocol's order.
struct Methods(Vec<(MethodName, Groups)>);

impl Serialize for Methods {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_map(self.0.iter().map(|(method, groups)| (method.as_str(), groups)))
    }
}

#[derive(Serialize)]
struct Groups {
    all: Totals,
    leaf: Totals,
    /// Errors of whole poses, where every joint has the weight of the skin that it moves.
    weighted: Weighted,
    /// Widest gap at the plant's joints.
    widest_gap_mm: f64,
    /// Number of times that a joint did not receive its desired torque.
    limited: u64,
    /// Angles between the limbs of a rig and those of the performers of its clips.
    #[serde(skip_serializing_if = "Option::is_none")]
    performer: Option<Performer>,
}

/// Angles between a rig's limbs and a performer's.
#[derive(Serialize)]
struct Performer {
    /// Angles of the rig's target pose.
    retargeting: Limbs,
    /// Angles of the simulated rig.
    total: Limbs,
}

/// Mean and maximum of the angles between limbs.
#[derive(Serialize)]
struct Limbs {
    mean_deg: f64,
    max_deg: f64,
}

impl From<Likeness> for Performer {
    fn from(Likeness { retargeting, total }: Likeness) -> Self {
        let [retargeting, total] = [retargeting, total]
            .map(|totals| Limbs { mean_deg: totals.mean_deg(), max_deg: totals.largest_deg });
        Self { retargeting, total }
    }
}

/// Means and maxima of one group of joints.
#[derive(Serialize)]
struct Totals {
    n: u64,
    angular_mean_deg: f64,
    linear_mean_cm: f64,
    angular_max_deg: f64,
    linear_max_cm: f64,
}

impl From<&ErrorTotals> for Totals {
    fn from(totals: &ErrorTotals) -> Self {
        Self {
            n: totals.n,
            angular_mean_deg: totals.angular_mean_deg(),
            linear_mean_cm: totals.linear_mean_cm(),
            angular_max_deg: totals.angular_max_deg(),
            linear_max_cm: totals.linear_max_cm(),
        }
    }
}

/// Mean and maximum of the importance-weighted error.
#[derive(Serialize)]
struct Weighted {
    n: u64,
    mean_cm: f64,
    max_cm: f64,
}

impl From<&WeightedTotals> for Weighted {
    fn from(totals: &WeightedTotals) -> Self {
        Self { n: totals.n, mean_cm: totals.mean_cm(), max_cm: totals.max_cm() }
    }
}

impl From<&MethodResult> for Groups {
    fn from(result: &MethodResult) -> Self {
        let errors = &result.total;
        Self {
            all: (&errors.all).into(),
            leaf: (&errors.leaf).into(),
            weighted: (&errors.weighted).into(),
            widest_gap_mm: errors.widest_gap_m * 1000.0,
            limited: errors.limited,
            performer: result.likeness().map(Performer::from),
        }
    }
}

impl From<&FigureResult> for Figure {
    fn from(figure: &FigureResult) -> Self {
        let results = figure.methods.iter();
        let groups = results.map(|result| (result.method, Groups::from(result)));
        Self { scale: figure.scale, methods: Methods(groups.collect()) }
    }
}

/// Returns the JSON text, with a newline at the end.
pub fn json(evaluation: &Evaluation) -> String {
    let document = Document {
        schema: "sinew-evaluate/1",
        rig: evaluation.rig.as_deref(),
        base: evaluation.base(),
        plant: evaluation.setup.plant.description(),
        setup: &evaluation.setup,
        frames: evaluation.frames(),
        figures: evaluation.figures.iter().map(Figure::from).collect(),
        clips: &evaluation.clips,
    };
    let mut text = serde_json::to_string_pretty(&document).expect("plain data turns into JSON");
    text.push('\n');
    text
}
