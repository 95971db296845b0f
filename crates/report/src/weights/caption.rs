//! How methods are called and coloured.

use sinew_pose_metrics::weights::Method;

/// The class of a method's colour.
pub(super) const fn class(method: Method) -> &'static str {
    match method {
        Method::Lengths => "by-lengths",
        Method::Cylinders => "by-cylinders",
        Method::Mesh => "by-mesh",
    }
}

/// What the method weighs, in a few words.
pub(super) const fn caption(method: Method) -> &'static str {
    match method {
        Method::Lengths => "by lengths of bones below",
        Method::Cylinders => "by surfaces of bones below",
        Method::Mesh => "by the skin that moves",
    }
}
