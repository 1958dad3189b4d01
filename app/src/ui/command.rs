//! What can be done by menu, button or key, in one table.

use egui::{Key, KeyboardShortcut, Modifiers};
use serde::{Deserialize, Serialize};

/// A command of the editor.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
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
    /// Looks at the hair from the front.
    ViewFront,
    /// Looks at the hair from behind.
    ViewBack,
    /// Looks at the hair from its right side.
    ViewRight,
    /// Looks at the hair from its left side.
    ViewLeft,
    /// Looks at the hair from above.
    ViewTop,
    /// Looks at the hair from below.
    ViewBottom,
    /// Makes the brush smaller.
    BrushSmaller,
    /// Makes the brush larger.
    BrushLarger,
    /// Makes the brush weaker.
    BrushWeaker,
    /// Makes the brush stronger.
    BrushStronger,
    /// Moving the pointer sets the brush's radius until a click.
    BrushRadius,
    /// Moving the pointer sets the brush's strength until a click.
    BrushStrength,
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
    /// Opens the list of all commands.
    Palette,
    /// Chooses the tool that paints.
    PaintTool,
    /// Chooses the tool that paints along strands.
    CombTool,
    /// Chooses the eraser.
    EraseTool,
    /// Chooses the tool that smooths.
    SmoothTool,
    /// Chooses the tool that masks.
    MaskTool,
    /// Chooses the lasso.
    LassoTool,
    /// Keeps the present look to compare with.
    TakeSnapshot,
    /// Shows the earlier look beside the present one.
    Compare,
    /// Shows the unpainted hair, by key only while that is held.
    Before,
    /// Shows one term of scattering alone, then the next.
    SoloNext,
    /// Shows all terms.
    AllLight,
    /// Turns the view until a key or button is pressed.
    Turntable,
    /// Fills the screen, or leaves it.
    FullScreen,
    /// Hides tools and docks, or shows them.
    HidePanels,
}

const CTRL_SHIFT: Modifiers = Modifiers::COMMAND.plus(Modifiers::SHIFT);

impl Command {
    /// Every command.
    pub const ALL: [Self; 48] = [
        Self::Open,
        Self::OpenSample,
        Self::Save,
        Self::SaveAs,
        Self::Quit,
        Self::Undo,
        Self::Redo,
        Self::FrameHair,
        Self::ViewFront,
        Self::ViewBack,
        Self::ViewRight,
        Self::ViewLeft,
        Self::ViewTop,
        Self::ViewBottom,
        Self::BrushSmaller,
        Self::BrushLarger,
        Self::BrushWeaker,
        Self::BrushStronger,
        Self::BrushRadius,
        Self::BrushStrength,
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
        Self::Palette,
        Self::PaintTool,
        Self::CombTool,
        Self::EraseTool,
        Self::SmoothTool,
        Self::MaskTool,
        Self::LassoTool,
        Self::TakeSnapshot,
        Self::Compare,
        Self::Before,
        Self::SoloNext,
        Self::AllLight,
        Self::Turntable,
        Self::FullScreen,
        Self::HidePanels,
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
            Self::ViewFront => "View from the front",
            Self::ViewBack => "View from behind",
            Self::ViewRight => "View from the right",
            Self::ViewLeft => "View from the left",
            Self::ViewTop => "View from above",
            Self::ViewBottom => "View from below",
            Self::BrushSmaller => "Smaller brush",
            Self::BrushLarger => "Larger brush",
            Self::BrushWeaker => "Weaker brush",
            Self::BrushStronger => "Stronger brush",
            Self::BrushRadius => "Brush radius by moving",
            Self::BrushStrength => "Brush strength by moving",
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
            Self::Palette => "All commands…",
            Self::PaintTool => "Tool: Paint",
            Self::CombTool => "Tool: Comb-dye",
            Self::EraseTool => "Tool: Erase",
            Self::SmoothTool => "Tool: Smooth",
            Self::MaskTool => "Tool: Mask",
            Self::LassoTool => "Tool: Lasso",
            Self::TakeSnapshot => "Take snapshot",
            Self::Compare => "Compare A|B",
            Self::Before => "Unpainted hair",
            Self::SoloNext => "Next term alone",
            Self::AllLight => "All terms",
            Self::Turntable => "Turntable",
            Self::FullScreen => "Full screen",
            Self::HidePanels => "Hide panels",
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
            Self::Palette => "Search, run and give keys to every command",
            Self::TakeSnapshot => "Keeps the hair as it looks now, to compare with later",
            Self::Compare => {
                "The snapshot or the unpainted hair on the left, now on the right; drag the line between"
            }
            Self::BrushRadius | Self::BrushStrength => {
                "Move the pointer to and fro; a click keeps the value, Esc or the right button the old one"
            }
            Self::Before => "Its key shows the unpainted hair while it is held",
            Self::SoloNext => "R, TT, TRT, D, L and U one after the other, then all",
            Self::Turntable => "Turns the view; any key or button stops it",
            Self::HidePanels => "Only the picture, or tools and docks again",
            _ => "",
        }
    }

    /// True where its key counts as long as it is held.
    pub fn is_held(self) -> bool {
        self == Self::Before
    }

    /// What settings call it.
    pub fn id(self) -> String {
        let named = serde_json::to_value(self).ok();
        let text = named.as_ref().and_then(serde_json::Value::as_str);
        text.unwrap_or_default().to_owned()
    }

    /// Its usual keys; the first is the one that is shown.
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
            Self::Palette => const { &[key(CTRL_SHIFT, Key::P), key(Modifiers::NONE, Key::F3)] },
            Self::PaintTool => const { &[key(Modifiers::NONE, Key::Num1)] },
            Self::CombTool => const { &[key(Modifiers::NONE, Key::Num2)] },
            Self::EraseTool => const { &[key(Modifiers::NONE, Key::Num3)] },
            Self::SmoothTool => const { &[key(Modifiers::NONE, Key::Num4)] },
            Self::MaskTool => const { &[key(Modifiers::NONE, Key::Num5)] },
            Self::LassoTool => const { &[key(Modifiers::NONE, Key::Num6)] },
            Self::TakeSnapshot => const { &[key(CTRL_SHIFT, Key::B)] },
            Self::Before => const { &[key(Modifiers::NONE, Key::B)] },
            Self::Compare => const { &[key(Modifiers::COMMAND, Key::B)] },
            Self::SoloNext => const { &[key(Modifiers::NONE, Key::L)] },
            Self::AllLight => const { &[key(Modifiers::SHIFT, Key::L)] },
            Self::Turntable => const { &[key(Modifiers::NONE, Key::T)] },
            Self::FullScreen => const { &[key(Modifiers::NONE, Key::F11)] },
            Self::HidePanels => const { &[key(Modifiers::NONE, Key::H)] },
            Self::OpenSample
            | Self::ViewFront
            | Self::ViewBack
            | Self::ViewRight
            | Self::ViewLeft
            | Self::ViewTop
            | Self::ViewBottom
            | Self::BrushRadius
            | Self::BrushStrength
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
}
