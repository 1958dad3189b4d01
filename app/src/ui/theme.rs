//! A quiet, dark-neutral look in which the hair is the only colourful thing.

use egui::{Color32, CornerRadius, Stroke, Theme, Visuals};

/// Grey behind the hair, display-linear.
pub(super) const BACKDROP: [f32; 4] = [0.032, 0.032, 0.032, 1.0];

/// Colour of things that are chosen.
pub(super) const ACCENT: Color32 = Color32::from_rgb(198, 146, 92);

/// Sets the look of `context`.
pub(super) fn apply(context: &egui::Context) {
    context.set_theme(Theme::Dark);
    // Greys of panels, windows, fields to type in, rails and boxes; of weak text and of text on what is chosen; colour of errors.
    let looks = [
        (Theme::Dark, [36, 40, 24, 60], [140, 240], [255, 140, 120]),
        (Theme::Light, [214, 222, 236, 178], [92, 20], [170, 30, 20]),
    ];
    for (theme, [panel, window, field, rail], [weak, text], [r, g, b]) in looks {
        let mut visuals = theme.default_visuals();
        visuals.panel_fill = Color32::from_gray(panel);
        visuals.window_fill = Color32::from_gray(window);
        visuals.extreme_bg_color = Color32::from_gray(field);
        visuals.widgets.inactive.bg_fill = Color32::from_gray(rail);
        visuals.error_fg_color = Color32::from_rgb(r, g, b);
        visuals.weak_text_color = Some(Color32::from_gray(weak));
        visuals.selection.bg_fill = ACCENT.gamma_multiply(0.55);
        visuals.selection.stroke = Stroke::new(1.0, Color32::from_gray(text));
        round(&mut visuals);
        context.set_visuals_of(theme, visuals);
    }
    context.all_styles_mut(|style| style.spacing.slider_width = 120.0);
}

fn round(visuals: &mut Visuals) {
    for widget in [
        &mut visuals.widgets.inactive,
        &mut visuals.widgets.hovered,
        &mut visuals.widgets.active,
        &mut visuals.widgets.open,
    ] {
        widget.corner_radius = CornerRadius::same(3);
    }
}
