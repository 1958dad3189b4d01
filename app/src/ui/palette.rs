//! The command palette: every command with its keys, to be searched, run and given other keys.

use egui::{Context, Key, KeyboardShortcut, Role, Ui, WidgetInfo};

use super::{
    Command, Editor,
    keymap::{self, Keymap},
    settings::Navigation,
};

/// Height of the list, points.
const LIST_HEIGHT: f32 = 320.0;

/// The open palette.
#[derive(Default)]
pub(super) struct Palette {
    search: String,
    /// The row that Enter runs.
    row: usize,
    /// The command that waits for keys, and keys that another one has.
    wants: Option<(Command, Option<KeyboardShortcut>)>,
}

/// What the palette was asked for.
#[derive(Clone, Copy)]
enum Asked {
    Run(Command),
    /// Waits for new keys.
    Keys(Command),
    /// These keys, taken from whoever has them.
    Set(Command, KeyboardShortcut),
    /// No keys at all.
    Clear(Command),
    Reset,
    Preset(Navigation),
    Close,
}

impl Palette {
    /// The commands that hold every word of the search.
    fn found(&self) -> Vec<Command> {
        let search = self.search.to_lowercase();
        let matches = |command: &Command| {
            let text = format!("{} {}", command.label(), command.hint()).to_lowercase();
            search.split_whitespace().all(|word| text.contains(word))
        };
        Command::ALL.into_iter().filter(matches).collect()
    }
}

impl Editor {
    /// Opens the palette, or closes it.
    pub(super) fn toggle_palette(&mut self) {
        self.palette = match self.palette {
            Some(_) => None,
            None => Some(Palette::default()),
        };
    }

    /// Reads the keys of the settings anew and says what of them is unknown.
    pub(super) fn refresh_keys(&mut self) {
        let values = self.settings.values();
        let (keymap, unknown) = Keymap::new(values.navigation, &values.keys);
        self.keymap = keymap;
        if !unknown.is_empty() {
            self.say(format!(
                "Settings: no command or key is called {}",
                unknown.join(", ")
            ));
        }
    }

    pub(super) fn palette_window(&mut self, context: &Context) {
        let Some(mut palette) = self.palette.take() else {
            return;
        };
        let mut asked = None;
        if let Some((command, _)) = palette.wants {
            asked = self.typed_for(context, command, &mut palette);
        }
        let window = egui::Modal::new(egui::Id::unique("command palette")).show(context, |ui| {
            ui.set_width(460.0);
            ui.heading("Commands");
            let from_list = self.palette_list(ui, &mut palette);
            asked = asked.take().or(from_list).or(self.palette_foot(ui, &palette));
        });
        // While keys are waited for Esc ends the waiting only.
        if window.should_close() && palette.wants.is_none() {
            asked = Some(Asked::Close);
        }
        let stays = self.answer_palette(context, &mut palette, asked);
        if stays {
            self.palette = Some(palette);
        }
    }

    /// What the keys that were just pressed mean for the command that waits for them.
    fn typed_for(&self, context: &Context, command: Command, palette: &mut Palette) -> Option<Asked> {
        let keys = context.input(keymap::typed)?;
        context.input_mut(|input| input.consume_shortcut(&keys));
        match (keys.logical_key, keys.modifiers.is_none()) {
            (Key::Escape, true) => palette.wants = None,
            (Key::Backspace, true) => return Some(Asked::Clear(command)),
            _ => match self.keymap.holder(keys).filter(|other| *other != command) {
                Some(_) => palette.wants = Some((command, Some(keys))),
                None => return Some(Asked::Set(command, keys)),
            },
        }
        None
    }

    fn palette_list(&self, ui: &mut Ui, palette: &mut Palette) -> Option<Asked> {
        let mut asked = None;
        let field = egui::TextEdit::singleline(&mut palette.search)
            .hint_text("Search")
            .desired_width(f32::INFINITY);
        let field = ui.add_enabled(palette.wants.is_none(), field);
        field.widget_info(|| WidgetInfo::labeled(Role::TextInput, true, "Search commands"));
        let found = palette.found();
        if palette.wants.is_none() {
            field.request_focus();
            if field.changed() {
                palette.row = 0;
            }
            let pressed = |key| ui.input(|input| input.key_pressed(key));
            if pressed(Key::ArrowDown) {
                palette.row += 1;
            }
            if pressed(Key::ArrowUp) {
                palette.row = palette.row.saturating_sub(1);
            }
            palette.row = palette.row.min(found.len().saturating_sub(1));
            if pressed(Key::Enter) {
                asked = found.get(palette.row).map(|command| Asked::Run(*command));
            }
        }
        if found.is_empty() {
            ui.weak("No command has all of these words.");
        }
        egui::ScrollArea::vertical()
            .max_height(LIST_HEIGHT)
            .auto_shrink([false, true])
            .show(ui, |ui| {
                for (row, command) in found.into_iter().enumerate() {
                    ui.horizontal(|ui| {
                        let shown = row == palette.row;
                        asked = asked.take().or(self.palette_row(ui, command, shown));
                    });
                }
            });
        asked
    }

    fn palette_row(&self, ui: &mut Ui, command: Command, chosen: bool) -> Option<Asked> {
        let mut asked = None;
        let button = egui::Button::selectable(chosen, command.label());
        let button = ui.add_enabled(self.is_enabled(command), button);
        if chosen && ui.input(|input| input.key_down(Key::ArrowDown) || input.key_down(Key::ArrowUp)) {
            button.scroll_to_me(None);
        }
        if button.on_hover_text(command.hint()).clicked() {
            asked = Some(Asked::Run(command));
        }
        ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
            let keys = self.keymap.keys(command).iter().map(|keys| keymap::text(*keys));
            let keys: Vec<String> = keys.collect();
            let text = if keys.is_empty() {
                "no keys".to_owned()
            } else {
                keys.join("  ")
            };
            let button = ui.add(egui::Button::new(text).small());
            let name = format!("Keys of {}", command.label());
            button.widget_info(|| WidgetInfo::labeled(Role::Button, true, &name));
            if button.on_hover_text("Click, then press other keys").clicked() {
                asked = Some(Asked::Keys(command));
            }
        });
        asked
    }

    /// Presets, or the keys that are waited for.
    fn palette_foot(&self, ui: &mut Ui, palette: &Palette) -> Option<Asked> {
        ui.separator();
        let mut asked = None;
        match palette.wants {
            Some((command, None)) => {
                ui.label(format!(
                    "Press the keys for {}. Backspace: none, Esc: as they are.",
                    command.label()
                ));
            }
            Some((command, Some(keys))) => {
                let holder = self.keymap.holder(keys).map_or("", Command::label);
                ui.label(format!("{} are the keys of {holder}.", keymap::text(keys)));
                ui.horizontal(|ui| {
                    if ui.button(format!("Give them to {}", command.label())).clicked() {
                        asked = Some(Asked::Set(command, keys));
                    }
                    if ui.button("Press others").clicked() {
                        asked = Some(Asked::Keys(command));
                    }
                });
            }
            None => {
                ui.horizontal(|ui| {
                    let mut navigation = self.settings.values().navigation;
                    for (preset, name) in [
                        (Navigation::Maya, "Maya, Substance"),
                        (Navigation::Blender, "Blender"),
                    ] {
                        if ui.radio_value(&mut navigation, preset, name).clicked() {
                            asked = Some(Asked::Preset(preset));
                        }
                    }
                    let changed = !self.settings.values().keys.is_empty();
                    let reset = ui.add_enabled(changed, egui::Button::new("Reset keys"));
                    if reset.on_hover_text("All keys as the preset has them").clicked() {
                        asked = Some(Asked::Reset);
                    }
                });
            }
        }
        asked
    }

    /// Does what was asked for; false where the palette closes.
    fn answer_palette(&mut self, context: &Context, palette: &mut Palette, asked: Option<Asked>) -> bool {
        match asked {
            None => {}
            Some(Asked::Close) => return false,
            Some(Asked::Run(command)) if self.is_enabled(command) => {
                self.run(context, command);
                return false;
            }
            Some(Asked::Run(command)) => self.say(format!("{}: not possible now", command.label())),
            Some(Asked::Keys(command)) => palette.wants = Some((command, None)),
            Some(Asked::Set(command, keys)) => {
                palette.wants = None;
                self.give_keys(command, Some(keys));
            }
            Some(Asked::Clear(command)) => {
                palette.wants = None;
                self.give_keys(command, None);
            }
            Some(Asked::Reset) => self.set_preference(|values| values.keys.clear()),
            Some(Asked::Preset(navigation)) => {
                self.set_preference(|values| values.navigation = navigation);
            }
        }
        true
    }

    /// Gives `keys` alone to `command`; who had them keeps its others.
    fn give_keys(&mut self, command: Command, keys: Option<KeyboardShortcut>) {
        let texts = |keys: &[KeyboardShortcut]| keys.iter().map(|keys| keymap::text(*keys)).collect();
        let robbed = keys.and_then(|keys| {
            let holder = self.keymap.holder(keys).filter(|other| *other != command)?;
            let left = self.keymap.keys(holder).iter().copied();
            let left: Vec<KeyboardShortcut> = left.filter(|own| *own != keys).collect();
            Some((holder, left))
        });
        if let Some((holder, left)) = &robbed
            && left.is_empty()
        {
            self.say(format!("{} has no keys now", holder.label()));
        }
        self.set_preference(|values| {
            if let Some((holder, left)) = robbed {
                values.keys.insert(holder.id(), texts(&left));
            }
            values.keys.insert(command.id(), texts(keys.as_slice()));
        });
    }
}
