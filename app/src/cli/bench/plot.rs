//! A plot with two logarithmic axes.

use std::error::Error;
use std::ops::Range;
use std::path::Path;

use balayage_render::image::{PictureError, write_png};
use plotters::prelude::*;
use plotters::style::{FontStyle, register_font};

use crate::cli::CliError;

const SIZE: (u32, u32) = (900, 600);

/// Points of one kind.
pub struct Series {
    /// Its name in the legend.
    pub name: String,
    /// (x, y), both above zero; others cannot be drawn and are left out.
    pub points: Vec<(f64, f64)>,
}

/// Series over two logarithmic axes.
pub struct Plot {
    /// File name without its extension.
    pub name: &'static str,
    /// Line on top.
    pub title: String,
    /// Label with unit.
    pub x_label: &'static str,
    /// Label with unit.
    pub y_label: &'static str,
    /// What is drawn; points of a series are joined in their order.
    pub series: Vec<Series>,
}

impl Plot {
    /// Draws the plot.
    pub(super) fn write_png(&self, path: &Path) -> Result<(), CliError> {
        let refused = |reason: String| {
            CliError::from(PictureError::Write {
                path: path.display().to_string(),
                reason,
            })
        };
        let rgb = self.drawn().map_err(|error| refused(error.to_string()))?;
        let rgba: Vec<u8> = rgb
            .chunks_exact(3)
            .flat_map(|p| [p[0], p[1], p[2], 255])
            .collect();
        Ok(write_png(path, SIZE.0 as usize, SIZE.1 as usize, &rgba)?)
    }

    fn drawn(&self) -> Result<Vec<u8>, Box<dyn Error + '_>> {
        register_font(
            "sans-serif",
            FontStyle::Normal,
            epaint_default_fonts::UBUNTU_LIGHT,
        )
        .map_err(|_| "the font cannot be read")?;
        let mut rgb = vec![0; (SIZE.0 * SIZE.1 * 3) as usize];
        {
            let area = BitMapBackend::with_buffer(&mut rgb, SIZE).into_drawing_area();
            area.fill(&WHITE)?;
            let mut chart = ChartBuilder::on(&area)
                .caption(&self.title, ("sans-serif", 22))
                .margin(12)
                .x_label_area_size(48)
                .y_label_area_size(72)
                .build_cartesian_2d(self.range(|p| p.0).log_scale(), self.range(|p| p.1).log_scale())?;
            chart
                .configure_mesh()
                .light_line_style(BLACK.mix(0.06))
                .x_desc(self.x_label)
                .y_desc(self.y_label)
                .label_style(("sans-serif", 15))
                .draw()?;
            for (index, series) in self.series.iter().enumerate() {
                let color = Palette99::pick(index).to_rgba();
                let points = || series.points.iter().copied().filter(drawable);
                chart.draw_series(LineSeries::new(points(), color.stroke_width(2)))?;
                chart
                    .draw_series(points().map(|p| Circle::new(p, 4, color.filled())))?
                    .label(&series.name)
                    .legend(move |(x, y)| Circle::new((x + 8, y), 4, color.filled()));
            }
            chart
                .configure_series_labels()
                .label_font(("sans-serif", 15))
                .background_style(WHITE.mix(0.8))
                .border_style(BLACK.mix(0.3))
                .draw()?;
            area.present()?;
        }
        Ok(rgb)
    }

    /// What the axis of a coordinate spans, with room around it.
    fn range(&self, coordinate: impl Fn(&(f64, f64)) -> f64) -> Range<f64> {
        let all = self.series.iter().flat_map(|s| &s.points).filter(|p| drawable(p));
        let (low, high) = all
            .map(coordinate)
            .fold((f64::INFINITY, 0.0_f64), |(low, high), x| {
                (low.min(x), high.max(x))
            });
        if low > high {
            0.1..10.0
        } else {
            low / 1.5..high * 1.5
        }
    }
}

fn drawable(point: &(f64, f64)) -> bool {
    [point.0, point.1].iter().all(|x| x.is_finite() && *x > 0.0)
}
