//! How a groom's file is read: options of every command that opens one.

use balayage_render::groom::ReadOptions;
use clap::Args;

#[derive(Args, Default)]
pub(super) struct GroomOptions {
    /// Metres per unit of the groom's file; otherwise what it states, else guessed from its size.
    #[arg(long, value_name = "X")]
    metres_per_unit: Option<f32>,
    /// Time code of a USD file's samples; otherwise the value without a time, else the first sample.
    #[arg(long, value_name = "T", allow_negative_numbers = true, value_parser = time)]
    usd_time: Option<f64>,
}

impl GroomOptions {
    /// As the readers take them.
    pub(super) fn read(&self) -> ReadOptions {
        ReadOptions {
            metres_per_unit: self.metres_per_unit,
            time: self.usd_time,
        }
    }
}

fn time(text: &str) -> Result<f64, String> {
    let time = text.parse().ok().filter(|time: &f64| time.is_finite());
    time.ok_or_else(|| "write a finite number, as 12 or 0.5".to_owned())
}
