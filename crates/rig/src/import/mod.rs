//! Imports robots of other programs as rigs: URDF (ROS) and MJCF (MuJoCo).
//!
//! [`Imported::notes`] describes what was changed, filled in or left out, and what is doubtful. A file that cannot be
//! imported is refused with line, column and name.

mod error;
mod imported;
mod mass;
mod mjcf;
mod none;
mod note;
mod options;
mod solid;
mod tie;
mod urdf;
mod world;
mod xml;

pub use error::{ImportError, SourcePosition};
pub use imported::Imported;
pub use mjcf::LoadPart;
pub use note::{Note, NoteKind};
pub use options::Options;
pub use world::World;
pub use xml::document;

/// Reads a URDF (the Unified Robot Description Format of ROS).
///
/// Every link becomes a body, and every joint a joint, including fixed joints. A joint that mimics another remains
/// a joint, and a [`LinkedLimit`](crate::description::LinkedLimit) with equal ends ties it to the other.
///
/// # Errors
/// [`ImportError`] if the text is not XML or not a robot, its links are not a tree, it has closed loops (unless
/// [`Options::open_loops`] accepts them), or a value is invalid.
///
/// ```
/// let text = r#"<robot name="nod">
///   <link name="stand"/>
///   <link name="head">
///     <inertial><mass value="0.2"/><inertia ixx="1e-4" iyy="1e-4" izz="1e-4" ixy="0" ixz="0" iyz="0"/></inertial>
///   </link>
///   <joint name="neck" type="revolute">
///     <parent link="stand"/><child link="head"/><axis xyz="0 1 0"/>
///     <limit lower="-0.5" upper="0.5" effort="0.4" velocity="6"/>
///   </joint>
/// </robot>"#;
/// let imported = sinew_rig::import::urdf(text, &Default::default())?;
/// let neck = &imported.description.joints[0];
/// assert_eq!((neck.axis, neck.effort), (Some([0.0, 1.0, 0.0]), Some(0.4)));
/// # Ok::<(), sinew_rig::import::ImportError>(())
/// ```
pub fn urdf(text: &str, options: &Options) -> Result<Imported, ImportError> {
    urdf::read(text, options)
}

/// Reads an MJCF (the format of MuJoCo).
///
/// Every body becomes a body; several joints of one body become a chain, connected by bodies without mass. The
/// outermost body is the base. `armature` becomes the joint's rotor inertia, the maximum force of its actuators
/// becomes its effort, and an equality of two joints ties them as in [`urdf`].
///
/// # Errors
/// [`ImportError`] if the text is not XML or not a model, has parts in other files or closed loops (unless
/// [`Options::open_loops`] accepts them), or a value is invalid.
///
/// ```
/// let text = r#"<mujoco model="nod"><worldbody><body name="stand"><body name="head">
///   <joint name="neck" axis="0 1 0" range="-30 30" armature="0.01"/>
///   <geom type="box" size="0.03 0.02 0.04" pos="0 0 0.05"/>
/// </body></body></worldbody></mujoco>"#;
/// let imported = sinew_rig::import::mjcf(text, &Default::default())?;
/// let neck = &imported.description.joints[0];
/// assert_eq!((neck.axis, neck.rotor_inertia), (Some([0.0, 1.0, 0.0]), Some(0.01)));
/// # Ok::<(), sinew_rig::import::ImportError>(())
/// ```
pub fn mjcf(text: &str, options: &Options) -> Result<Imported, ImportError> {
    mjcf::read(text, options)
}

/// Reads an MJCF (the format of MuJoCo) with its parts in other files, as [`mjcf`] does without them. Each `include`
/// is replaced by the content of its file, which `load` reads.
///
/// # Errors
/// As [`mjcf`]; also if a part cannot be read, is neither in the model's folder nor in a folder below it, is included
/// twice, or is too large.
pub fn mjcf_with_parts(
    text: &str,
    options: &Options,
    load: LoadPart<'_>,
) -> Result<Imported, ImportError> {
    mjcf::read_with_parts(text, options, load)
}
