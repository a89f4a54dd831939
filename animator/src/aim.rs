//! Rotations from a direction and `up`.

use glam::{DMat3, DVec3};

/// The rotation that takes z to `z` and keeps y as near to `up` as it can. `None` where either has no length or they are
/// parallel to within 1e-6 rad.
pub(crate) fn facing(z: DVec3, up: DVec3) -> Option<DMat3> {
    let z = z.try_normalize()?;
    let across = up.try_normalize()?.cross(z);
    if across.length() <= 1e-6 {
        return None;
    }
    let x = across.try_normalize()?;
    Some(DMat3::from_cols(x, z.cross(x), z))
}

/// What is left of a transform without scale and shear: z keeps its direction, y its side of z, and x follows, so that a
/// mirrored transform still gives a rotation. `None` if it is singular.
pub(crate) fn rotation_of(m: DMat3) -> Option<DMat3> {
    let z = m.z_axis.try_normalize()?;
    let y = m.y_axis.try_normalize()?;
    let y = (y - z * z.dot(y)).try_normalize()?;
    Some(DMat3::from_cols(y.cross(z), y, z))
}
