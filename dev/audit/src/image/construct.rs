//! Values that are built and checked before the loop.

use core::hint::black_box;
use core::num::NonZeroU16;

use sinew_core::bandwidth::Bandwidth;
use sinew_core::control::{ControlLaw, Gains, TorqueLimit};
use sinew_core::dynamics::{OuterJoints, reflected_inertia};
use sinew_core::glam::Vec3;
use sinew_core::importance::{
    Importance, MeshSurface, RestPose, SurfaceSamples, cylinder_samples, cylinder_surface,
    descendants_length,
};
use sinew_core::observer::{Observer, ObserverSettings};
use sinew_core::pose_space::{LineWorkspace, PoseSpace};
use sinew_core::projection::{BodyWeight, BodyWeights, ManifoldProjection, ProjectionWorkspace};
use sinew_core::state_error::{Aims, Compensation, Method, References};
use sinew_core::supply::TorqueSupply;
use sinew_core::{BodySet, Inertia, JointState, RotationalInertia, TorqueController, Tree, Twist};

use super::{N, body, desired, gains, measured, slice, slice_mut, tree};

#[inline(never)]
pub(crate) fn trees() {
    let mut tree = black_box(Tree::<N>::new());
    black_box(&tree.push(body()));
    let inertia = RotationalInertia::diagonal(black_box(1.0), black_box(1.0), black_box(1.0));
    black_box((inertia.mul_vec3(black_box(Vec3::X)), inertia.is_finite()));
    black_box(&Inertia::of_box(black_box(1.0), black_box(Vec3::X), black_box(Vec3::ONE)));
    black_box(&Tree::<N>::from_bodies(slice()));
    black_box((tree.len(), tree.is_empty(), tree.parent(black_box(1))));
    black_box((tree.supporters(black_box(1)), tree.subtree(black_box(1))));
    black_box((tree.children(black_box(1)), tree.is_leaf(black_box(1))));
    black_box((tree.is_ancestor(black_box(1), black_box(2)), tree.leaves().max()));
    let mut set = black_box(slice::<usize>().iter().copied().collect::<BodySet>());
    set.insert(black_box(1));
    black_box((set.contains(black_box(1)), set.len(), set.is_empty(), set.iter().max()));
}

fn method() -> Method<N> {
    let tree = tree();
    match black_box(0) {
        0 => Method::Local,
        1 => Method::World,
        2 => Method::Accumulated(References::egocentric(&tree)),
        3 => Method::Accumulated(References::of_ancestor(&tree, black_box(1))),
        4 => Method::Accumulated(References::generations(&tree, black_box(1))),
        5 => Method::LinearCompensation {
            aims: Aims::heaviest_child(&tree),
            settings: black_box(Compensation::default()),
        },
        6 => Method::LinearCompensation {
            aims: Aims::all_children(&tree),
            settings: black_box(Compensation::default()),
        },
        _ => Method::ResolvedAcceleration { weights: BodyWeights::rotations(&tree) },
    }
}

/// Returns a controller with every setting, all unknown to the compiler.
pub(crate) fn controller() -> Option<TorqueController<N>> {
    let tree = tree();
    let inertias = reflected_inertia(&tree, &measured(), black_box(OuterJoints::Free));
    TorqueController::new(tree, gains()?, black_box(method()))
        .ok()?
        .with_gravity(black_box(Vec3::ZERO))
        .ok()?
        .with_joint_gains(slice())
        .ok()?
        .with_limits(slice())
        .ok()?
        .with_inertia_scaled_pd(&black_box(inertias))
        .ok()?
        .with_law(black_box(ControlLaw::InverseDynamics))
        .ok()
        .map(black_box)
}

/// Returns a supply with weights, all unknown to the compiler.
pub(crate) fn supply() -> Option<TorqueSupply<N>> {
    let supply = TorqueSupply::new(&tree(), black_box(1.0)).ok()?;
    if black_box(true) { supply.with_weights(slice()).ok() } else { Some(supply) }.map(black_box)
}

#[inline(never)]
pub(crate) fn controllers() {
    black_box(&controller());
    let tree = tree();
    black_box(&References::new(&tree, slice()));
    black_box(&Aims::new(&tree, slice()));
    black_box(&BodyWeights::new(&tree, slice()));
    black_box(&Gains::new(black_box(1.0), black_box(1.0)));
    if let Some(gains) = gains() {
        black_box(&gains.with_linear(black_box(1.0), black_box(1.0)));
        black_box(&gains.implicit(black_box(1.0)));
    }
    black_box(&TorqueLimit::new(black_box(1.0), black_box(1.0)));
    let state = black_box(JointState::default());
    let mut targets = desired();
    black_box(&targets.set(black_box(1), state, black_box(Twist::ZERO)));
    black_box(&targets.set_velocity(black_box(1), black_box(Twist::ZERO)));
    black_box(&measured().set(black_box(1), state));
}

#[inline(never)]
pub(crate) fn importance() {
    black_box(&Importance::<N>::new(slice()).map(|importance| importance.normalised()));
    black_box(&RestPose::of_tree(&tree()));
    let Ok(pose) = RestPose::<N>::new(slice(), slice()) else { return };
    let pose = black_box(pose);
    black_box((pose.len(), pose.parent(black_box(1)), pose.position_m(black_box(1))));
    black_box(pose.descendants(black_box(1)));
    let (base, points) = (black_box(1.0), black_box(NonZeroU16::MIN));
    black_box(&descendants_length(&pose, base, black_box(1.0)));
    black_box(&cylinder_surface(&pose, slice(), base));
    let samples = black_box(SurfaceSamples::new(black_box(1)));
    black_box(&cylinder_samples(&pose, slice(), base, points, samples));
    black_box(&cylinder_samples(&pose, slice(), base, points, slice().iter().copied()));
    let Ok(surface) = MeshSurface::new(pose, base) else { return };
    let mut surface = black_box(surface);
    black_box(&surface.add(black_box(Vec3::X), black_box(1.0), slice()));
    let Ok(importance) = surface.importance() else { return };
    black_box(importance.as_slice());
    black_box(&BodyWeights::by_importance(&tree(), black_box(0.5), &importance));
}

#[inline(never)]
pub(crate) fn pose_space() {
    let tree = tree();
    let Ok(space) = PoseSpace::new(&tree).with_weights(slice()) else { return };
    let space = black_box(space).with_root();
    black_box((space.tree(), space.dimensions(), &space.bone_lengths_m()));
    let Ok(pose) = space.coordinates(slice()) else { return };
    let pose = black_box(pose);
    black_box(pose.as_slice());
    space.joint_poses(&pose, slice_mut());
    let bodies = black_box(space.body_poses(&pose));
    black_box((bodies.as_slice(), bodies.positions_m().count()));
    let rotations = black_box(space.joint_rotations(&pose));
    black_box((
        space.angle_distance(&pose, &pose),
        space.rotation_distance(&rotations, &rotations),
    ));
    black_box(space.position_distance(&bodies, &bodies));
    let mut workspace = LineWorkspace::new();
    black_box(space.line_distance(&pose, &pose, black_box(10), &mut workspace));
    black_box((space.curve_energy(slice()), space.curve_length(slice())));
    space.jacobian_column(&bodies, black_box(1), black_box(Twist::ZERO), slice_mut());
    space.metric_product(&bodies, slice(), slice_mut());
    black_box(space.metric_trace(&bodies));
    space.energy_gradient(&bodies, &bodies, &bodies, slice_mut());
    space.in_coordinates(&pose, slice(), slice_mut());
    black_box(&space.on_line(&pose, &pose, black_box(0.5)));
    black_box(&space.moved(&pose, slice()));
}

#[inline(never)]
pub(crate) fn projections() {
    let tree = tree();
    let weights: &[BodyWeight] = slice();
    let Ok(projection) = ManifoldProjection::new(&tree, weights) else { return };
    let projection = black_box(projection).with_root_held().with_sweeps(black_box(1));
    let Ok(projection) = black_box(projection).with_ranges(&tree, slice()) else { return };
    let Ok(projection) = black_box(projection).with_weights(&tree, slice()) else { return };
    let mut workspace = black_box(ProjectionWorkspace::new());
    black_box(&black_box(projection).project(&tree, slice(), &mut workspace, slice_mut()));
    workspace.reset();
    black_box(&workspace);
}

#[inline(never)]
pub(crate) fn observers() {
    let [gear, rotor, load, dt_s] = black_box([1.0; 4]);
    let _ = black_box(Bandwidth::of_gear(gear, rotor, dt_s));
    let _ = black_box(Bandwidth::of_loaded_gear(gear, rotor, load, dt_s));
    let (tree, state) = (tree(), measured());
    let Ok(settings) = ObserverSettings::extended_state(black_box(1.0), black_box(1.0)) else {
        return;
    };
    let Ok(settings) = settings.with_disturbance_limits(black_box(1.0), black_box(1.0)) else {
        return;
    };
    black_box(&ObserverSettings::differences(black_box(1.0)));
    let Ok(observer) = Observer::<N, 3>::new(settings, &state, black_box(1)) else { return };
    let mut observer = black_box(observer);
    black_box(&observer.observe(&tree, slice()));
    observer.compensate(&mut desired());
    observer.record_commands(slice(), slice());
    observer.restart(&state);
    observer.reset(&state);
    black_box((observer.states(), observer.disturbances()));
}
