//! Finds pelvis, chest, neck and head, between and beyond the limbs.

use super::body::Body;
use super::name::{Kind, Part};
use super::pair::Pair;

/// Joints of the trunk.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub(super) struct Trunk {
    pub pelvis: Option<usize>,
    pub chest: Option<usize>,
    pub neck: Option<usize>,
    pub head: Option<usize>,
}

impl Trunk {
    /// Finds the trunk between `legs` and `arms`.
    pub(super) fn find(body: &Body, legs: Option<&Pair>, arms: Option<&Pair>) -> Self {
        let pelvis =
            legs.and_then(|legs| legs.carrier(body)).map(|carrier| above_spine(body, carrier));
        let carrier = arms.and_then(|arms| arms.carrier(body));
        // In 3ds Max, clavicles are children of the neck. The chest is then the neck's parent, unless that is the
        // pelvis.
        let neck_carries = carrier.filter(|carrier| {
            body.names[*carrier].best() == Some(Part::Neck) && body.parent(*carrier) != pelvis
        });
        let chest = neck_carries.map_or(carrier, |neck| body.parent(neck));
        let uppers: Vec<usize> =
            legs.into_iter().chain(arms).flat_map(Pair::both).map(|limb| limb.joints[0]).collect();
        let head = head(body, carrier, &uppers);
        let neck = neck_carries.or_else(|| {
            let way = body.way(body.common_ancestor(carrier?, head?), head?);
            let named = way.iter().find(|joint| body.names[**joint].says(Part::Neck) > 0.0);
            named.or_else(|| way.split_last()?.1.first()).copied()
        });
        let chest = chest.or_else(|| chest_below(body, head?));
        let pelvis = pelvis.or_else(|| pelvis_by_name(body));
        Self { pelvis, chest, neck, head }
    }
}

/// Returns the joint that carries the hips: `carrier`, or its parent if the thighs are children of the spine (3ds
/// Max).
fn above_spine(body: &Body, carrier: usize) -> usize {
    let is_spine = body.names[carrier].best() == Some(Part::Spine);
    let parent = body.parent(carrier).filter(|parent| body.names[*parent].says(Part::Pelvis) > 0.8);
    parent.filter(|_| is_spine).unwrap_or(carrier)
}

/// Finds the head: by its name, otherwise at the end of the chain that leads from the chest between the arms. Returns
/// `None` if there is neither.
fn head(body: &Body, chest: Option<usize>, uppers: &[usize]) -> Option<usize> {
    let in_limb = |joint: usize| uppers.iter().any(|upper| body.hangs_on(joint, *upper));
    let carries_limb = |joint: usize| uppers.iter().any(|upper| body.hangs_on(*upper, joint));
    let says_head = |joint: &usize| {
        let name = &body.names[*joint];
        name.kind == Kind::Body && name.says(Part::Head) > 0.0
    };
    let mut named = (0..body.count()).filter(says_head);
    let named = named.find(|joint| !in_limb(*joint) && !carries_limb(*joint));
    if named.is_some() {
        return named;
    }
    let chest = chest?;
    let leads_on = |joint: usize| match body.names[joint].kind {
        Kind::Body | Kind::Twist => true,
        Kind::Helper => (joint..body.count())
            .any(|below| body.names[below].kind == Kind::Body && body.hangs_on(below, joint)),
        Kind::Finger | Kind::Face | Kind::End | Kind::Animal => false,
    };
    let goes_on = |joint: &usize| {
        !carries_limb(*joint)
            && !body.is_end[*joint]
            && body.names[*joint].side.is_none()
            && leads_on(*joint)
    };
    let on =
        |joint: usize| body.children[joint].iter().copied().filter(goes_on).collect::<Vec<_>>();
    let length = |joint: &usize| body.lengths[*joint] + body.below[*joint];
    let mut head = on(chest).into_iter().max_by(|a, b| length(a).total_cmp(&length(b)))?;
    // A head carries a face, or nothing; a single child is therefore the head.
    while let [only] = on(head)[..] {
        head = only;
    }
    Some(head)
}

/// Finds the chest of a body without arms: the last joint on the path to the head that is called chest or spine.
fn chest_below(body: &Body, head: usize) -> Option<usize> {
    body.upwards(head).skip(1).find(|joint| {
        let name = &body.names[*joint];
        name.says(Part::Chest) > 0.0 || name.says(Part::Spine) > 0.0
    })
}

fn pelvis_by_name(body: &Body) -> Option<usize> {
    (0..body.count()).find(|joint| body.names[*joint].says(Part::Pelvis) > 0.8)
}

/// Finds the ball of the foot beyond the ankle: by its name, otherwise as the bone that continues. Returns `None` if
/// there is neither.
pub(super) fn toe(body: &Body, ankle: usize) -> Option<usize> {
    let below: Vec<usize> = (ankle + 1..body.count())
        .filter(|joint| body.hangs_on(*joint, ankle) && !body.is_end[*joint])
        .filter(|joint| !body.is_zero(body.length(ankle, *joint)))
        .filter(|joint| matches!(body.names[*joint].kind, Kind::Body | Kind::Twist))
        .collect();
    let length = |joint: &usize| body.length(ankle, *joint) + body.below[*joint];
    let says = |joint: &usize| body.names[*joint].says(Part::Toe);
    let best = below.iter().max_by(|a, b| says(a).total_cmp(&says(b)));
    if let Some(best) = best.map(says).filter(|best| *best > 0.0) {
        // Among five toes the longest is used, and among its joints the first.
        let is_best = |joint: usize| joint != ankle && says(&joint) >= best;
        let is_first = |joint: &&usize| {
            is_best(**joint) && body.parent(**joint).is_none_or(|parent| !is_best(parent))
        };
        return below
            .iter()
            .filter(is_first)
            .max_by(|a, b| length(a).total_cmp(&length(b)))
            .copied();
    }
    let silent =
        |joint: &&usize| body.parent(**joint) == Some(ankle) && body.names[**joint].is_silent();
    below.iter().filter(silent).max_by(|a, b| length(a).total_cmp(&length(b))).copied()
}
