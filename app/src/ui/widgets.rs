//! Controls that several panels share: sliders that reset, choices, the curve of a gradient.

use std::ops::RangeInclusive;

use egui::{
    PointerButton, Pos2, Rect, Response, Role, Sense, Slider, SliderClamping, Stroke, Ui, Vec2, WidgetInfo,
};

use super::theme;
use crate::paint::{Curve, Parameter};

/// A number with its unit and what more of it looks like.
pub(super) struct Number<'a> {
    pub(super) name: &'a str,
    pub(super) unit: &'a str,
    pub(super) hint: &'a str,
    pub(super) range: RangeInclusive<f32>,
    /// What a double-click puts back.
    pub(super) usual: f32,
    pub(super) logarithmic: bool,
}

impl<'a> Number<'a> {
    pub(super) fn new(name: &'a str, range: RangeInclusive<f32>, usual: f32, hint: &'a str) -> Self {
        Self {
            name,
            unit: "",
            hint,
            range,
            usual,
            logarithmic: false,
        }
    }

    pub(super) fn unit(self, unit: &'a str) -> Self {
        Self { unit, ..self }
    }

    pub(super) fn logarithmic(self) -> Self {
        Self {
            logarithmic: true,
            ..self
        }
    }

    /// The slider; returns it and whether the value changed.
    pub(super) fn show(self, ui: &mut Ui, value: &mut f32) -> (Response, bool) {
        let (low, high) = self.range.clone().into_inner();
        let slider = Slider::new(value, self.range)
            .logarithmic(self.logarithmic)
            // A value of the file beyond the slider's useful range stays until a person moves it.
            .clamping(SliderClamping::Edits)
            .max_decimals(if self.unit.is_empty() { 3 } else { 2 })
            .text(self.name)
            .suffix(self.unit);
        let unit = self.unit;
        let tooltip = format!(
            "{}\n{low}{unit} to {high}{unit}; double-click for {}{unit}",
            self.hint, self.usual
        );
        let response = ui.add(slider).on_hover_text(tooltip);
        // The slider itself takes drags only.
        let double = ui.input(|input| input.pointer.button_double_clicked(PointerButton::Primary));
        let reset = double && response.contains_pointer();
        if reset {
            *value = self.usual;
        }
        let changed = reset || response.changed();
        (response, changed)
    }
}

/// A slider for a parameter of an operation or a mask, whose usual value is `usual`.
pub(super) fn parameter(ui: &mut Ui, parameter: Parameter<'_>, usual: f32) -> (Response, bool) {
    let long = *parameter.range.end() > 400.0;
    let number = Number::new(parameter.name, parameter.range, usual, parameter.hint).unit(parameter.unit);
    let number = if long { number.logarithmic() } else { number };
    number.show(ui, parameter.value)
}

/// A choice among named values; true where another one was taken.
pub(super) fn choice<T: Clone + PartialEq>(
    ui: &mut Ui,
    label: &str,
    value: &mut T,
    names: impl IntoIterator<Item = (T, &'static str)>,
) -> bool {
    let names: Vec<_> = names.into_iter().collect();
    let before = value.clone();
    let current = names
        .iter()
        .find(|(v, _)| v == value)
        .map_or("", |(_, name)| name);
    egui::ComboBox::from_label(label)
        .selected_text(current)
        .show_ui(ui, |ui| {
            for (v, name) in names {
                ui.selectable_value(value, v, name);
            }
        });
    *value != before
}

/// A curve whose points are dragged, with usual shapes beside it; returns its response and whether it changed.
pub(super) fn curve_editor(ui: &mut Ui, curve: &mut Curve) -> (Response, bool) {
    let before = curve.clone();
    let (rect, response) = ui.allocate_exact_size(Vec2::new(180.0, 72.0), Sense::click_and_drag());
    response.widget_info(|| WidgetInfo::labeled(Role::Canvas, true, "Curve"));
    let inner = rect.shrink(6.0);
    let on_screen = |[x, y]: [f32; 2]| {
        Pos2::new(
            inner.left() + x * inner.width(),
            inner.bottom() - y * inner.height(),
        )
    };
    let pressed = response.drag_started() || response.clicked();
    if let Some(at) = response
        .interact_pointer_pos()
        .filter(|_| response.dragged() || pressed)
    {
        let x = ((at.x - inner.left()) / inner.width()).clamp(0.0, 1.0);
        let y = ((inner.bottom() - at.y) / inner.height()).clamp(0.0, 1.0);
        drag_point(curve, x, y);
    }
    let painter = ui.painter_at(rect);
    painter.rect_filled(rect, 3.0, ui.visuals().extreme_bg_color);
    let line: Vec<Pos2> = (0..=48)
        .map(|i| i as f32 / 48.0)
        .map(|x| on_screen([x, curve.at(x)]))
        .collect();
    painter.line(line, Stroke::new(1.5, theme::ACCENT));
    for point in &curve.0 {
        painter.rect_filled(
            Rect::from_center_size(on_screen(*point), Vec2::splat(6.0)),
            1.0,
            ui.visuals().strong_text_color(),
        );
    }
    let response = response.on_hover_text("How it rises from start to end: drag the points");
    ui.horizontal(|ui| {
        let shapes = [
            ("Soft", Curve::default()),
            ("Even", Curve::linear()),
            ("Early", Curve(vec![[0.0, 0.0], [0.3, 0.7], [1.0, 1.0]])),
            ("Late", Curve(vec![[0.0, 0.0], [0.7, 0.3], [1.0, 1.0]])),
        ];
        for (name, shape) in shapes {
            if ui.small_button(name).clicked() {
                *curve = shape;
            }
        }
    });
    let changed = *curve != before;
    (response, changed)
}

/// Moves the nearest point to (x, y) without passing its neighbours; the ends keep their x.
fn drag_point(curve: &mut Curve, x: f32, y: f32) {
    const GAP: f32 = 0.02;
    let points = &mut curve.0;
    let nearest = (0..points.len()).min_by(|a, b| {
        let distance = |i: &usize| (points[*i][0] - x).abs();
        distance(a).total_cmp(&distance(b))
    });
    let Some(i) = nearest else { return };
    points[i][1] = y;
    if i > 0 && i + 1 < points.len() {
        let (low, high) = (points[i - 1][0] + GAP, points[i + 1][0] - GAP);
        if low < high {
            points[i][0] = x.clamp(low, high);
        }
    }
}
