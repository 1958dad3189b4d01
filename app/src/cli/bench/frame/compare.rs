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
            ["method", "savings", "all ms", "shading ms", "image difference"],
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
        let mut rows = vec![
            (
                "nodes, draft".to_owned(),
                Scheme::Nodes,
                Quality::Draft,
                Savings::ALL,
            ),
            (
                "nodes, standard".into(),
                Scheme::Nodes,
                Quality::Standard,
                Savings::ALL,
            ),
            ("nodes, high".into(), Scheme::Nodes, Quality::High, Savings::ALL),
            (
                "xu2011, m = 4".into(),
                Scheme::Xu2011 { segments: 4 },
                Quality::Standard,
                Savings::NONE,
            ),
        ];
        for n in directions {
            rows.push((
                format!("directional, N = {n}"),
                Scheme::Directional { directions: *n },
                Quality::Standard,
                Savings::NONE,
            ));
        }
        for (name, scheme, quality, savings) in rows {
            let settings = settings(scheme.checked().map_err(CliError::Usage)?, quality, savings);
            // The first picture of a variant compiles it; where that is nothing beside the picture it is spared.
            if !matches!(scheme, Scheme::Directional { directions: 100.. }) {
                self.frame(&settings)?;
                self.frame(&finest)?;
            }
            let (cost, picture) = self.picture(&settings)?;
            table.row([
                Cell::from(name),
                if savings == Savings::NONE { "none" } else { "all" }.into(),
                cost.total().into(),
                cost.pass("strand shading").into(),
                picture.difference(&reference, 1).tile_rmse.into(),
            ]);
        }
        Ok(table)
    }
}
