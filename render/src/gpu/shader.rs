//! Composes WGSL: a line `//!use lib/x.wgsl` brings that file, and what it uses, in once, before the file that asks.

/// Every WGSL file of the product: path below `shaders/` and text.
pub const SOURCES: &[(&str, &str)] = &[
    source(
        "lib/averages.wgsl",
        include_str!("../../../shaders/lib/averages.wgsl"),
    ),
    source(
        "lib/averages_table.wgsl",
        include_str!("../../../shaders/lib/averages_table.wgsl"),
    ),
    source(
        "lib/azimuth_r.wgsl",
        include_str!("../../../shaders/lib/azimuth_r.wgsl"),
    ),
    source(
        "lib/azimuth_trt.wgsl",
        include_str!("../../../shaders/lib/azimuth_trt.wgsl"),
    ),
    source(
        "lib/azimuth_tt.wgsl",
        include_str!("../../../shaders/lib/azimuth_tt.wgsl"),
    ),
    source(
        "lib/backward.wgsl",
        include_str!("../../../shaders/lib/backward.wgsl"),
    ),
    source(
        "lib/camera.wgsl",
        include_str!("../../../shaders/lib/camera.wgsl"),
    ),
    source(
        "lib/coverage.wgsl",
        include_str!("../../../shaders/lib/coverage.wgsl"),
    ),
    source(
        "lib/environment.wgsl",
        include_str!("../../../shaders/lib/environment.wgsl"),
    ),
    source("lib/fibre.wgsl", include_str!("../../../shaders/lib/fibre.wgsl")),
    source(
        "lib/forward.wgsl",
        include_str!("../../../shaders/lib/forward.wgsl"),
    ),
    source(
        "lib/fragment.wgsl",
        include_str!("../../../shaders/lib/fragment.wgsl"),
    ),
    source(
        "lib/global.wgsl",
        include_str!("../../../shaders/lib/global.wgsl"),
    ),
    source("lib/light.wgsl", include_str!("../../../shaders/lib/light.wgsl")),
    source(
        "lib/light_run.wgsl",
        include_str!("../../../shaders/lib/light_run.wgsl"),
    ),
    source(
        "lib/lobe_light.wgsl",
        include_str!("../../../shaders/lib/lobe_light.wgsl"),
    ),
    source(
        "lib/longitudinal.wgsl",
        include_str!("../../../shaders/lib/longitudinal.wgsl"),
    ),
    source("lib/maths.wgsl", include_str!("../../../shaders/lib/maths.wgsl")),
    source(
        "lib/multiple.wgsl",
        include_str!("../../../shaders/lib/multiple.wgsl"),
    ),
    source("lib/paths.wgsl", include_str!("../../../shaders/lib/paths.wgsl")),
    source(
        "lib/quality.wgsl",
        include_str!("../../../shaders/lib/quality.wgsl"),
    ),
    source(
        "lib/refined.wgsl",
        include_str!("../../../shaders/lib/refined.wgsl"),
    ),
    source("lib/shade.wgsl", include_str!("../../../shaders/lib/shade.wgsl")),
    source(
        "lib/single.wgsl",
        include_str!("../../../shaders/lib/single.wgsl"),
    ),
    source(
        "lib/tables.wgsl",
        include_str!("../../../shaders/lib/tables.wgsl"),
    ),
    source("lib/types.wgsl", include_str!("../../../shaders/lib/types.wgsl")),
    source("lib/view.wgsl", include_str!("../../../shaders/lib/view.wgsl")),
    source(
        "lib/volume.wgsl",
        include_str!("../../../shaders/lib/volume.wgsl"),
    ),
    source(
        "lib/work_list.wgsl",
        include_str!("../../../shaders/lib/work_list.wgsl"),
    ),
    source(
        "pass/averages.wgsl",
        include_str!("../../../shaders/pass/averages.wgsl"),
    ),
    source(
        "pass/density_paint.wgsl",
        include_str!("../../../shaders/pass/density_paint.wgsl"),
    ),
    source("pass/head.wgsl", include_str!("../../../shaders/pass/head.wgsl")),
    source(
        "pass/head_shade.wgsl",
        include_str!("../../../shaders/pass/head_shade.wgsl"),
    ),
    source(
        "pass/probe.wgsl",
        include_str!("../../../shaders/pass/probe.wgsl"),
    ),
    source(
        "pass/resolve.wgsl",
        include_str!("../../../shaders/pass/resolve.wgsl"),
    ),
    source(
        "pass/shade.wgsl",
        include_str!("../../../shaders/pass/shade.wgsl"),
    ),
    source(
        "pass/shade_multiple.wgsl",
        include_str!("../../../shaders/pass/shade_multiple.wgsl"),
    ),
    source(
        "pass/strand_alloc.wgsl",
        include_str!("../../../shaders/pass/strand_alloc.wgsl"),
    ),
    source(
        "pass/strand_bin.wgsl",
        include_str!("../../../shaders/pass/strand_bin.wgsl"),
    ),
    source(
        "pass/strand_radiance.wgsl",
        include_str!("../../../shaders/pass/strand_radiance.wgsl"),
    ),
    source(
        "pass/transmittance_path.wgsl",
        include_str!("../../../shaders/pass/transmittance_path.wgsl"),
    ),
    source(
        "pass/transmittance_visibility.wgsl",
        include_str!("../../../shaders/pass/transmittance_visibility.wgsl"),
    ),
    source("pass/view.wgsl", include_str!("../../../shaders/pass/view.wgsl")),
    source(
        "pass/work_list.wgsl",
        include_str!("../../../shaders/pass/work_list.wgsl"),
    ),
];

const fn source(path: &'static str, text: &'static str) -> (&'static str, &'static str) {
    (path, text)
}

/// The text of `path` with everything it uses in front of it, each file once.
///
/// # Errors
/// Names the file that is used and does not exist.
pub fn compose(path: &str) -> Result<String, String> {
    let mut seen = Vec::new();
    let mut out = String::new();
    append(path, &mut seen, &mut out)?;
    Ok(out)
}

fn append<'a>(path: &'a str, seen: &mut Vec<&'a str>, out: &mut String) -> Result<(), String> {
    if seen.contains(&path) {
        return Ok(());
    }
    seen.push(path);
    let text: &'static str = SOURCES
        .iter()
        .find(|(name, _)| *name == path)
        .map(|(_, text)| *text)
        .ok_or_else(|| format!("shaders/{path} does not exist"))?;
    for used in text.lines().filter_map(|line| line.strip_prefix("//!use ")) {
        append(used.trim(), seen, out)?;
    }
    out.push_str(text);
    out.push('\n');
    Ok(())
}
