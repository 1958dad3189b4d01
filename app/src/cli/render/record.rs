//! What a picture says of itself, and whether a picture that is there is the one that would be rendered.

use std::{fs, path::Path};

use balayage_render::{
    gpu::{Camera, RenderSettings},
    image::{Metadata, read_metadata},
};
use serde_json::{Value, json};

use super::{CliError, RenderArgs};
use crate::{
    Problem,
    document::{Document, json},
};

/// Field of the hash of all that the picture depends on.
const KEY: &str = "balayage:key";

/// What all pictures of a document have in common.
pub(super) struct Record {
    project: String,
    settings: Value,
    /// Content hashes of the files that the project names.
    files: Value,
}

impl Record {
    /// Hashes the project with all options applied and the files that it names.
    ///
    /// # Errors
    /// A file that cannot be read.
    pub(super) fn of(
        document: &Document,
        args: &RenderArgs,
        settings: &RenderSettings,
    ) -> Result<Self, CliError> {
        let project = document.project();
        let text = json::to_text(project).map_err(|e| CliError::Input(e.to_string()))?;
        let mut files = serde_json::Map::new();
        let head = project.head.iter().map(|head| document.resolve(&head.path));
        for file in document
            .light_files()
            .into_iter()
            .chain(head)
            .filter(|file| file.exists())
        {
            let bytes = fs::read(&file).map_err(|e| Problem::io(&file, "reading", &e))?;
            files.insert(document.reference_to(&file), hash(&bytes).into());
        }
        let shade = &settings.shade;
        Ok(Self {
            project: hash(text.as_bytes()),
            settings: json!({
                "size": args.size,
                "samples": settings.samples,
                "method": shade.method,
                "multiple": format!("{:?}", shade.multiple),
                "terms": format!("{:?}", shade.terms),
                "view": format!("{:?}", settings.view),
                "background": settings.show_background,
                "visibility_rays": settings.visibility_rays,
                "transmittance": shade.visibility,
                "voxel_spacings": args.voxel_spacings,
                "savings": settings.savings.to_string(),
                "debug_view": args.debug_view.map(|view| format!("{view:?}")),
            }),
            files: files.into(),
        })
    }

    /// What a picture of `camera` says of itself.
    pub(super) fn metadata(&self, camera: &Camera, frame: Option<u32>) -> Metadata {
        let version = env!("CARGO_PKG_VERSION");
        let subject = json!({
            "version": version,
            "project": self.project,
            "groom_and_files": self.files,
            "settings": self.settings,
            "camera": format!("{camera:?}"),
        });
        let mut metadata = vec![
            ("Software".to_owned(), format!("Balayage {version}")),
            ("balayage:project".to_owned(), self.project.clone()),
            ("balayage:settings".to_owned(), self.settings.to_string()),
            ("balayage:camera".to_owned(), format!("{camera:?}")),
            (KEY.to_owned(), hash(subject.to_string().as_bytes())),
        ];
        metadata.extend(frame.map(|frame| ("balayage:frame".to_owned(), frame.to_string())));
        metadata
    }
}

/// True where `path` holds a whole picture with the same key.
pub(super) fn is_complete(path: &Path, metadata: &Metadata) -> bool {
    let key = |metadata: &Metadata| metadata.iter().find(|(name, _)| name == KEY).cloned();
    read_metadata(path).is_ok_and(|found| key(&found).is_some() && key(&found) == key(metadata))
}

fn hash(bytes: &[u8]) -> String {
    blake3::hash(bytes).to_hex().to_string()
}
