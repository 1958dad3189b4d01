//! Pictures with some of the savings and by other methods, against those with none and by the finest.

use balayage_render::gpu::{Method, Quality, RenderSettings, Saving, Savings, Scheme};

use super::super::report::{Cell, Table};
use super::Bench;
use crate::cli::CliError;

impl Bench {
    /// Shading and drawing anew with each saving, against none of them.
    pub(super) fn savings(&mut self) -> Result<Table, CliError> {
        let mut table = Table::new(
            "frame_savings",
            [
                "savings",
                "all ms",
                "shading ms",
                "vertices shaded",
                "lights evaluated",
                "image difference",
                "bound",
            ],
        );
        // Other savings than the frame before had: what was marched stays, everything is shaded again.
        let with = |savings: Savings| RenderSettings {
            savings: savings.with(Saving::Untouched),
            ..RenderSettings::default()
        };
        let (_, reference) = self.picture(&with(Savings::NONE))?;
        let mut rows = vec![
            ("all".to_owned(), Savings::ALL, None),
            ("none".into(), Savings::NONE, None),
        ];
        for saving in [
            Saving::Unseen,
            Saving::Hidden,
            Saving::Circular,
            Saving::Absorbed,
            Saving::Straight,
            Saving::Levels,
        ] {
            let only = Savings::NONE.with(saving);
            rows.push((format!("only {}", saving.name()), only, Some(saving.bound())));
        }
        for (name, savings, bound) in rows {
            // The first picture of a variant compiles it.
            self.frame(&with(savings))?;
            self.frame(&with(Savings::NONE.with(Saving::Gain)))?;
            let (cost, picture) = self.picture(&with(savings))?;
            let work = &cost.report;
            let lights = work.counter("single scattering evaluations")
                + work.counter("multiple scattering evaluations");
            table.row([
                Cell::from(name),
                cost.total().into(),
                cost.pass("strand shading").into(),
                Cell::Count(work.counter("vertices shaded")),
                Cell::Count(lights),
                picture.difference(&reference, 1).tile_rmse.into(),
                bound.map_or(Cell::None, Cell::Number),
            ]);
        }
        Ok(table)
    }

    /// Shading and drawing anew by each method against the finest: what an error costs. What was marched stays.
    pub(super) fn methods(&mut self, directions: &[u32]) -> Result<Table, CliError> {
        let mut table = Table::new(
            "frame_methods",
            [
                "method",
                "savings",
                "strands",
                "all ms",
                "shading ms",
                "image difference",
            ],
        );
        let settings = |scheme, quality, savings: Savings| {
            let mut settings = RenderSettings {
                savings: savings.with(Saving::Untouched),
                ..RenderSettings::default()
            };
            settings.shade.method = Method {
                scheme,
                quality,
                ..Method::default()
            };
            settings
        };
        let finest = settings(Scheme::Nodes, Quality::High, Savings::NONE);
        let (_, reference) = self.picture(&finest)?;
        let mut rows = Vec::new();
        for (name, quality) in [
            ("nodes, high", Quality::High),
            ("nodes, standard", Quality::Standard),
            ("nodes, draft", Quality::Draft),
        ] {
            rows.push((name.to_owned(), Scheme::Nodes, quality, Savings::ALL, 1.0));
        }
        for share in [0.5, 0.25, 0.125] {
            let draft = "nodes, draft".to_owned();
            rows.push((draft, Scheme::Nodes, Quality::Draft, Savings::ALL, share));
        }
        let published = Scheme::Xu2011 { segments: 4 };
        let standard = Quality::Standard;
        rows.push(("xu2011, m = 4".into(), published, standard, Savings::NONE, 1.0));
        for n in directions {
            let scheme = Scheme::Directional { directions: *n };
            rows.push((
                format!("directional, N = {n}"),
                scheme,
                standard,
                Savings::NONE,
                1.0,
            ));
        }
        for (name, scheme, quality, savings, share) in rows {
            let settings = RenderSettings {
                strand_share: share,
                ..settings(scheme.checked().map_err(CliError::Usage)?, quality, savings)
            };
            // The first picture of a variant compiles it; where that is nothing beside the picture it is spared.
            if !matches!(scheme, Scheme::Directional { directions: 100.. }) {
                self.frame(&settings)?;
                self.frame(&finest)?;
            }
            let (cost, picture) = self.picture(&settings)?;
            table.row([
                Cell::from(name),
                if savings == Savings::NONE { "none" } else { "all" }.into(),
                f64::from(share).into(),
                cost.total().into(),
                cost.pass("strand shading").into(),
                picture.difference(&reference, 1).tile_rmse.into(),
            ]);
        }
        Ok(table)
    }
}
