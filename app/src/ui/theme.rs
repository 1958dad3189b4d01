//! A quiet, dark-neutral look in which the hair is the only colourful thing.

use egui::{Color32, CornerRadius, Stroke, Theme, Visuals};

/// Grey behind the hair, display-linear.
pub(super) const BACKDROP: [f32; 4] = [0.032, 0.032, 0.032, 1.0];

/// Colour of things that are chosen.
pub(super) const ACCENT: Color32 = Color32::from_rgb(198, 146, 92);

/// Sets the look of `context`.
pub(super) fn apply(context: &egui::Context) {
    context.set_theme(Theme::Dark);
    let mut visuals = Visuals::dark();
    visuals.panel_fill = Color32::from_gray(36);
    visuals.window_fill = Color32::from_gray(40);
    visuals.extreme_bg_color = Color32::from_gray(24);
    visuals.selection.bg_fill = ACCENT.gamma_multiply(0.55);
    visuals.selection.stroke = Stroke::new(1.0, Color32::from_gray(240));
    for widget in [
        &mut visuals.widgets.inactive,
        &mut visuals.widgets.hovered,
        &mut visuals.widgets.active,
        &mut visuals.widgets.open,
    ] {
        widget.corner_radius = CornerRadius::same(3);
    }
    context.set_visuals_of(Theme::Dark, visuals);
    context.global_style_mut(|style| style.spacing.slider_width = 120.0);
}
