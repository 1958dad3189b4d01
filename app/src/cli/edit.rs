//! `balayage edit`: the editor's window.

use std::path::PathBuf;

use clap::Args;

use super::{CliError, groom_options::GroomOptions};

#[derive(Args)]
pub(super) struct EditArgs {
    /// Project (.json) or groom to open; the built-in sample if absent.
    file: Option<PathBuf>,
    #[command(flatten)]
    groom: GroomOptions,
}

impl EditArgs {
    /// False where a file is named that is not there.
    pub(super) fn exists(&self) -> bool {
        self.file.as_ref().is_none_or(|file| file.exists())
    }

    /// What to say then.
    pub(super) fn neither(&self) -> String {
        let name = self.file.as_deref().unwrap_or("".as_ref()).display();
        format!("{name}: neither a command nor a file; `balayage --help` lists the commands")
    }
}

pub(super) fn run(args: &EditArgs) -> Result<(), CliError> {
    crate::ui::run(args.file.clone(), args.groom.read()).map_err(|error| match error {
        eframe::Error::Wgpu(error) => CliError::NoGpu(format!(
            "the window has no usable GPU adapter ({error}): install a Vulkan driver \
             (on Debian/Ubuntu without a GPU: apt-get install mesa-vulkan-drivers)"
        )),
        other => CliError::Input(format!(
            "no window can be opened ({other}); set DISPLAY or WAYLAND_DISPLAY, or use `balayage render` and `balayage paint`"
        )),
    })
}
