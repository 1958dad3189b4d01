//! From a layer's prims to strands: transforms, bases, widths, painted primvars.

use glam::{DMat4, DQuat, DVec3, Vec3};

use super::super::{GroomBuilder, GroomError, LoadedGroom, MAX_POINTS, UnitSource};
use super::basis::{Basis, Shape, Wrap};
use super::layer::{Attribute, Layer, Prim, Value};
use super::{LoadedUsd, PaintedValues, UsdOptions};
use crate::param::{Channel, PigmentSet, PointValues};

/// `metersPerUnit` of a layer that states none, as the schema prescribes.
const USD_METRES_PER_UNIT: f32 = 0.01;

/// All curves of a layer, y up.
pub(super) fn collect(layer: &Layer, name: &str, options: UsdOptions) -> Result<LoadedUsd, GroomError> {
    let mut reader = Collector {
        layer,
        name,
        time: options.time,
        builder: GroomBuilder::new(),
        curves: 0,
        control_points: 0,
        painted: Some(Vec::new()),
        pigments: None,
    };
    // Parents stand before their children, so that one pass brings every transform down.
    let up = if layer.z_up {
        DMat4::from_cols_array(&[1., 0., 0., 0., 0., 0., -1., 0., 0., 1., 0., 0., 0., 0., 0., 1.])
    } else {
        DMat4::IDENTITY
    };
    let mut world = Vec::with_capacity(layer.prims.len());
    let mut skipped = 0;
    for (index, prim) in layer.prims.iter().enumerate() {
        let (above, visible) = match prim.parent {
            Some(parent) => world[parent],
            None => (up, true),
        };
        let visible = visible && prim.visible;
        let (local, reset) = local(prim, options.time).map_err(|op| {
            let reason = format!(
                "{}: the transform {op} is not one that is read",
                layer.path(index)
            );
            GroomError::refused(name, reason, "bake the transforms and export again")
        })?;
        world.push((if reset { up } else { above } * local, visible));
        match prim.type_name.as_str() {
            "BasisCurves" if visible => reader.curves(index, world[index].0)?,
            "NurbsCurves" | "HermiteCurves" => skipped += 1,
            _ => {}
        }
    }
    if skipped > 0 {
        reader
            .builder
            .note(format!("{skipped} prims of NURBS or Hermite curves are not read"));
    }
    if layer.not_followed > 0 {
        reader.builder.note(format!(
            "{} references, payloads, sublayers or variants are not followed (flatten the stage with usdcat --flatten)",
            layer.not_followed
        ));
    }
    reader.finish(options)
}

struct Collector<'a> {
    layer: &'a Layer,
    name: &'a str,
    time: Option<f64>,
    builder: GroomBuilder,
    curves: usize,
    control_points: usize,
    /// Painted values so far; none once a prim has none.
    painted: Option<Vec<PointValues>>,
    pigments: Option<PigmentSet>,
}

impl Collector<'_> {
    fn refused(&self, prim: usize, reason: &str) -> GroomError {
        GroomError::refused(
            self.name,
            format!("{}: {reason}", self.layer.path(prim)),
            "export the curves again",
        )
    }

    fn curves(&mut self, index: usize, world: DMat4) -> Result<(), GroomError> {
        let prim = &self.layer.prims[index];
        let points = prim.numbers("points", self.time).unwrap_or_default();
        let counts = prim.numbers("curveVertexCounts", self.time).unwrap_or_default();
        let total: f64 = counts.iter().sum();
        if !points.len().is_multiple_of(3)
            || counts.iter().any(|n| !(*n >= 0.0 && n.fract() == 0.0))
            || total != (points.len() / 3) as f64
        {
            let reason = format!(
                "curveVertexCounts add up to {total}, but there are {} points",
                points.len() as f64 / 3.0
            );
            return Err(self.refused(index, &reason));
        }
        let basis = match (prim.text("type"), prim.text("basis")) {
            (Some("linear"), _) => Basis::Linear,
            (Some("cubic") | None, Some("bezier") | None) => Basis::Bezier,
            (Some("cubic") | None, Some("bspline")) => Basis::BSpline,
            (Some("cubic") | None, Some("catmullRom")) => Basis::CatmullRom,
            (ty, basis) => {
                let reason = format!(
                    "curves of type {} and basis {} are not known",
                    ty.unwrap_or("cubic"),
                    basis.unwrap_or("bezier")
                );
                return Err(self.refused(index, &reason));
            }
        };
        let wrap = match prim.text("wrap") {
            None | Some("nonperiodic") => Wrap::NonPeriodic,
            Some("periodic") => Wrap::Periodic,
            Some("pinned") => Wrap::Pinned,
            Some(other) => return Err(self.refused(index, &format!("wrap \"{other}\" is not known"))),
        };
        let shapes: Vec<Shape> = counts
            .iter()
            .map(|n| Shape {
                basis,
                wrap,
                count: *n as usize,
            })
            .collect();
        let widths = self.widths(prim, &shapes);
        if matches!(widths, Widths::Unusable) {
            let path = self.layer.path(index);
            self.builder.note(format!(
                "{path}: the number of widths fits no interpolation; not used"
            ));
        }

        // A transform that does nothing leaves every bit as it is.
        let plain = world == DMat4::IDENTITY;
        let scale = if plain {
            1.0
        } else {
            world.determinant().abs().cbrt()
        };
        let placed = |p: [f64; 3]| {
            let p = DVec3::from_array(p);
            let p = if plain { p } else { world.transform_point3(p) };
            p.as_vec3()
        };
        let (mut first, mut first_varying) = (0, 0);
        for (curve, shape) in shapes.iter().enumerate() {
            let control = |i: usize| std::array::from_fn(|c| points[3 * (first + i) + c]);
            let strand = shape.samples().map(|(s, t)| -> (Vec3, Option<f32>) {
                let width = match widths {
                    Widths::None | Widths::Unusable => None,
                    Widths::Constant(w) => Some(w),
                    Widths::Uniform(w) => Some(w[curve]),
                    Widths::Vertex(w) => Some(shape.at(s, t, |i| [w[first + i]])[0]),
                    Widths::Varying(w) => {
                        let next = (s + 1) % shape.varying();
                        Some((1.0 - t) * w[first_varying + s] + t * w[first_varying + next])
                    }
                };
                (placed(shape.at(s, t, control)), width.map(|w| (w * scale) as f32))
            });
            self.builder.push_strand(strand);
            first += shape.count;
            first_varying += shape.varying();
        }
        self.paint(prim, basis, points.len() / 3);
        self.curves += shapes.len();
        self.control_points += points.len() / 3;
        if self.control_points > MAX_POINTS {
            return Err(self.refused(index, "too many points"));
        }
        Ok(())
    }

    /// The widths by the interpolation that they state, else by their number.
    fn widths<'p>(&self, prim: &'p Prim, shapes: &[Shape]) -> Widths<'p> {
        let name = if prim.attributes.contains_key("primvars:widths") {
            "primvars:widths"
        } else {
            "widths"
        };
        let Some(widths) = prim.numbers(name, self.time).filter(|w| !w.is_empty()) else {
            return Widths::None;
        };
        let vertex: usize = shapes.iter().map(|shape| shape.count).sum();
        let varying: usize = shapes.iter().map(|shape| shape.varying()).sum();
        let stated = prim.attributes[name].interpolation.as_deref();
        match (stated, widths.len()) {
            (Some("constant"), _) | (_, 1) => Widths::Constant(widths[0]),
            (Some("uniform"), n) if n == shapes.len() => Widths::Uniform(widths),
            (Some("varying"), n) if n == varying => Widths::Varying(widths),
            (_, n) if n == vertex => Widths::Vertex(widths),
            (_, n) if n == varying => Widths::Varying(widths),
            (_, n) if n == shapes.len() => Widths::Uniform(widths),
            _ => Widths::Unusable,
        }
    }

    /// Adds a prim's painted channels; all are needed, and only linear curves keep a value for every point.
    fn paint(&mut self, prim: &Prim, basis: Basis, count: usize) {
        let values = (basis == Basis::Linear)
            .then(|| painted(prim, self.time, count))
            .flatten();
        let pigments = prim.text("balayage:pigments").and_then(PigmentSet::from_name);
        let agreed = self.curves == 0 || self.pigments == pigments;
        self.pigments = pigments;
        self.painted = match (self.painted.take(), values) {
            (Some(mut all), Some(values)) if agreed => {
                all.extend(values);
                Some(all)
            }
            _ => None,
        };
    }

    fn finish(mut self, options: UsdOptions) -> Result<LoadedUsd, GroomError> {
        let stated = self.layer.metres_per_unit.map(|unit| unit as f32);
        if stated.is_none() && options.metres_per_unit.is_none() {
            self.builder.note(
                "no metersPerUnit is stated: 0.01 as the format prescribes (--metres-per-unit states another)",
            );
        }
        let unit = options.metres_per_unit.map_or_else(
            || (stated.unwrap_or(USD_METRES_PER_UNIT), UnitSource::File),
            |unit| (unit, UnitSource::Given),
        );
        let (groom, mut report) = self.builder.finish(self.name, Some(unit))?;
        // Dropped points leave values without a point.
        let painted = self.painted.filter(|values| !values.is_empty());
        let painted = match painted {
            Some(values) if values.len() == groom.point_count() => Some(PaintedValues {
                values,
                pigments: self.pigments.unwrap_or_default(),
            }),
            Some(_) => {
                report
                    .notes
                    .push("painted values are not used because points were dropped".into());
                None
            }
            None => None,
        };
        Ok(LoadedUsd {
            loaded: LoadedGroom { groom, report },
            curves: self.curves,
            control_points: self.control_points,
            painted,
        })
    }
}

#[derive(Clone, Copy)]
enum Widths<'a> {
    None,
    Unusable,
    Constant(f64),
    Uniform(&'a [f64]),
    Vertex(&'a [f64]),
    Varying(&'a [f64]),
}

/// The painted channels of a prim, where it has all of them for every point and none is out of its range.
fn painted(prim: &Prim, time: Option<f64>, count: usize) -> Option<Vec<PointValues>> {
    let mut values = vec![PointValues::default(); count];
    for channel in Channel::ALL {
        let numbers = prim.numbers(&super::write::primvar(channel), time)?;
        let width = channel.components();
        if numbers.len() != width * count {
            return None;
        }
        for (value, numbers) in values.iter_mut().zip(numbers.chunks_exact(width)) {
            let mut components = [0.0; 3];
            for (component, number) in components.iter_mut().zip(numbers) {
                *component = *number as f32;
            }
            value.set(channel, components);
        }
    }
    values
        .iter()
        .all(|value| value.out_of_range().is_none())
        .then_some(values)
}

/// A prim's own transform, and whether it leaves those above it out; the name of an operation that is not known as an error.
fn local(prim: &Prim, time: Option<f64>) -> Result<(DMat4, bool), String> {
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
