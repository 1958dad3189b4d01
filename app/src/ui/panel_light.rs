//! The environment: which one, how it is turned, exposed and tinted, how well lights stand for it.

use balayage_render::light::{PRESETS, Picture};
use egui::{Context, Slider, SliderClamping, TextureHandle, TextureOptions, TextureWrapMode, Ui};

use super::{Command, Editor, job::Job, light_grab::Grab, sequence::Playing};
use crate::document::{Edit, Environment, FitReport, LightId, LightSettings};

/// Hair error that a target starts with, a fraction.
const USUAL_TARGET: f32 = 0.01;

/// Height of the list of environments, points: all of it is seen at once.
const LIST_HEIGHT: f32 = 360.0;

/// A preset's name as a person reads it.
fn title(preset: &str) -> String {
    let text = preset.replace('-', " ");
    let mut letters = text.chars();
    letters
        .next()
        .map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
}

/// What the light tab keeps between frames; no part of the project.
#[derive(Default)]
pub(super) struct LightTab {
    /// The light that is chosen.
    pub(super) selected: Option<LightId>,
    /// What the pointer holds in the panel of lights.
    pub(super) grab: Option<Grab>,
    /// Where the context menu of the panel was opened, world direction.
    pub(super) menu_at: Option<glam::Vec3>,
    /// When the wheel last changed a width, seconds.
    pub(super) wheel_secs: f64,
    /// Lights are drawn round the hair, too.
    pub(super) show_handles: bool,
    /// The sequence plays.
    pub(super) playing: Option<Playing>,
    /// The environment as a picture, unturned.
    pub(super) panorama: Option<TextureHandle>,
    /// Fits that were started.
    pub(super) fits_started: u64,
    report: Option<FitReport>,
    measuring: Option<Job<Option<FitReport>>>,
    /// A number of lights and a target error that are being dragged.
    wanted: Option<(u32, Option<f32>)>,
}

impl LightTab {
    /// Takes the picture of a new environment; it repeats sideways, so that it can be turned.
    pub(super) fn take_panorama(&mut self, context: &Context, picture: &Picture) {
        let image = egui::ColorImage::from_rgb([picture.width, picture.height], &picture.rgb);
        let options = TextureOptions {
            wrap_mode: TextureWrapMode::Repeat,
            ..TextureOptions::LINEAR
        };
        match &mut self.panorama {
            Some(texture) => texture.set(image, options),
            None => self.panorama = Some(context.load_texture("environment", image, options)),
        }
    }

    /// Forgets the last report and waits for that of `measuring`.
    pub(super) fn measure(&mut self, measuring: Option<Job<Option<FitReport>>>) {
        if let Some(job) = &self.measuring {
            job.cancel();
        }
        self.report = None;
        self.measuring = measuring;
    }

    /// Takes the report once it is there; what could not be measured is not shown.
    pub(super) fn take_report(&mut self) {
        if let Some(result) = self.measuring.as_ref().and_then(Job::poll) {
            self.measuring = None;
            self.report = result.ok().flatten();
        }
    }
}

impl Editor {
    pub(super) fn light_panel(&mut self, ui: &mut Ui) {
        let Some(document) = &self.document else { return };
        let light = document.project().light.clone();
        self.environment_choice(ui, &light);
        self.sequence_controls(ui);
        self.light_sliders(ui, &light);
        self.light_count(ui, &light);
        self.fit_report(ui);
        self.handles_checkbox(ui);
        self.light_map(ui);
        self.light_inspector(ui);
    }

    fn environment_choice(&mut self, ui: &mut Ui, light: &LightSettings) {
        let file_name = |path: &str| path.rsplit('/').next().unwrap_or(path).to_owned();
        let (name, whole) = match &light.environment {
            Environment::Sky => ("Sky".to_owned(), "A clear afternoon"),
            Environment::Constant(_) => ("Uniform".to_owned(), "The same light from everywhere"),
            Environment::Map(path) | Environment::Lights(path) => (file_name(path), path.as_str()),
            Environment::Preset(name) => (title(name), "A light of the editor"),
            Environment::Sequence(sequence) => (
                format!("Sequence of {} maps", sequence.maps.len()),
                "Maps that follow each other",
            ),
        };
        egui::ComboBox::from_label("Environment")
            .selected_text(&name)
            .height(LIST_HEIGHT)
            .show_ui(ui, |ui| {
                // Uniform light has its own colour here, which the preset has not.
                let presets = PRESETS.into_iter().filter(|name| *name != "uniform");
                let named = presets.map(|name| (title(name), Environment::Preset(name.to_owned())));
                let simple = [
                    ("Sky".to_owned(), Environment::Sky),
                    ("Uniform".to_owned(), Environment::Constant([1.0; 3])),
                ];
                for (name, environment) in simple.into_iter().chain(named) {
                    let chosen = match (&light.environment, &environment) {
                        (Environment::Constant(_), Environment::Constant(_)) => true,
                        (present, offered) => present == offered,
                    };
                    if ui.selectable_label(chosen, name).clicked() && !chosen {
                        self.edit(Edit::SetLight(light.with_environment(environment)));
                    }
                }
                for command in [
                    Command::OpenEnvironment,
                    Command::OpenLights,
                    Command::OpenSequence,
                    Command::OpenSequenceFolder,
                ] {
                    if ui.button(command.label()).clicked() {
                        self.run(ui.ctx(), command);
                    }
                }
            })
            .response
            .on_hover_text(whole);
        if let Environment::Constant(rgb) = light.environment {
            self.colour(ui, "Radiance", "Linear radiance from everywhere", rgb, |rgb| {
                LightSettings {
                    environment: Environment::Constant(rgb),
                    ..light.clone()
                }
            });
        }
    }

    /// Rotation, exposure and tint: none of them needs a new fit.
    fn light_sliders(&mut self, ui: &mut Ui, light: &LightSettings) {
        type Field = fn(&mut LightSettings) -> &mut f32;
        let fields: [(&str, &str, &str, std::ops::RangeInclusive<f32>, Field); 2] = [
            (
                "Rotation",
                "°",
                "Turns the environment; Shift+right drag in the viewport. Double-click resets",
                0.0..=360.0,
                |light| &mut light.rotation_deg,
            ),
            (
                "Exposure",
                " EV",
                "Brightness of all light, in stops. Double-click resets",
                -8.0..=8.0,
                |light| &mut light.exposure_ev,
            ),
        ];
        for (name, unit, hint, range, field) in fields {
            let mut changed = light.clone();
            if name == "Rotation" {
                // Files may turn it backwards or more than once.
                changed.rotation_deg = changed.rotation_deg.rem_euclid(360.0);
            }
            let slider = Slider::new(field(&mut changed), range)
                .clamping(SliderClamping::Edits)
                .text(name)
                .suffix(unit);
            let slider = ui.add(slider).on_hover_text(hint);
            if slider.double_clicked() {
                *field(&mut changed) = 0.0;
            }
            if slider.changed() || slider.double_clicked() {
                self.edit_by(&slider, Edit::SetLight(changed));
            }
        }
        let hint = "A colour filter before all light; white changes nothing";
        self.colour(ui, "Tint", hint, light.tint, |tint| LightSettings {
            tint,
            ..light.clone()
        });
    }

    /// A colour of the light settings.
    fn colour(
        &mut self,
        ui: &mut Ui,
        name: &str,
        hint: &str,
        mut rgb: [f32; 3],
        settings: impl FnOnce([f32; 3]) -> LightSettings,
    ) {
        ui.horizontal(|ui| {
            let button = ui.color_edit_button_rgb(&mut rgb).on_hover_text(hint);
            button.widget_info(|| egui::WidgetInfo::labeled(egui::Role::ColorWell, true, name));
            ui.label(name);
            if button.changed() {
                self.edit_by(&button, Edit::SetLight(settings(rgb)));
            }
        });
    }

    /// How many lights, or how good they are to be. Either means a new fit: it waits until the slider is released.
    fn light_count(&mut self, ui: &mut Ui, light: &LightSettings) {
        let is_fitted = self
            .lighting
            .as_ref()
            .is_some_and(|lighting| lighting.map.is_some());
        let present = (light.light_count, light.target_error);
        let (mut count, mut target) = self.light_tab.wanted.unwrap_or(present);
        let mut dragged = false;
        ui.add_enabled_ui(is_fitted, |ui| {
            let mut by_error = target.is_some();
            let hint = "As few lights as reach a hair error, instead of a number of them";
            if ui
                .checkbox(&mut by_error, "Lights by error")
                .on_hover_text(hint)
                .changed()
            {
                target = by_error.then_some(USUAL_TARGET);
            }
            if let Some(target) = &mut target {
                let mut percent = 100.0 * *target;
                let slider = Slider::new(&mut percent, 0.1..=20.0)
                    .logarithmic(true)
                    .suffix(" %")
                    .text("Hair error");
                let slider = ui.add(slider).on_hover_text(
                    "Error of the light on random fibres (RMS) that is good enough. Double-click: 1 %",
                );
                if slider.double_clicked() {
                    *target = USUAL_TARGET;
                } else if slider.changed() {
                    *target = percent / 100.0;
                }
                dragged |= slider.dragged();
            }
            let (text, hint) = if target.is_some() {
                (
                    "Most lights",
                    "No more lights than this, even if the error stays higher. Double-click: 40",
                )
            } else {
                (
                    "Lights",
                    "Lights that stand for the map: more are finer and slower. Double-click: 40",
                )
            };
            let slider = ui
                .add(Slider::new(&mut count, 1..=100).text(text))
                .on_hover_text(hint);
            if slider.double_clicked() {
                count = LightSettings::default().light_count;
            }
            dragged |= slider.dragged();
        });
        self.light_tab.wanted = ((count, target) != present).then_some((count, target));
        if self.light_tab.wanted.is_some() && !dragged {
            self.light_tab.wanted = None;
            self.edit(Edit::SetLight(LightSettings {
                light_count: count,
                target_error: target,
                ..light.clone()
            }));
        }
    }

    fn fit_report(&self, ui: &mut Ui) {
        let Some(lighting) = &self.lighting else { return };
        let Some(seconds) = lighting.fit_seconds else {
            return;
        };
        let count = lighting.lights.lights.len();
        let mut text = format!("{count} lights fitted in {:.0} ms", 1e3 * seconds);
        match self.light_tab.report {
            Some(FitReport {
                hair_error,
                energy_error,
            }) => {
                let energy = energy_error.into_iter().fold(0.0, |a, b| f64::max(a, b.abs()));
                text += &format!(
                    ", hair {:.2} %, energy {:.2} %",
                    100.0 * hair_error,
                    100.0 * energy
                );
            }
            None if self.light_tab.measuring.is_some() => text += ", measuring…",
            None => {}
        }
        ui.weak(text).on_hover_text(
            "How far the fitted lights are from the map: as random fibres of hair see it (RMS), and in the whole energy of the worst \
             colour channel. Edits by hand do not count",
        );
    }
}
