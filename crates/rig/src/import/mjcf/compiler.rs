//! Reads the `compiler` elements of an MJCF: rules on masses.

use roxmltree::Node;

use crate::description::{Description, InertiaMatrix};
use crate::import::error::ImportError;
use crate::import::note::{NoteKind, Notes};
use crate::import::xml;

/// The compiler's rules on masses.
pub(super) struct MassRules {
    /// Whether geoms define the mass: always, never, or (`None`) only without `inertial`.
    pub(super) from_geoms: Option<bool>,
    /// First and last group of the geoms that define masses.
    pub(super) groups: [f64; 2],
    pub(super) balance: bool,
    pub(super) least_kg: f64,
    pub(super) total_kg: Option<f64>,
    pub(super) has_least_inertia: bool,
}

impl MassRules {
    pub(super) fn read(compilers: &[Node<'_, '_>]) -> Result<Self, ImportError> {
        let with = |name: &str| compilers.iter().find(|node| node.has_attribute(name));
        let number = |name| with(name).map_or(Ok(None), |node| xml::number(*node, name));
        let from_geoms =
            match with("inertiafromgeom").and_then(|node| node.attribute("inertiafromgeom")) {
                Some("auto") => None,
                _ => flag(compilers, "inertiafromgeom")?,
            };
        let groups = with("inertiagrouprange")
            .map_or(Ok(None), |node| xml::vector(*node, "inertiagrouprange"))?
            .unwrap_or([0.0, 5.0]);
        Ok(Self {
            from_geoms,
            groups,
            balance: flag(compilers, "balanceinertia")?.unwrap_or(false),
            least_kg: number("boundmass")?.unwrap_or(0.0),
            total_kg: number("settotalmass")?.filter(|total| *total > 0.0),
            has_least_inertia: number("boundinertia")?.unwrap_or(0.0) > 0.0,
        })
    }

    /// Applies the compiler's rules on all masses, after all bodies are read.
    pub(super) fn settle(&self, description: &mut Description, notes: &mut Notes) {
        if self.has_least_inertia {
            notes.add(NoteKind::LeftOut, "the compiler's boundinertia");
        }
        let Some(total_kg) = self.total_kg else { return };
        let sum_kg: f64 = description.bodies.iter().map(|body| body.mass_kg).sum();
        if sum_kg <= 0.0 {
            return;
        }
        let factor = total_kg / sum_kg;
        for body in &mut description.bodies {
            body.mass_kg *= factor;
            if let Some(inertia) = &mut body.inertia_kg_m2 {
                let InertiaMatrix { xx, xy, xz, yy, yz, zz } = inertia;
                for element in [xx, xy, xz, yy, yz, zz] {
                    *element *= factor;
                }
            }
        }
        let text =
            format!("all masses are scaled to {total_kg} kg, by the compiler's settotalmass");
        notes.add(NoteKind::Changed, text);
    }
}

/// Reads a flag of the compiler, `true` or `false`; the first of several elements counts.
pub(super) fn flag(compilers: &[Node<'_, '_>], name: &str) -> Result<Option<bool>, ImportError> {
    let Some(node) = compilers.iter().find(|node| node.has_attribute(name)) else {
        return Ok(None);
    };
    match node.attribute(name).map(str::trim) {
        Some("true") => Ok(Some(true)),
        Some("false") => Ok(Some(false)),
        _ => Err(xml::refuse_value(*node, name, "true or false")),
    }
}
