//! The methods that are measured.

use balayage_render::gpu::{Method, Model, Quality, Scheme};

const QUALITIES: [(&str, Quality); 3] = [
    ("draft", Quality::Draft),
    ("standard", Quality::Standard),
    ("high", Quality::High),
];

fn of_scheme(scheme: Scheme) -> Method {
    Method {
        scheme,
        ..Method::default()
    }
}

/// Family, level and method.
pub(super) type Named = (&'static str, String, Method);

/// Every way to integrate Marschner's model, families together, from coarse to fine.
pub(super) fn marschner() -> Vec<Named> {
    let nodes = QUALITIES.map(|(name, quality)| ("nodes", name.to_owned(), Method::of_quality(quality)));
    let xu = [2, 4, 8, 16].map(|segments| {
        let method = of_scheme(Scheme::Xu2011 { segments });
        ("xu2011", format!("m = {segments}"), method)
    });
    let directional = [16, 64, 256, 1024, 4096].map(|directions| {
        let method = of_scheme(Scheme::Directional { directions });
        ("directional", format!("N = {directions}"), method)
    });
    nodes.into_iter().chain(xu).chain(directional).collect()
}

/// Every scheme and model whose code differs.
pub(super) fn every_shader() -> Vec<Named> {
    let of_model = |model| {
        move |(name, quality): (&str, Quality)| {
            let method = Method {
                model,
                ..Method::of_quality(quality)
            };
            (name.to_owned(), method)
        }
    };
    let named = |family: &'static str, model| {
        QUALITIES
            .map(of_model(model))
            .map(|(level, method)| (family, level, method))
    };
    let xu = Scheme::Xu2011 { segments: 4 };
    let directional = Scheme::Directional { directions: 16 };
    named("nodes", Model::Marschner)
        .into_iter()
        .chain([
            ("xu2011", "m = 4".to_owned(), of_scheme(xu)),
            ("directional", "N = 16".to_owned(), of_scheme(directional)),
        ])
        .chain(named("deon", Model::Deon))
        .chain(named("kajiya-kay", Model::KajiyaKay))
        .collect()
}
