//! A groom and its painted values as USD text: one `BasisCurves` prim, linear, with vertex primvars.

use std::fmt::{Display, Write};

use super::super::{Groom, GroomError};
use super::{PaintedValues, check_values};
use crate::param::{Channel, LobeRatios};

/// Primvar of the tilts of TT and TRT over R's.
pub(super) const ALPHA_RATIOS: &str = "primvars:balayage:alpha_ratios";
/// Primvar of the widths of TT and TRT over R's.
pub(super) const BETA_RATIOS: &str = "primvars:balayage:beta_ratios";
/// Primvar of the absorption that the channels make.
pub(super) const SIGMA_A: &str = "primvars:balayage:sigma_a";
/// Attribute that names the pigments.
pub(super) const PIGMENTS: &str = "balayage:pigments";

/// Name of the primvar that holds `channel`.
pub(super) fn primvar(channel: Channel) -> String {
    format!("primvars:balayage:{}", channel.name())
}

/// The bytes of a `.usda` file that [`super::parse_usd`] reads back as an equal groom with equal values, bit for bit.
///
/// Painted channels are vertex primvars under `primvars:balayage`, with `sigma_a` (absorption per fibre radius, linear Rec.709) made of
/// them; `primvars:displayColor` is exp(-2 sigma_a), what light keeps of its colour on a way of one fibre diameter: a preview.
///
/// # Errors
/// [`GroomError::Refused`] when there is not a value for every point.
pub fn usda_bytes(groom: &Groom, painted: Option<&PaintedValues>) -> Result<Vec<u8>, GroomError> {
    if let Some(painted) = painted {
        check_values(groom, painted)?;
    }
    let mut out = String::with_capacity(64 * groom.point_count());
    let unit = groom.metres_per_unit();
    out += &format!(
        "#usda 1.0\n(\n    defaultPrim = \"hair\"\n    doc = \"Balayage\"\n    metersPerUnit = {unit}\n    upAxis = \"Y\"\n)\n\n\
         def Xform \"hair\" (\n    kind = \"component\"\n)\n{{\n    def BasisCurves \"strands\"\n    {{\n        uniform token type = \"linear\"\n        \
         uniform token wrap = \"nonperiodic\"\n"
    );
    let counts = (0..groom.strand_count()).map(|strand| groom.strand(strand).len());
    array(&mut out, "int[] curveVertexCounts", counts, "");
    let (low, high) = groom.bounds();
    let corners = [low, high].map(|p| tuple(p.to_array()));
    array(&mut out, "float3[] extent", corners, "");
    let positions = groom.positions().iter().map(|p| tuple(p.to_array()));
    array(&mut out, "point3f[] points", positions, "");

    // One width where all are equal.
    let diameters = groom.diameters();
    if diameters.iter().all(|d| *d == diameters[0]) {
        array(&mut out, "float[] widths", [diameters[0]], "constant");
    } else {
        array(&mut out, "float[] widths", diameters, "vertex");
    }
    if let Some(painted) = painted {
        primvars(&mut out, painted);
    }
    out += "    }\n}\n";
    Ok(out.into_bytes())
}

fn primvars(out: &mut String, painted: &PaintedValues) {
    let _ = writeln!(
        out,
        "        custom uniform token {PIGMENTS} = \"{}\"",
        painted.pigments.name()
    );
    for channel in Channel::ALL {
        let name = primvar(channel);
        let values = painted.values.iter().map(|value| value.get(channel));
        if channel.components() == 3 {
            array(out, &format!("float3[] {name}"), values.map(tuple), "vertex");
        } else {
            array(out, &format!("float[] {name}"), values.map(|v| v[0]), "vertex");
        }
    }
    for (name, of) in [
        (
            ALPHA_RATIOS,
            (|r| [r.alpha_tt, r.alpha_trt]) as fn(&LobeRatios) -> [f32; 2],
        ),
        (BETA_RATIOS, |r| [r.beta_tt, r.beta_trt]),
    ] {
        let ratios = painted.ratios.iter().map(of);
        let pair = |[tt, trt]: [f32; 2]| format!("({tt}, {trt})");
        let declaration = format!("float2[] {name}");
        if painted.ratios.windows(2).all(|pair| pair[0] == pair[1]) {
            array(out, &declaration, ratios.take(1).map(pair), "constant");
        } else {
            array(out, &declaration, ratios.map(pair), "vertex");
        }
    }
    // Absorption has no ratios.
    let ratios = LobeRatios::default();
    let sigma_a = || {
        let params = painted
            .values
            .iter()
            .map(|value| value.vertex_params(painted.pigments, &ratios));
        params.map(|params| params.sigma_a)
    };
    array(
        out,
        &format!("float3[] {SIGMA_A}"),
        sigma_a().map(tuple),
        "vertex",
    );
    let colours = sigma_a().map(|sigma_a| tuple(sigma_a.map(|s| (-2.0 * s).exp())));
    array(out, "color3f[] primvars:displayColor", colours, "vertex");
}

/// The shortest decimals that name the same bits.
fn tuple([x, y, z]: [f32; 3]) -> String {
    format!("({x}, {y}, {z})")
}

fn array<T: Display>(
    out: &mut String,
    declaration: &str,
    values: impl IntoIterator<Item = T>,
    interpolation: &str,
) {
    *out += &format!("        {declaration} = [");
    for (i, value) in values.into_iter().enumerate() {
        // Writing to a string cannot fail.
        let _ = write!(out, "{}{value}", if i == 0 { "" } else { ", " });
    }
    *out += "]";
    if !interpolation.is_empty() {
        *out += &format!(" (\n            interpolation = \"{interpolation}\"\n        )");
    }
    *out += "\n";
}
