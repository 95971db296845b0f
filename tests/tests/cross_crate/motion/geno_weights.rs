//! The weights of Geno's joints compared with the list in D. Holden, "Joint Error Propagation" (2025), as a committed
//! snapshot. Run this test with `INSTA_UPDATE=always` to accept a change.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use sinew_pose_metrics::character::{self, Character, Options, VertexArea};
use sinew_pose_metrics::weights::radii::{self, Radii};
use sinew_pose_metrics::weights::{Method, Settings, weigh};

/// A row of `oracles/geno_published_weights.csv`: joint, lengths, cylinders, mesh.
type Row = (String, f64, f64, f64);

fn oracle(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("oracles").join(name)
}

fn published() -> Vec<Row> {
    let mut reader = csv::Reader::from_path(oracle("geno_published_weights.csv")).expect("a CSV");
    reader.deserialize().collect::<Result<_, _>>().expect("a joint and three numbers")
}

fn geno() -> Character {
    let data = std::env::var_os("SINEW_DATA").expect("SINEW_DATA names the folder of the data");
    let file = Path::new(&data).join("geno/Geno.bin");
    character::read(&file, &Options::default()).expect("Geno")
}

/// A computed list of weights, and the published list.
struct Comparison {
    name: &'static str,
    how: &'static str,
    ours: Vec<f64>,
    published: Vec<f64>,
}

impl Comparison {
    /// Returns the computed weight divided by the published one, by joint.
    fn ratios(&self) -> impl Iterator<Item = f64> {
        self.ours.iter().zip(&self.published).map(|(ours, published)| ours / published)
    }

    /// Returns the joint whose ratio is farthest from 1, and its deviation.
    fn worst(&self) -> (usize, f64) {
        let off = self.ratios().map(|ratio| (ratio - 1.0).abs()).enumerate();
        off.max_by(|a, b| a.1.total_cmp(&b.1)).expect("joints")
    }

    /// Returns the largest difference.
    fn difference(&self) -> f64 {
        let pairs = self.ours.iter().zip(&self.published);
        pairs.map(|(ours, published)| (ours - published).abs()).fold(0.0, f64::max)
    }

    fn rank_correlation(&self) -> f64 {
        correlation(&ranks(&self.ours), &ranks(&self.published))
    }
}

/// Returns the ranks, from the smallest value; equal values share the mean of their ranks.
fn ranks(values: &[f64]) -> Vec<f64> {
    let rank = |value: &f64| {
        let below = values.iter().filter(|other| *other < value).count();
        let equal = values.iter().filter(|other| other.total_cmp(value).is_eq()).count();
        below as f64 + 0.5 * (equal as f64 - 1.0)
    };
    values.iter().map(rank).collect()
}

/// Returns Pearson's correlation.
fn correlation(a: &[f64], b: &[f64]) -> f64 {
    let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
    let (mean_a, mean_b) = (mean(a), mean(b));
    let product = |a: &[f64], mean_a, b: &[f64], mean_b| {
        a.iter().zip(b).map(|(a, b)| (a - mean_a) * (b - mean_b)).sum::<f64>()
    };
    let squares = product(a, mean_a, a, mean_a) * product(b, mean_b, b, mean_b);
    product(a, mean_a, b, mean_b) / squares.sqrt()
}

fn comparisons(geno: &Character, rows: &[Row]) -> [Comparison; 6] {
    let default = Settings::default;
    let compare = |name, how, method, settings: &Settings| Comparison {
        name,
        how,
        ours: weigh(geno, method, settings).expect("Geno can be weighed").weights,
        published: rows
            .iter()
            .map(|(_, lengths, cylinders, mesh)| match method {
                Method::Lengths => *lengths,
                Method::Cylinders => *cylinders,
                Method::Mesh => *mesh,
            })
            .collect(),
    };
    let article = Settings { vertex_area: VertexArea::Article, ..default() };
    let printed = Settings { base: Some(0.001), ..default() };
    let given = radii::read(&oracle("geno_article_radii.csv")).expect("radii of Geno's bones");
    let given = Settings { radii: Radii::Given(given), ..default() };
    [
        compare("lengths", "base 0.1 m, discount 0.9", Method::Lengths, &default()),
        compare("mesh", "base 0.00183 m³, all of the surface", Method::Mesh, &default()),
        compare("mesh, printed", "base 0.001 m³, all of the surface", Method::Mesh, &printed),
        compare(
            "mesh, article",
            "base 0.001 m³, mean area of each vertex' triangles",
            Method::Mesh,
            &article,
        ),
        compare("cylinders", "base 0.002 m³, radii by the skin", Method::Cylinders, &default()),
        compare(
            "cyl., article",
            "base 0.002 m³, the list's own radii to 5 mm",
            Method::Cylinders,
            &given,
        ),
    ]
}

fn table(rows: &[Row], comparisons: &[Comparison]) -> String {
    let mut text = String::new();
    let mut line = |line: String| writeln!(text, "{}", line.trim_end()).expect("a string");
    line(format!("{:<53}  largest ratio off 1           rank", ""));
    for comparison in comparisons {
        let (joint, off) = comparison.worst();
        let (name, how) = (comparison.name, comparison.how);
        let rank = comparison.rank_correlation();
        line(format!("{name:<14} {how:<52} {:8.4} % {:<16} {rank:.6}", 100.0 * off, rows[joint].0));
    }
    line(String::new());
    let heading = |comparison: &Comparison| {
        format!("{:>14}{:>12}{:>8}", comparison.name, "published", "ratio")
    };
    line(format!("{:<18}{}", "joint", comparisons.iter().map(heading).collect::<String>()));
    for (index, (joint, ..)) in rows.iter().enumerate() {
        let cells = comparisons.iter().map(|Comparison { ours, published, .. }| {
            let (ours, published) = (ours[index], published[index]);
            format!("{ours:>14.8}{published:>12.8}{:>8.4}", ours / published)
        });
        line(format!("{joint:<18}{}", cells.collect::<String>()));
    }
    text
}

#[test]
#[ignore = "needs SINEW_DATA"]
fn weights_of_geno_beside_the_published_ones() {
    let (geno, rows) = (geno(), published());
    let names = geno.joints().iter().map(|joint| &joint.name);
    assert!(names.eq(rows.iter().map(|(joint, ..)| joint)), "the same joints in the same order");
    let comparisons = comparisons(&geno, &rows);
    let [lengths, mesh, _, mesh_article, cylinders, cylinders_article] = &comparisons;
    assert!(lengths.difference() < 1e-5, "{}", lengths.difference());
    assert!(mesh.worst().1 < 0.03 && mesh.rank_correlation() > 0.999, "{:?}", mesh.worst());
    // Tolerance: the precision of eight printed decimals, for weights near 0.0006.
    assert!(mesh_article.worst().1 < 1e-4, "{:?}", mesh_article.worst());
    assert!(cylinders.rank_correlation() > 0.99, "{}", cylinders.rank_correlation());
    // A thousand random points leave an error of about 1 %.
    assert!(cylinders_article.worst().1 < 0.01, "{:?}", cylinders_article.worst());
    insta::assert_snapshot!("published", table(&rows, &comparisons));
}
