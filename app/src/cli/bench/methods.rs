//! The methods that are measured.

use balayage_render::gpu::{Method, Quality};

/// Family, level and method, families together, from coarse to fine.
pub(super) fn all() -> Vec<(&'static str, String, Method)> {
    let qualities = [
        ("draft", Quality::Draft),
        ("standard", Quality::Standard),
        ("high", Quality::High),
    ];
    qualities
        .map(|(name, quality)| ("nodes", name.to_owned(), Method::of_quality(quality)))
        .into()
}
