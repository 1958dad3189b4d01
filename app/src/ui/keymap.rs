//! Which keys do what: the preset of the navigation, and what a person changed.

use std::collections::BTreeMap;

use egui::{Key, KeyboardShortcut, Modifiers};

use super::{Command, settings::Navigation};

/// The keys of every command.
#[derive(Clone, Debug, PartialEq)]
pub struct Keymap(Vec<(Command, Vec<KeyboardShortcut>)>);

impl Keymap {
    /// The preset of `navigation` with `changed` keys; returns as well what of them no command or key is called.
    pub fn new(navigation: Navigation, changed: &BTreeMap<String, Vec<String>>) -> (Self, Vec<String>) {
        let mut unknown: Vec<String> = changed
            .keys()
            .filter(|id| Command::ALL.iter().all(|command| command.id() != **id))
            .cloned()
            .collect();
        let mut keys_of = |command: Command| match changed.get(&command.id()) {
            None => preset(navigation, command),
            Some(texts) => texts
                .iter()
                .filter_map(|text| {
                    let keys = parse(text);
                    if keys.is_none() {
                        unknown.push(text.clone());
                    }
                    keys
                })
                .collect(),
        };
        let all = Command::ALL
            .into_iter()
            .map(|command| (command, keys_of(command)))
            .collect();
        (Self(all), unknown)
    }

    /// The keys of a command; the first is the one that is shown.
    pub fn keys(&self, command: Command) -> &[KeyboardShortcut] {
        let found = self.0.iter().find(|(other, _)| *other == command);
        found.map_or(&[], |(_, keys)| keys)
    }

    /// The command that has these keys.
    pub fn holder(&self, keys: KeyboardShortcut) -> Option<Command> {
        let found = self.0.iter().find(|(_, own)| own.contains(&keys));
        found.map(|(command, _)| *command)
    }

    /// The command whose keys were pressed in this frame; longer shortcuts win.
    pub(super) fn pressed(&self, input: &mut egui::InputState) -> Option<Command> {
        let all = self.0.iter().filter(|(command, _)| !command.is_held());
        let mut keys: Vec<(KeyboardShortcut, Command)> = all
            .flat_map(|(command, keys)| keys.iter().map(|keys| (*keys, *command)))
            .collect();
        keys.sort_by_key(|(keys, _)| {
            std::cmp::Reverse(
                u8::from(keys.modifiers.shift)
                    + u8::from(keys.modifiers.command)
                    + u8::from(keys.modifiers.alt),
            )
        });
        keys.into_iter()
            .find(|(keys, _)| input.consume_shortcut(keys))
            .map(|(_, command)| command)
    }

    /// True while keys of `command` are down, with their modifiers and no others.
    pub(super) fn is_down(&self, command: Command, input: &egui::InputState) -> bool {
        self.keys(command)
            .iter()
            .any(|keys| input.modifiers.matches_exact(keys.modifiers) && input.key_down(keys.logical_key))
    }
}

/// The keys of a command where a person changed nothing.
pub(super) fn preset(navigation: Navigation, command: Command) -> Vec<KeyboardShortcut> {
    use Command as C;
    let usual = || command.shortcuts().to_vec();
    if navigation == Navigation::Maya {
        return usual();
    }
    // The system does not tell the number pad from the row above the letters: the numbers are views, the tools have Alt beside them.
    let (modifiers, key) = match command {
        C::FrameHair => (Modifiers::NONE, Key::Home),
        C::Eyedropper => (Modifiers::NONE, Key::S),
        C::BrushRadius => (Modifiers::NONE, Key::F),
        C::BrushStrength => (Modifiers::SHIFT, Key::F),
        C::ViewFront => (Modifiers::NONE, Key::Num1),
        C::ViewBack => (Modifiers::COMMAND, Key::Num1),
        C::ViewRight => (Modifiers::NONE, Key::Num3),
        C::ViewLeft => (Modifiers::COMMAND, Key::Num3),
        C::ViewTop => (Modifiers::NONE, Key::Num7),
        C::ViewBottom => (Modifiers::COMMAND, Key::Num7),
        C::PaintTool | C::CombTool | C::EraseTool | C::SmoothTool | C::MaskTool | C::LassoTool => {
            let keys = usual().into_iter().map(|keys| KeyboardShortcut {
                modifiers: Modifiers::ALT,
                ..keys
            });
            return keys.collect();
        }
        _ => return usual(),
    };
    vec![KeyboardShortcut::new(modifiers, key)]
}

/// `Ctrl+Shift+P`; Ctrl stands for Command on a Mac.
pub fn text(keys: KeyboardShortcut) -> String {
    let modifiers = keys.modifiers;
    let mut out = String::new();
    for (held, name) in [
        (modifiers.command || modifiers.ctrl, "Ctrl+"),
        (modifiers.shift, "Shift+"),
        (modifiers.alt, "Alt+"),
    ] {
        if held {
            out += name;
        }
    }
    out + keys.logical_key.name()
}

/// Keys by their text; none where it names no key.
pub fn parse(text: &str) -> Option<KeyboardShortcut> {
    let mut parts: Vec<&str> = text.split('+').collect();
    let key = Key::from_name(parts.pop()?)?;
    let mut modifiers = Modifiers::NONE;
    for part in parts {
        modifiers |= match part {
            "Ctrl" => Modifiers::COMMAND,
            "Shift" => Modifiers::SHIFT,
            "Alt" => Modifiers::ALT,
            _ => return None,
        };
    }
    Some(KeyboardShortcut::new(modifiers, key))
}

/// The keys that were pressed in this frame, as a shortcut; modifiers alone are none.
pub(super) fn typed(input: &egui::InputState) -> Option<KeyboardShortcut> {
    input.events.iter().find_map(|event| match event {
        egui::Event::Key {
            key,
            pressed: true,
            repeat: false,
            modifiers,
            ..
        } => {
            let mut plain = Modifiers::NONE;
            plain.alt = modifiers.alt;
            plain.shift = modifiers.shift;
            plain.command = modifiers.command;
            Some(KeyboardShortcut::new(plain, *key))
        }
        _ => None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_two_commands_share_a_key_in_any_preset() {
        for navigation in [Navigation::Maya, Navigation::Blender] {
            let (map, unknown) = Keymap::new(navigation, &BTreeMap::new());
            assert!(unknown.is_empty());
            for command in Command::ALL {
                for keys in map.keys(command) {
                    assert_eq!(map.holder(*keys), Some(command), "{}", text(*keys));
                }
            }
        }
    }

    #[test]
    fn keys_are_written_as_they_are_read() {
        for key in Key::ALL {
            for modifiers in [
                Modifiers::NONE,
                Modifiers::COMMAND | Modifiers::SHIFT,
                Modifiers::ALT,
            ] {
                let keys = KeyboardShortcut::new(modifiers, *key);
                assert_eq!(parse(&text(keys)), Some(keys), "{}", text(keys));
            }
        }
        assert!(parse("Ctrl+Nothing").is_none() && parse("Hyper+S").is_none() && parse("").is_none());
    }

    #[test]
    fn changed_keys_replace_the_presets_and_unknown_ones_are_named() {
        let changed = [
            ("save".to_owned(), vec!["Alt+W".to_owned(), "F50".to_owned()]),
            ("fly".to_owned(), vec![]),
        ];
        let (map, unknown) = Keymap::new(Navigation::Maya, &changed.into_iter().collect());
        assert_eq!(map.keys(Command::Save), [parse("Alt+W").unwrap()]);
        assert_eq!(map.holder(parse("Ctrl+S").unwrap()), None);
        assert_eq!(unknown, ["fly", "F50"]);
    }
}
