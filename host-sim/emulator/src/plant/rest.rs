//! Where hammer and cart rest, on a level rig and on a tilted one.

use numerics::root::halved;
use shared::model::params::{RigParams, SupportParams};
use shared::model::rig::Rig;

use crate::bodies::BodiesState;
use crate::shaker::Loop;

/// `params` with the part of gravity that a tilted rig's hammer hangs in.
pub(super) fn upright(params: &RigParams, tilt_rad: f64) -> RigParams {
    let mut params = *params;
    if let SupportParams::Wires {
        gravity_m_per_s2, ..
    } = &mut params.support
    {
        *gravity_m_per_s2 *= tilt_rad.cos();
    }
    params
}

/// Hammer and cart at rest while the drive is off and gravity pulls with `along`.
pub(super) fn rest(rig: &Rig<f64>, shaker: &Loop, params: &RigParams, along: f64) -> BodiesState {
    let mut state = BodiesState {
        q: rig.rest(),
        ..BodiesState::default()
    };
    if along == 0.0 {
        return state;
    }
    // The hammer's acceleration falls along its travel, and steeply where it touches.
    let pulled = |q: f64| {
        let at = rig.kinematics(q, 0.0);
        let force = if at.delta > 0.0 {
            rig.force(&at, 0.0)
        } else {
            0.0
        };
        rig.acceleration(&at, 0.0, along, force)
    };
    let ends = (rig.coordinate_at(-0.05), rig.coordinate_at(0.05));
    let (low, high) = halved(ends, 200, |q| pulled(q) <= 0.0);
    state.q = 0.5 * (low + high);
    if let Loop::Force(gains) = shaker {
        let cart_n = along * (params.cart_mass_kg + params.mass_kg);
        let armature_n = gains.armature.map_or(0.0, |a| along * a.mass_kg);
        state.z = gains.compliance() * (cart_n + armature_n);
        state.y = state.z + gains.armature.map_or(0.0, |a| cart_n / a.stiffness);
    }
    state
}
