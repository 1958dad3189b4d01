//! From a layer's prims to strands: bases, widths, painted primvars.

use glam::{DMat4, DVec3, Vec3};

use super::super::{GroomBuilder, GroomError, LoadedGroom, MAX_POINTS, UnitSource};
use super::basis::{Basis, Shape, Wrap};
use super::layer::{Layer, Prim};
use super::paint::{Paint, Remarks};
use super::primvar::{Place, Primvar};
use super::transform::local;
use super::{LoadedUsd, PaintedValues, ReadOptions};
use crate::param::{LobeRatios, PigmentSet, PointValues};

/// All curves of a layer, y up. Metres per unit are those of the options, else of the layer, else those that the format prescribes, else
/// guessed from the size.
pub(in crate::groom) fn collect(
    layer: &Layer,
    name: &str,
    options: ReadOptions,
    prescribed: Option<f32>,
) -> Result<LoadedUsd, GroomError> {
    let mut reader = Collector {
        layer,
        name,
        time: options.time,
        builder: GroomBuilder::new(),
        curves: 0,
        control_points: 0,
        kept: 0,
        points: Vec::new(),
        painted_prims: 0,
        unpainted_prims: 0,
        pigments: None,
        remarks: Remarks::default(),
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
    for note in &layer.notes {
        reader.builder.note(note.clone());
    }
    reader.finish(options, prescribed)
}

struct Collector<'a> {
    layer: &'a Layer,
    name: &'a str,
    time: Option<f64>,
    builder: GroomBuilder,
    curves: usize,
    control_points: usize,
    /// Points kept so far.
    kept: usize,
    /// Their values once a prim is painted; usual ones where a prim brings none.
    points: Vec<(PointValues, LobeRatios)>,
    painted_prims: usize,
    unpainted_prims: usize,
    /// The pigments of the painted prims so far.
    pigments: Option<PigmentSet>,
    remarks: Remarks,
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
        let path = self.layer.path(index);
        let widths = self.widths(prim, &path, &shapes);
        let paint = Paint::of(prim, &path, self.time, &shapes, &mut self.remarks);
        self.count_paint(paint.as_ref());

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
        if paint.is_some() {
            self.points.resize(self.kept, <_>::default());
        }
        let (mut first, mut first_varying) = (0, 0);
        let mut kept = Vec::new();
        for (curve, shape) in shapes.iter().copied().enumerate() {
            let place = |(segment, t)| Place {
                curve,
                shape,
                first,
                first_varying,
                segment,
                t,
            };
            let control = |i: usize| std::array::from_fn(|c| points[3 * (first + i) + c]);
            let strand = shape.samples().map(|(s, t)| -> (Vec3, Option<f32>) {
                let width = widths.as_ref().map(|widths| widths.at(&place((s, t))));
                (
                    placed(shape.at(s, t, control)),
                    width.map(|[w]| (w * scale) as f32),
                )
            });
            self.builder.push_strand_noting(strand, &mut kept);
            self.kept += kept.len();
            if let Some(paint) = &paint {
                // Values for the points that were kept: both lists ascend.
                let mut samples = shape.samples().enumerate();
                let places = kept.iter().filter_map(|point| samples.find(|(i, _)| i == point));
                self.points
                    .extend(places.map(|(_, sample)| paint.at(&place(sample))));
            }
            first += shape.count;
            first_varying += shape.varying();
        }
        self.curves += shapes.len();
        self.control_points += points.len() / 3;
        if self.control_points > MAX_POINTS {
            return Err(self.refused(index, "too many points"));
        }
        Ok(())
    }

    /// The widths, where the prim has some that can be used.
    fn widths<'p>(&mut self, prim: &'p Prim, path: &str, shapes: &[Shape]) -> Option<Primvar<'p>> {
        let name = if prim.attributes.contains_key("primvars:widths") {
            "primvars:widths"
        } else {
            "widths"
        };
        Primvar::of(prim, name, 1, self.time, shapes).unwrap_or_else(|reason| {
            let remark = format!("{name} are not used: {reason}");
            self.remarks.add(path, remark);
            None
        })
    }

    /// Follows which prims are painted and with which pigments.
    fn count_paint(&mut self, paint: Option<&Paint<'_>>) {
        let Some(paint) = paint else {
            self.unpainted_prims += 1;
            return;
        };
        self.painted_prims += 1;
        match (self.pigments, paint.pigments) {
            (Some(known), Some(other)) if known != other => {
                let remark = format!(
                    "the pigments {} are taken for {}, which stand in another prim of this file",
                    other.name(),
                    known.name()
                );
                self.remarks.add("balayage:pigments", remark);
            }
            (known, other) => self.pigments = known.or(other),
        }
    }

    fn finish(mut self, options: ReadOptions, prescribed: Option<f32>) -> Result<LoadedUsd, GroomError> {
        let stated = self.layer.metres_per_unit.map(|unit| unit as f32);
        if let (None, None, Some(unit)) = (stated, options.metres_per_unit, prescribed) {
            self.builder.note(format!(
                "no metersPerUnit is stated: {unit} as the format prescribes (--metres-per-unit states another)"
            ));
        }
        let given = options.metres_per_unit.map(|unit| (unit, UnitSource::Given));
        let unit = given.or_else(|| stated.or(prescribed).map(|unit| (unit, UnitSource::File)));
        if self.painted_prims > 0 && self.unpainted_prims > 0 {
            self.builder.note(format!(
                "{} prims of curves have no painted primvars: their points have the usual values",
                self.unpainted_prims
            ));
        }
        for remark in self.remarks.sentences() {
            self.builder.note(remark);
        }
        let (groom, report) = self.builder.finish(self.name, unit)?;
        let painted = (self.painted_prims > 0).then(|| {
            self.points.resize(self.kept, <_>::default());
            let (values, ratios) = self.points.into_iter().unzip();
            PaintedValues {
                values,
                ratios,
                pigments: self.pigments.unwrap_or_default(),
            }
        });
        Ok(LoadedUsd {
            loaded: LoadedGroom { groom, report },
            curves: self.curves,
            control_points: self.control_points,
            painted,
        })
    }
}
