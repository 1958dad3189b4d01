//! A prim's own transform: `xformOpOrder` and its operations.

use glam::{DMat4, DQuat, DVec3};

use super::layer::{Attribute, Prim, Value};

/// A prim's own transform, and whether it leaves those above it out; the name of an operation that is not known as an error.
pub(super) fn local(prim: &Prim, time: Option<f64>) -> Result<(DMat4, bool), String> {
    let mut matrix = DMat4::IDENTITY;
    let mut reset = false;
    for op in prim.texts("xformOpOrder").unwrap_or_default() {
        if op == "!resetXformStack!" {
            (matrix, reset) = (DMat4::IDENTITY, true);
            continue;
        }
        let (name, inverse) = op
            .strip_prefix("!invert!")
            .map_or((op.as_str(), false), |name| (name, true));
        let numbers = match prim.attributes.get(name).map(|a: &Attribute| a.at(time)) {
            Some(Some(Value::Numbers(numbers))) => numbers.as_slice(),
            // An operation without a value does nothing.
            _ => continue,
        };
        let kind = name.split(':').nth(1).unwrap_or_default();
        let one = operation(kind, numbers).ok_or_else(|| op.clone())?;
        if inverse && one.determinant() == 0.0 {
            return Err(op.clone());
        }
        matrix *= if inverse { one.inverse() } else { one };
    }
    Ok((matrix, reset))
}

/// One operation on column vectors: USD's row vectors see its matrix transposed, which is the order that columns are written in here.
fn operation(kind: &str, numbers: &[f64]) -> Option<DMat4> {
    let axis = |axis: u8, deg: f64| {
        let rad = deg.to_radians();
        match axis {
            b'X' => DMat4::from_rotation_x(rad),
            b'Y' => DMat4::from_rotation_y(rad),
            _ => DMat4::from_rotation_z(rad),
        }
    };
    match (kind, numbers) {
        ("translate", &[x, y, z]) => Some(DMat4::from_translation(DVec3::new(x, y, z))),
        ("scale", &[x, y, z]) => Some(DMat4::from_scale(DVec3::new(x, y, z))),
        ("rotateX" | "rotateY" | "rotateZ", &[deg]) => Some(axis(kind.as_bytes()[6], deg)),
        ("rotateXYZ" | "rotateXZY" | "rotateYXZ" | "rotateYZX" | "rotateZXY" | "rotateZYX", &[x, y, z]) => {
            // The first letter's turn comes first, so it stands rightmost.
            let turns = kind.as_bytes()[6..].iter().rev().map(|letter| {
                let deg = [x, y, z][usize::from(letter - b'X')];
                axis(*letter, deg)
            });
            Some(turns.product())
        }
        ("orient", &[w, x, y, z]) => {
            let turn = DQuat::from_xyzw(x, y, z, w);
            (turn.length_squared() > 0.0).then(|| DMat4::from_quat(turn.normalize()))
        }
        ("transform", _) => {
            let matrix: [f64; 16] = numbers.try_into().ok()?;
            Some(DMat4::from_cols_array(&matrix))
        }
        _ => None,
    }
}
