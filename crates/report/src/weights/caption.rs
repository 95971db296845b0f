//! Names and colours of the methods.

use sinew_pose_metrics::weights::Method;

/// Returns the CSS class of a method's colour.
pub(super) const fn class(method: Method) -> &'static str {
    match method {
        Method::Lengths => "by-lengths",
        Method::Cylinders => "by-cylinders",
        Method::Mesh => "by-mesh",
    }
}

/// Returns a short description of a method.
pub(super) const fn caption(method: Method) -> &'static str {
    match method {
        Method::Lengths => "by lengths of the bones below",
        Method::Cylinders => "by surfaces of the bones below",
        Method::Mesh => "by the skin that the joint moves",
    }
}
