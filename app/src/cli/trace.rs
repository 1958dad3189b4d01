//! `--trace`: the scopes of a run, in a file that Chrome and Perfetto show.

use std::fs::File;
use std::path::Path;

use tracing_chrome::{ChromeLayerBuilder, FlushGuard};
use tracing_subscriber::layer::SubscriberExt;

use super::CliError;

/// Writes every scope from now on, of all threads, until the guard is dropped.
pub(super) fn write(path: &Path) -> Result<FlushGuard, CliError> {
    let refused = |reason: String| CliError::Input(format!("{}: {reason}", path.display()));
    let file = File::create(path).map_err(|e| refused(format!("{e}; name another file for --trace")))?;
    let (layer, guard) = ChromeLayerBuilder::new().writer(file).include_args(true).build();
    tracing::subscriber::set_global_default(tracing_subscriber::registry().with(layer))
        .map_err(|_| refused("this process already writes a trace".to_owned()))?;
    Ok(guard)
}
