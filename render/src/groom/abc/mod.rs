//! Alembic curves in: objects and properties of an Ogawa archive become the prims of a layer, and from there on it is as with USD.
//!
//! Read are curves (linear, Bezier, B-spline, Catmull-Rom) with their widths, and the transforms above them, all at their first sample.
//! NURBS, instances and other parameters are named in the report. Alembic knows no unit and no up axis: y is taken as up.
//!
//! | property of a curves object (`.geom`) | content |
//! |---|---|
//! | `P`, `nVertices` | points, points of every curve |
//! | `curveBasisAndType` | type (0 cubic, 1 linear, 2 NURBS), wrap (1 periodic), basis (1 Bezier, 2 B-spline, 3 Catmull-Rom, 4 Hermite, 5 power) |
//! | `width` | values, or a compound of `.vals` and `.indices`; its metadata `geoScope` is the interpolation |

mod ogawa;

use glam::{DMat4, DVec3};

use super::usd::{Attribute, Layer, MAX_DEPTH, Prim, Value, collect};
use super::{GroomError, LoadedUsd, ReadOptions, bytes::FileBytes};
use ogawa::{Archive, Group, Object, Property, REMEDY, named};

/// Reads the curves of an Alembic file from memory; `name` is for messages.
///
/// # Errors
/// [`GroomError::Format`] for bytes that break the format, [`GroomError::Refused`] when counts disagree or no strand is usable.
pub fn parse_abc(bytes: &[u8], name: &str, metres_per_unit: Option<f32>) -> Result<LoadedUsd, GroomError> {
    let archive = Archive::open(FileBytes { name, bytes })?;
    let root = archive.root;
    let mut reader = Reader {
        archive,
        layer: Layer::default(),
        moving: 0,
        instances: 0,
        nurbs: 0,
        unread: Vec::new(),
    };
    reader.objects(root, None, 0)?;
    let layer = reader.layer();
    let options = ReadOptions {
        metres_per_unit,
        time: None,
    };
    collect(&layer, name, options, None)
}

struct Reader<'a> {
    archive: Archive<'a>,
    layer: Layer,
    /// Curves with more than one sample.
    moving: usize,
    instances: usize,
    nurbs: usize,
    /// Names of parameters that are not read.
    unread: Vec<String>,
}

impl<'a> Reader<'a> {
    fn objects(&mut self, group: Group<'a>, parent: Option<usize>, depth: usize) -> Result<(), GroomError> {
        if depth > MAX_DEPTH {
            let reason = format!("objects are nested deeper than {MAX_DEPTH}");
            return Err(self.archive.file.error(0, reason, REMEDY));
        }
        for object in self.archive.children(group)? {
            if object.about("isInstance").is_some() {
                self.instances += 1;
                continue;
            }
            let mut prim = Prim {
                parent,
                name: object.name.clone(),
                visible: true,
                ..Prim::default()
            };
            let properties = self.archive.properties(object.group)?;
            let visible = self.archive.numbers(named(&properties, "visible"))?;
            prim.visible = visible.and_then(|values| values.first().copied()) != Some(0.0);
            match schema(&object) {
                Schema::Transform => self.transform(&properties, &mut prim)?,
                Schema::Curves => self.curves(&properties, &mut prim)?,
                Schema::Other => {}
            }
            self.layer.prims.push(prim);
            let index = self.layer.prims.len() - 1;
            self.objects(object.group, Some(index), depth + 1)?;
        }
        Ok(())
    }

    fn curves(&mut self, properties: &[Property<'a>], prim: &mut Prim) -> Result<(), GroomError> {
        let geometry = self.archive.parts(named(properties, ".geom"))?;
        let kind = self.archive.numbers(named(&geometry, "curveBasisAndType"))?;
        let at = |index: usize| {
            kind.as_ref()
                .and_then(|kind| kind.get(index))
                .map_or(0, |x| *x as u8)
        };
        if at(0) == 2 {
            self.nurbs += 1;
            return Ok(());
        }
        prim.type_name = "BasisCurves".to_owned();
        let basis = ["bezier", "bezier", "bspline", "catmullRom", "hermite", "power"];
        for (name, text) in [
            ("type", if at(0) == 1 { "linear" } else { "cubic" }),
            ("wrap", if at(1) == 1 { "periodic" } else { "nonperiodic" }),
            (
                "basis",
                basis.get(usize::from(at(2))).copied().unwrap_or("unknown"),
            ),
        ] {
            set(prim, name, Value::Texts(vec![text.to_owned()]));
        }
        let points = named(&geometry, "P");
        self.moving += usize::from(points.is_some_and(|points| points.samples > 1));
        for (name, property) in [
            ("points", points),
            ("curveVertexCounts", named(&geometry, "nVertices")),
        ] {
            if let Some(numbers) = self.archive.numbers(property)? {
                set(prim, name, Value::Numbers(numbers));
            }
        }
        if let Some(width) = named(&geometry, "width") {
            self.width(width, prim)?;
        }
        let others = self.archive.parts(named(&geometry, ".arbGeomParams"))?;
        self.unread.extend(others.iter().map(Property::name));
        Ok(())
    }

    fn width(&mut self, width: Property<'a>, prim: &mut Prim) -> Result<(), GroomError> {
        let parts = self.archive.parts(Some(width))?;
        let values = named(&parts, ".vals").unwrap_or(width);
        let Some(numbers) = self.archive.numbers(Some(values))? else {
            return Ok(());
        };
        let interpolation = match width.about("geoScope") {
            Some("con") => Some("constant"),
            Some("uni") => Some("uniform"),
            Some("var") => Some("varying"),
            Some("vtx") => Some("vertex"),
            _ => None,
        };
        prim.attributes.insert(
            "widths".to_owned(),
            Attribute {
                default: Some(Value::Numbers(numbers)),
                interpolation: interpolation.map(str::to_owned),
                ..Attribute::default()
            },
        );
        if let Some(indices) = self.archive.numbers(named(&parts, ".indices"))? {
            set(prim, "widths:indices", Value::Numbers(indices));
        }
        Ok(())
    }

    fn transform(&mut self, properties: &[Property<'a>], prim: &mut Prim) -> Result<(), GroomError> {
        let parts = self.archive.parts(named(properties, ".xform"))?;
        let inherits = self.archive.numbers(named(&parts, ".inherits"))?;
        let operations = self.archive.numbers(named(&parts, ".ops"))?.unwrap_or_default();
        let values = self.archive.numbers(named(&parts, ".vals"))?.unwrap_or_default();
        self.moving += usize::from(named(&parts, ".vals").is_some_and(|values| values.samples > 1));
        let Some(matrix) = composed(&operations, &values) else {
            let reason = format!("{}: its transform is not one that is read", prim.name);
            return Err(self
                .archive
                .file
                .error(0, reason, "bake the transforms and export again"));
        };
        set(
            prim,
            "xformOp:transform",
            Value::Numbers(matrix.to_cols_array().to_vec()),
        );
        let mut order = vec!["xformOp:transform".to_owned()];
        if inherits.and_then(|values| values.first().copied()) == Some(0.0) {
            order.insert(0, "!resetXformStack!".to_owned());
        }
        set(prim, "xformOpOrder", Value::Texts(order));
        Ok(())
    }

    /// The layer, with what was not read.
    fn layer(mut self) -> Layer {
        self.unread.sort();
        self.unread.dedup();
        self.unread.truncate(16);
        let notes = [
            (self.nurbs > 0).then(|| format!("{} objects of NURBS curves are not read", self.nurbs)),
            (self.instances > 0).then(|| format!("{} instances are not followed", self.instances)),
            (self.moving > 0).then(|| format!("{} objects move: their first sample is taken", self.moving)),
            (!self.unread.is_empty())
                .then(|| format!("the parameters {} are not read", self.unread.join(", "))),
        ];
        self.layer.notes = notes.into_iter().flatten().collect();
        self.layer
    }
}

enum Schema {
    Transform,
    Curves,
    Other,
}

fn schema(object: &Object<'_>) -> Schema {
    let schema = object.about("schema").unwrap_or_default();
    if schema.starts_with("AbcGeom_Xform") {
        Schema::Transform
    } else if schema.starts_with("AbcGeom_Curve") {
        Schema::Curves
    } else {
        Schema::Other
    }
}

fn set(prim: &mut Prim, name: &str, value: Value) {
    let attribute = Attribute {
        default: Some(value),
        ..Attribute::default()
    };
    prim.attributes.insert(name.to_owned(), attribute);
}

/// The product of a transform's operations, the last one nearest to the points; none where one is not known or lacks values.
///
/// The high half of an operation's byte is its kind: 0 scale, 1 translate, 2 rotate (axis and degrees), 3 matrix, 4 to 6 rotate about x, y, z.
fn composed(operations: &[f64], mut values: &[f64]) -> Option<DMat4> {
    let mut matrix = DMat4::IDENTITY;
    for operation in operations {
        let kind = *operation as u8 >> 4;
        let count = [3, 3, 4, 16, 1, 1, 1].get(usize::from(kind))?;
        let (own, rest) = values.split_at_checked(*count)?;
        values = rest;
        matrix *= match (kind, own) {
            (0, &[x, y, z]) => DMat4::from_scale(DVec3::new(x, y, z)),
            (1, &[x, y, z]) => DMat4::from_translation(DVec3::new(x, y, z)),
            (2, &[x, y, z, deg]) => {
                let axis = DVec3::new(x, y, z).try_normalize()?;
                DMat4::from_axis_angle(axis, deg.to_radians())
            }
            // Rows of a matrix for row vectors are columns of one for column vectors.
            (3, _) => DMat4::from_cols_array(own.try_into().ok()?),
            (4, &[deg]) => DMat4::from_rotation_x(deg.to_radians()),
            (5, &[deg]) => DMat4::from_rotation_y(deg.to_radians()),
            (6, &[deg]) => DMat4::from_rotation_z(deg.to_radians()),
            _ => return None,
        };
    }
    Some(matrix)
}
