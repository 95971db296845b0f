//! Rigs: reading, names and limits, kinematics and dynamics.

use std::path::PathBuf;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use glam::DVec3;
use numpy::{PyArray1, PyArray2, PyArray3, PyArrayMethods, PyReadonlyArray2};
use pyo3::prelude::*;
use sinew_mocap::Up;
use sinew_performance::rig::{LoadedRig, load};
use sinew_performance::rig_hash;
use sinew_rig::description::Base;
use sinew_rig::import::Options;
use sinew_rig::mechanism::{JointModel, Link, Pose, Tie};
use sinew_rig::{Description, toml_file};

use crate::arrays::{Rows, array, check_width, count_rows, expect_rows, single};
use crate::clip::check_unit;
use crate::dynamics::{Dynamics, Piece};
use crate::error::value;
use crate::jacobian::columns;
use crate::work::in_pieces;

/// A rig, which is shared by all objects that are made from it.
#[pyclass(frozen, module = "sinew_motion._sinew_motion")]
pub(crate) struct NativeRig {
    pub(crate) loaded: Arc<LoadedRig>,
    dynamics: Mutex<Dynamics>,
    nq: usize,
    nv: usize,
}

/// Reads a rig from a file.
#[pyfunction]
pub(crate) fn load_rig(
    py: Python<'_>,
    path: PathBuf,
    base: Option<&str>,
    rotors: bool,
    repair_inertia: bool,
    metres_per_unit: Option<f64>,
    up: Option<&str>,
) -> PyResult<NativeRig> {
    let up = up.map(|axis| axis.parse::<Up>().map_err(value)).transpose()?;
    check_unit(metres_per_unit)?;
    let base = match base {
        None => None,
        Some("stand") => Some(Base::Fixed),
        Some("driven") => Some(Base::Driven),
        Some(found) => {
            return Err(value(format!(
                "base: expected \"stand\" or \"driven\", found \"{found}\""
            )));
        }
    };
    let up = up.map(Up::axis);
    let options = Options { repair_inertia, metres_per_unit, up, ..Options::default() };
    py.detach(|| {
        let mut loaded = load(&path, &options).map_err(value)?;
        if let Some(base) = base {
            loaded.set_base(base).map_err(value)?;
        }
        if !rotors {
            loaded.mechanism.bodies.iter_mut().for_each(|link| link.rotor_inertia = 0.0);
        }
        NativeRig::of(loaded)
    })
}

/// Creates an arm with this number of joints.
#[pyfunction]
pub(crate) fn new_arm(joints: usize) -> PyResult<NativeRig> {
    NativeRig::new(sinew_rig::new::arm(joints).map_err(value)?)
}

/// Creates a face.
#[pyfunction]
pub(crate) fn new_face() -> PyResult<NativeRig> {
    NativeRig::new(sinew_rig::new::face())
}

impl NativeRig {
    fn new(description: Description) -> PyResult<Self> {
        let mechanism = description.mechanism().map_err(value)?;
        let (notes, doubts) = (Vec::new(), Vec::new());
        Self::of(LoadedRig { description, mechanism, world: None, notes, doubts })
    }

    fn of(loaded: LoadedRig) -> PyResult<Self> {
        let dynamics = Dynamics::of(&loaded.mechanism).map_err(value)?;
        let (nq, nv) = (loaded.mechanism.coordinate_count(), dynamics.dof_count());
        Ok(Self { loaded: Arc::new(loaded), dynamics: Mutex::new(dynamics), nq, nv })
    }

    fn dynamics(&self) -> MutexGuard<'_, Dynamics> {
        self.dynamics.lock().unwrap_or_else(PoisonError::into_inner)
    }

    pub(crate) fn links(&self) -> &[Link] {
        &self.loaded.mechanism.bodies
    }

    /// Copies coordinates, and refuses coordinates that are invalid for the core.
    fn positions(&self, py: Python<'_>, q: &PyReadonlyArray2<'_, f64>) -> PyResult<Rows> {
        let q = Rows::of("q", q, self.nq)?;
        let single = q.single();
        in_pieces(py, q.count, |rows| {
            let dynamics = self.dynamics();
            for row in rows {
                dynamics.check(single.row(row), (row, q.count)).map_err(value)?;
            }
            Ok(())
        })?;
        Ok(q)
    }

    /// Returns a number for each dof. All dofs of a joint have the same number.
    fn by_dof(&self, of_link: impl Fn(&Link) -> f64) -> Vec<f64> {
        let each = |link: &Link| std::iter::repeat_n(of_link(link), link.joint.kind().dof_count());
        self.links().iter().flat_map(each).collect()
    }

    /// Returns the lower (`end` 0) or upper (1) end of each dof's range; `missing` for dofs without a range.
    fn range_ends(&self, end: usize, missing: f64) -> Vec<f64> {
        let of_link = |link: &Link| -> Vec<f64> {
            let has_axes = matches!(
                link.joint,
                JointModel::Revolute(_) | JointModel::Prismatic(_) | JointModel::Universal(_)
            );
            let axis = |k: usize| {
                link.ranges.get(k).filter(|_| has_axes).map_or(missing, |range| range[end])
            };
            (0..link.joint.kind().dof_count()).map(axis).collect()
        };
        self.links().iter().flat_map(of_link).collect()
    }
}

#[pymethods]
impl NativeRig {
    #[getter]
    fn name(&self) -> &str {
        &self.loaded.description.name
    }

    #[getter]
    fn notes(&self) -> Vec<String> {
        let doubts = self.loaded.doubts.iter().map(ToString::to_string);
        self.loaded.notes.iter().cloned().chain(doubts).collect()
    }

    #[getter]
    fn nq(&self) -> usize {
        self.nq
    }

    #[getter]
    fn nv(&self) -> usize {
        self.nv
    }

    #[getter]
    fn crc(&self) -> u32 {
        rig_hash(&self.loaded.description, &self.loaded.mechanism).0
    }

    #[getter]
    fn body_names(&self) -> Vec<String> {
        self.links().iter().map(|link| link.name.clone()).collect()
    }

    #[getter]
    fn joint_names(&self) -> Vec<String> {
        self.links().iter().map(|link| link.joint_name.clone()).collect()
    }

    #[getter]
    fn dof_names(&self) -> Vec<String> {
        self.loaded.mechanism.dof_names()
    }

    #[getter]
    fn joint_kinds(&self) -> Vec<&'static str> {
        let kind = |link: &Link| match link.joint {
            JointModel::Fixed => "fixed",
            JointModel::Revolute(_) => "revolute",
            JointModel::Prismatic(_) => "prismatic",
            JointModel::Universal(_) => "universal",
            JointModel::Spherical => "spherical",
            JointModel::Free => "free",
        };
        self.links().iter().map(kind).collect()
    }

    #[getter]
    fn parents(&self) -> Vec<Option<usize>> {
        self.links().iter().map(|link| link.parent).collect()
    }

    #[getter]
    fn followers(&self) -> Vec<(usize, usize, f64, f64)> {
        let ties = self.loaded.mechanism.ties();
        let tie = |tie: &Tie| {
            let [own, leader] = tie.places();
            (own, leader, tie.factor, tie.offset)
        };
        ties.each().map(tie).collect()
    }

    fn toml(&self) -> String {
        toml_file::write(&self.loaded.description)
    }

    fn home(&self) -> Vec<f64> {
        self.loaded.mechanism.home()
    }

    fn mass_kg(&self) -> Vec<f64> {
        self.links().iter().map(|link| link.mass_kg).collect()
    }

    fn lower(&self) -> Vec<f64> {
        self.range_ends(0, f64::NEG_INFINITY)
    }

    fn upper(&self) -> Vec<f64> {
        self.range_ends(1, f64::INFINITY)
    }

    fn speed(&self) -> Vec<f64> {
        self.by_dof(|link| link.speed)
    }

    fn acceleration(&self) -> Vec<f64> {
        self.by_dof(|link| link.acceleration)
    }

    fn effort(&self) -> Vec<f64> {
        self.by_dof(|link| link.effort)
    }

    fn fk<'py>(
        &self,
        py: Python<'py>,
        q: PyReadonlyArray2<'py, f64>,
    ) -> PyResult<Bound<'py, PyArray3<f64>>> {
        let q = self.positions(py, &q)?;
        let mut out = Vec::with_capacity(q.count * self.links().len() * 7);
        in_pieces(py, q.count, |rows| {
            for row in rows {
                for Pose { rotation, position_m } in self.loaded.mechanism.poses(q.row(row)) {
                    out.extend(position_m.to_array());
                    out.extend(rotation.to_array());
                }
            }
            Ok(())
        })?;
        array(py, [q.count, self.links().len(), 7], out)
    }

    fn jacobian<'py>(
        &self,
        py: Python<'py>,
        q: PyReadonlyArray2<'py, f64>,
        body: usize,
        point: [f64; 3],
    ) -> PyResult<Bound<'py, PyArray3<f64>>> {
        if body >= self.links().len() {
            return Err(value(format!(
                "body: expected 0 to {}, found {body}",
                self.links().len() - 1
            )));
        }
        if let Some(bad) = point.iter().find(|x| !x.is_finite()) {
            return Err(value(format!("point: expected three finite numbers, found {bad}")));
        }
        let q = self.positions(py, &q)?;
        let (nv, point_m) = (self.nv, DVec3::from_array(point));
        let mut out = Vec::with_capacity(q.count * 6 * nv);
        in_pieces(py, q.count, |rows| {
            for row in rows {
                let columns = columns(&self.loaded.mechanism, q.row(row), body, point_m);
                for k in 0..6 {
                    out.extend(columns.iter().map(
                        |[linear, angular]| {
                            if k < 3 { linear[k] } else { angular[k - 3] }
                        },
                    ));
                }
            }
            Ok(())
        })?;
        array(py, [q.count, 6, nv], out)
    }

    fn inverse_dynamics<'py>(
        &self,
        py: Python<'py>,
        q: PyReadonlyArray2<'py, f64>,
        qd: PyReadonlyArray2<'py, f64>,
        qdd: PyReadonlyArray2<'py, f64>,
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let count = count_rows("q", &q, self.nq)?;
        for (name, array) in [("qd", &qd), ("qdd", &qdd)] {
            expect_rows(name, count_rows(name, array, self.nv)?, count)?;
        }
        let mut out = Vec::with_capacity(count * self.nv);
        let mut piece = Piece::default();
        for start in (0..count).step_by(Piece::ROWS) {
            // Python's global lock prevents other threads from changing the arrays.
            piece.fill([&q, &qd, &qdd], start..(start + Piece::ROWS).min(count));
            py.detach(|| self.dynamics().efforts(&piece, count, &mut out)).map_err(value)?;
            py.check_signals()?;
        }
        array(py, [count, self.nv], out)
    }

    /// Computes the efforts of a single row; `None` unless all arguments are contiguous arrays of float64 with one
    /// axis.
    fn inverse_dynamics_of_row<'py>(
        &self,
        py: Python<'py>,
        q: &Bound<'py, PyAny>,
        qd: &Bound<'py, PyAny>,
        qdd: &Bound<'py, PyAny>,
    ) -> PyResult<Option<Bound<'py, PyArray1<f64>>>> {
        let given = [("q", q, self.nq), ("qd", qd, self.nv), ("qdd", qdd, self.nv)];
        let mut motion = [const { Vec::new() }; 3];
        for ((name, array, width), row) in given.into_iter().zip(&mut motion) {
            // A `PyReadonlyArray` costs more time than this copy.
            let array = array.cast::<PyArray1<f64>>().ok().map(PyArrayMethods::to_vec);
            let Some(Ok(array)) = array else { return Ok(None) };
            check_width(name, array.len(), width)?;
            row.extend(array.into_iter().map(single));
        }
        let mut dynamics = self.dynamics();
        let motion = motion.each_ref().map(Vec::as_slice);
        let efforts = dynamics.row_efforts(motion, (0, 1)).map_err(value)?;
        let efforts: Vec<f64> = efforts.iter().copied().map(f64::from).collect();
        Ok(Some(PyArray1::from_slice(py, &efforts)))
    }

    fn forward_dynamics<'py>(
        &self,
        py: Python<'py>,
        q: PyReadonlyArray2<'py, f64>,
        qd: PyReadonlyArray2<'py, f64>,
        tau: PyReadonlyArray2<'py, f64>,
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let (nq, nv) = (self.nq, self.nv);
        let [q, qd, tau] =
            [Rows::of("q", &q, nq)?, Rows::of("qd", &qd, nv)?, Rows::of("tau", &tau, nv)?];
        qd.expect("qd", q.count)?;
        tau.expect("tau", q.count)?;
        let count = q.count;
        let [q, qd, tau] = [q, qd, tau].map(|rows| rows.single());
        let mut out = Vec::with_capacity(count * nv);
        in_pieces(py, count, |rows| {
            let dynamics = self.dynamics();
            for row in rows {
                dynamics.accelerations([&q, &qd, &tau], (row, count), &mut out).map_err(value)?;
            }
            Ok(())
        })?;
        array(py, [count, nv], out)
    }

    fn mass_matrix<'py>(
        &self,
        py: Python<'py>,
        q: PyReadonlyArray2<'py, f64>,
    ) -> PyResult<Bound<'py, PyArray3<f64>>> {
        let (nq, nv) = (self.nq, self.nv);
        let q = Rows::of("q", &q, nq)?;
        let (count, q) = (q.count, q.single());
        let mut out = Vec::with_capacity(count * nv * nv);
        in_pieces(py, count, |rows| {
            let dynamics = self.dynamics();
            for row in rows {
                dynamics.mass_matrix(&q, (row, count), &mut out).map_err(value)?;
            }
            Ok(())
        })?;
        array(py, [count, nv, nv], out)
    }
}
