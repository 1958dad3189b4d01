//! Composes WGSL: a line `//!use lib/x.wgsl` brings that file, and what it uses, in once, before the file that asks.

/// Every WGSL file of the product: path below `shaders/` and text.
pub const SOURCES: &[(&str, &str)] = include!(concat!(env!("OUT_DIR"), "/shaders.rs"));

/// The text of `path` with everything it uses in front of it, each file once. A use of a file that stands first in a pair of `instead`
/// brings the second one in: the two offer the same functions.
///
/// # Errors
/// Names the file that is used and does not exist.
pub fn compose(path: &str, instead: &[(&str, &str)]) -> Result<String, String> {
    let mut seen = Vec::new();
    let mut out = String::new();
    append(path, instead, &mut seen, &mut out)?;
    Ok(out)
}

fn append<'a>(
    path: &'a str,
    instead: &[(&'a str, &'a str)],
    seen: &mut Vec<&'a str>,
    out: &mut String,
) -> Result<(), String> {
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
        let used = used.trim();
        let used = instead
            .iter()
            .find(|(from, _)| *from == used)
            .map_or(used, |(_, to)| to);
        append(used, instead, seen, out)?;
    }
    out.push_str(text);
    out.push('\n');
    Ok(())
}
