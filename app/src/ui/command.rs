//! What can be done by menu, button or key, in one table.

use egui::{Key, KeyboardShortcut, Modifiers};

/// A command of the editor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Command {
    /// Asks for a project or groom and opens it.
    Open,
    /// Opens the built-in sample.
    OpenSample,
    /// Saves the project where it came from.
    Save,
    /// Asks where to save the project.
    SaveAs,
    /// Closes the window.
    Quit,
    /// Takes back the last edit.
    Undo,
    /// Does it again.
    Redo,
    /// Shows all of the hair.
    FrameHair,
    /// Makes the brush smaller.
    BrushSmaller,
    /// Makes the brush larger.
    BrushLarger,
    /// Makes the brush weaker.
    BrushWeaker,
    /// Makes the brush stronger.
    BrushStronger,
    /// Adds a layer on top.
    AddLayer,
    /// Copies the chosen layer.
    DuplicateLayer,
    /// Joins the chosen layer with the one below.
    MergeDown,
    /// Chooses the eyedropper.
    Eyedropper,
    /// Asks for an environment map.
    OpenEnvironment,
    /// Asks for a light list.
    OpenLights,
    /// Asks for the maps of a sequence.
    OpenSequence,
    /// Asks for a folder of maps.
    OpenSequenceFolder,
    /// Plays the sequence, or pauses it.
    PlaySequence,
    /// Shows the next map of the sequence.
    NextMap,
    /// Shows the map before.
    PreviousMap,
    /// Asks where to save the lights as they are now.
    SaveLights,
    /// Deletes the chosen light.
    DeleteLight,
}

const CTRL_SHIFT: Modifiers = Modifiers::COMMAND.plus(Modifiers::SHIFT);

impl Command {
    /// Every command.
    pub const ALL: [Self; 25] = [
        Self::Open,
        Self::OpenSample,
        Self::Save,
        Self::SaveAs,
        Self::Quit,
        Self::Undo,
        Self::Redo,
        Self::FrameHair,
        Self::BrushSmaller,
        Self::BrushLarger,
        Self::BrushWeaker,
        Self::BrushStronger,
        Self::AddLayer,
        Self::DuplicateLayer,
        Self::MergeDown,
        Self::Eyedropper,
        Self::OpenEnvironment,
        Self::OpenLights,
        Self::OpenSequence,
        Self::OpenSequenceFolder,
        Self::PlaySequence,
        Self::NextMap,
        Self::PreviousMap,
        Self::SaveLights,
        Self::DeleteLight,
    ];

    /// What menus and tooltips call it.
    pub fn label(self) -> &'static str {
        match self {
            Self::Open => "Open…",
            Self::OpenSample => "Open sample",
            Self::Save => "Save",
            Self::SaveAs => "Save as…",
            Self::Quit => "Quit",
            Self::Undo => "Undo",
            Self::Redo => "Redo",
            Self::FrameHair => "Frame hair",
            Self::BrushSmaller => "Smaller brush",
            Self::BrushLarger => "Larger brush",
            Self::BrushWeaker => "Weaker brush",
            Self::BrushStronger => "Stronger brush",
            Self::AddLayer => "Add layer",
            Self::DuplicateLayer => "Duplicate layer",
            Self::MergeDown => "Merge down",
            Self::Eyedropper => "Take a value from the hair",
            Self::OpenEnvironment => "Environment map…",
            Self::OpenLights => "Light list…",
            Self::OpenSequence => "Sequence of maps…",
            Self::OpenSequenceFolder => "Folder of maps…",
            Self::PlaySequence => "Play or pause sequence",
            Self::NextMap => "Next map",
            Self::PreviousMap => "Previous map",
            Self::SaveLights => "Save light list…",
            Self::DeleteLight => "Delete light",
        }
    }

    /// What it does, where its name does not say it.
    pub fn hint(self) -> &'static str {
        match self {
            Self::AddLayer => "A new layer on top: paint on it can be faded, masked and moved by itself",
            Self::DuplicateLayer => "A copy of the chosen layer with all that was done to it",
            Self::MergeDown => {
                "Joins the chosen layer with the one below, where that changes nothing to be seen"
            }
            _ => "",
        }
    }

    /// Its keys; the first is the one that is shown.
    pub fn shortcuts(self) -> &'static [KeyboardShortcut] {
        const fn key(modifiers: Modifiers, key: Key) -> KeyboardShortcut {
            KeyboardShortcut::new(modifiers, key)
        }
        match self {
            Self::Open => const { &[key(Modifiers::COMMAND, Key::O)] },
            Self::Save => const { &[key(Modifiers::COMMAND, Key::S)] },
            Self::SaveAs => const { &[key(CTRL_SHIFT, Key::S)] },
            Self::Quit => const { &[key(Modifiers::COMMAND, Key::Q)] },
            Self::Undo => const { &[key(Modifiers::COMMAND, Key::Z)] },
            Self::Redo => const { &[key(Modifiers::COMMAND, Key::Y), key(CTRL_SHIFT, Key::Z)] },
            Self::FrameHair => const { &[key(Modifiers::NONE, Key::F), key(Modifiers::NONE, Key::Home)] },
            Self::BrushSmaller => const { &[key(Modifiers::NONE, Key::OpenBracket)] },
            Self::BrushLarger => const { &[key(Modifiers::NONE, Key::CloseBracket)] },
            Self::BrushWeaker => {
                const {
                    &[
                        key(Modifiers::NONE, Key::OpenCurlyBracket),
                        key(Modifiers::SHIFT, Key::OpenBracket),
                    ]
                }
            }
            Self::BrushStronger => {
                const {
                    &[
                        key(Modifiers::NONE, Key::CloseCurlyBracket),
                        key(Modifiers::SHIFT, Key::CloseBracket),
                    ]
                }
            }
            Self::Eyedropper => const { &[key(Modifiers::NONE, Key::C)] },
            Self::DeleteLight => const { &[key(Modifiers::NONE, Key::Delete)] },
            Self::OpenSample
            | Self::AddLayer
            | Self::DuplicateLayer
            | Self::MergeDown
            | Self::OpenEnvironment
            | Self::OpenLights
            | Self::OpenSequence
            | Self::OpenSequenceFolder
            | Self::PlaySequence
            | Self::NextMap
            | Self::PreviousMap
            | Self::SaveLights => &[],
        }
    }

    /// The command whose key was pressed in this frame; longer shortcuts win.
    pub(super) fn pressed(input: &mut egui::InputState) -> Option<Self> {
        let mut keys: Vec<(KeyboardShortcut, Self)> = Self::ALL
            .into_iter()
            .flat_map(|command| command.shortcuts().iter().map(move |keys| (*keys, command)))
            .collect();
        keys.sort_by_key(|(keys, _)| {
            std::cmp::Reverse(u8::from(keys.modifiers.shift) + u8::from(keys.modifiers.command))
        });
        keys.into_iter()
            .find(|(keys, _)| input.consume_shortcut(keys))
            .map(|(_, command)| command)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_two_commands_share_a_key() {
        let keys: Vec<_> = Command::ALL
            .into_iter()
            .flat_map(|c| c.shortcuts().iter().map(move |k| (c, k)))
            .collect();
        for (i, (command, key)) in keys.iter().enumerate() {
            let other = keys[..i].iter().find(|(_, k)| k == key);
            assert!(other.is_none(), "{command:?} and {:?}", other.map(|(c, _)| c));
        }
    }
}
