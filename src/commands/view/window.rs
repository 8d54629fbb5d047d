//! The window: the image, the settings beside it, and what the mouse and the keys do.

mod layers;
mod link;
mod navigation;
mod rendering;

use std::ops::RangeInclusive;
use std::panic::{self, AssertUnwindSafe};
use std::sync::Arc;
use std::thread::{self, Builder, sleep};
use std::time::{Duration, Instant};

use clap::ValueEnum;
use eframe::egui::{
    CentralPanel, Color32, ColorImage, ComboBox, Context, DragValue, Image, Key, Panel, PointerButton, Pos2, Rect,
    Response, RichText, Role, ScrollArea, Sense, TextureFilter, TextureHandle, TextureOptions, Ui, Vec2,
    ViewportBuilder, ViewportCommand, WidgetInfo, vec2,
};
use eframe::{App, AppCreator, Error as WindowError, Frame, NativeOptions};

use super::args::WindowArgs;
use crate::aov::Aov;
use crate::commands::changes::check_watched;
use crate::commands::console::{tell, tell_error};
use crate::commands::scene::name_of;
use crate::commands::signals::{Signals, WAIT};
use crate::error::{Error, Result};
use crate::film::UNKNOWN_VARIANCE;
use crate::output::view_transform::{Tonemap, ViewTransform};
use crate::printable::percent;
use crate::scene::Camera;
use layers::{AOVS, PictureLayer, Shown};
use link::PixelSurface;
pub use link::{Link, ViewState};
use navigation::{dolly, f_number, field_of_view, orbit, pan, set_f_number, turn_around};
pub use rendering::Rendering;

/// The angle for a drag over the height of the image, in radians, and for a key.
const TURN: f64 = 3.0;
const KEY_TURN: f64 = 0.1;
/// The shift for a key, in heights of the view.
const KEY_SHIFT: f64 = 0.05;
/// The share of the distance for a key, and the power of e for a point of the wheel.
const KEY_SHARE: f64 = 0.9;
const WHEEL: f64 = 0.005;
/// The largest f-number: above it a lens is a pinhole.
const PINHOLE: f64 = 1e4;
/// How long the thread that renders may take to end. A driver that compiles cannot be stopped.
const PATIENCE: Duration = Duration::from_secs(2);
/// The least and the largest window at the start, and the width of the settings, in points.
const SIZES: (Vec2, Vec2) = (vec2(640.0, 480.0), vec2(1600.0, 900.0));
const SETTINGS: f32 = 260.0;

/// The state of the window.
#[derive(Default)]
pub struct Window {
    link: Arc<Link>,
    /// The signals that close it.
    signals: Signals,
    /// The camera of the view.
    pub camera: Camera,
    /// The camera of the scene file, and that of a reset, which may have another target.
    read: Camera,
    start: Camera,
    view: ViewTransform,
    /// Whether the next click makes what it meets sharp, and the pixel of that click.
    focuses: bool,
    focus: Option<(u32, u32)>,
    /// The middle of the image, if the camera will turn around what it shows: files of other programs have no target.
    target: Option<(u32, u32)>,
    /// The pixel under the mouse.
    hovered: Option<(u32, u32)>,
    /// The texture of a picture, with that, the exposure and the curve.
    texture: Option<(TextureHandle, Arc<Shown>, (f64, Tonemap))>,
}

/// Opens the window, until it is closed or a signal comes.
///
/// # Errors
/// `Error::Usage` without a display that has OpenGL, `Error::Device` where it has gone, `Error::Interrupted` after a signal. Else those of
/// `render`.
pub fn run(args: &WindowArgs) -> Result<()> {
    let (signals, link) = (Signals::listen("nothing has been written"), Arc::<Link>::default());
    if args.watch {
        check_watched(&args.scene.path)?;
    }
    let rendering = Rendering::open(args, Arc::clone(&link))?;
    let mut window = Window::new(Arc::clone(&link), args.view.transform());
    window.signals = signals.clone();
    let (width, height) = link.state().size;
    if args.scene.path.extension().is_some_and(|ending| ending != "ron") {
        window.target = Some((width / 2, height / 2));
        link.order(|orders| orders.pixel = window.target);
    }
    let size = vec2(width as f32 + SETTINGS, height as f32 + 60.0).clamp(SIZES.0, SIZES.1);
    let title = format!("{} - gpu-rt", name_of(&args.scene.path));
    let viewport = ViewportBuilder::default().with_title(title).with_app_id("gpu-rt").with_inner_size(size);
    let options = NativeOptions { viewport, ..NativeOptions::default() };
    let no_thread = |error| Error::Device(format!("the system gives no thread: {error}"));
    let renderer = Builder::new().name("renderer".to_owned()).spawn(move || rendering.run()).map_err(no_thread)?;
    let (theirs, came) = (Arc::clone(&link), signals.clone());
    let create: AppCreator<'_> = Box::new(move |context| {
        let ctx = context.egui_ctx.clone();
        let _ = theirs.repaint.set(Box::new(move || ctx.request_repaint()));
        wake_for(came, theirs);
        Ok(Box::new(window))
    });
    let opened = caught(|| eframe::run_native("gpu-rt", options, create));
    if let Some(text) = link.orders().camera {
        tell(&format!("camera: {text}"));
    }
    link.order(|orders| orders.ends = true);
    let begin = Instant::now();
    while !renderer.is_finished() && begin.elapsed() < PATIENCE {
        sleep(Duration::from_millis(5));
    }
    let result = match opened {
        _ if signals.have_come() => Err(signals.interrupted("the window is closed")),
        Ok(result) => result.map_err(|error| explained(&error)),
        Err(reason) => Err(Error::Device(format!("the display has failed: {reason}"))),
    };
    if !renderer.is_finished() {
        // Destructors of a driver that is at work may crash.
        result.as_ref().err().iter().for_each(|error| tell_error(error));
        signal_hook::low_level::exit(result.map_or_else(|error| error.exit_status(), |()| 0).into());
    }
    result
}

/// Wakes the window when a signal comes. Without a thread for that, a signal is noticed with the next picture.
fn wake_for(signals: Signals, link: Arc<Link>) {
    let wait = move || {
        while !signals.have_come() && !link.orders().ends {
            sleep(WAIT);
        }
        link.tell(|_| ());
    };
    let _ = Builder::new().name("signals".to_owned()).spawn(wait);
}

/// The result of the window; where its libraries panic, as they do if another program destroys it, the reason.
fn caught<T>(window: impl FnOnce() -> T) -> std::result::Result<T, String> {
    let (this, usual) = (thread::current().id(), Arc::new(panic::take_hook()));
    let others = Arc::clone(&usual);
    panic::set_hook(Box::new(move |info| {
        if thread::current().id() != this {
            others(info)
        }
    }));
    let result = panic::catch_unwind(AssertUnwindSafe(window));
    panic::set_hook(Box::new(move |info| usual(info)));
    result.map_err(|panic| panic.downcast_ref::<String>().cloned().unwrap_or_default())
}

fn explained(error: &WindowError) -> Error {
    let words = error.to_string();
    let reason = words.rsplit(": ").next().unwrap_or_default().trim_end_matches('.');
    Error::Usage(format!("there is no display for a window: {reason}. `gpu-rt render --preview` draws in the terminal"))
}

impl App for Window {
    /// Also called while the window is hidden.
    fn logic(&mut self, context: &Context, _: &mut Frame) {
        if self.signals.have_come() {
            context.send_viewport_cmd(ViewportCommand::Close);
        }
    }

    fn ui(&mut self, ui: &mut Ui, _: &mut Frame) {
        self.draw(ui);
    }
}

impl Window {
    /// The window of a scene that has been read.
    pub fn new(link: Arc<Link>, view: ViewTransform) -> Window {
        let read = link.state().camera;
        Window { link, view, camera: read.clone(), start: read.clone(), read, ..Window::default() }
    }

    /// Draws the window, and takes what the user does.
    pub fn draw(&mut self, ui: &mut Ui) {
        let state = self.link.state();
        self.take(&state);
        if !ui.ctx().egui_wants_keyboard_input() {
            self.keys(ui);
        }
        Panel::right("settings").exact_size(SETTINGS).show(ui, |ui| {
            ScrollArea::vertical().show(ui, |ui| {
                self.camera_settings(ui);
                ui.separator();
                self.picture_settings(ui, &state);
                ui.separator();
                self.pixel(ui, &state);
            })
        });
        Panel::bottom("state").show(ui, |ui| state_line(ui, &state));
        CentralPanel::no_frame().show(ui, |ui| self.image(ui, &state));
    }

    /// Takes what the thread has found.
    fn take(&mut self, state: &ViewState) {
        let is_moved = self.camera != self.start;
        if state.camera != self.read {
            (self.read, self.start) = (state.camera.clone(), state.camera.clone());
            if !is_moved {
                self.camera = self.start.clone();
            }
        }
        let Some(surface) = &state.surface else { return };
        let found = Some(surface.pixel);
        if self.target.take_if(|pixel| Some(*pixel) == found).is_some() && !is_moved && surface.names.is_some() {
            [&mut self.camera, &mut self.start].into_iter().for_each(|camera| turn_around(camera, surface.depth));
        }
        if self.focus.take_if(|pixel| Some(*pixel) == found).is_some() && surface.names.is_some() {
            self.camera.focus_distance = Some(surface.depth);
            self.moved();
        }
    }

    /// Orders an image from where the camera is now.
    fn moved(&mut self) {
        let text = self.camera.text();
        self.link.order(|orders| {
            (orders.camera, orders.moved) = (Some(text), Some(Instant::now()));
            orders.revision += 1;
        });
    }

    fn reset(&mut self) {
        self.camera = self.start.clone();
        self.link.order(|orders| (orders.camera, orders.revision) = (None, orders.revision + 1));
    }

    fn pause(&mut self) {
        self.link.order(|orders| orders.paused = !orders.paused);
    }

    fn order_save(&self) {
        self.link.order(|orders| orders.save = Some(self.view));
    }

    fn copy(&self, ui: &Ui) {
        let text = format!("camera: {}", self.camera.text());
        tell(&text);
        ui.ctx().copy_text(text);
    }

    fn keys(&mut self, ui: &Ui) {
        let (pressed, shift) = ui.input(|input| {
            let pressed = |key: &Key| !input.modifiers.command && !input.modifiers.alt && input.key_pressed(*key);
            (Key::ALL.iter().copied().filter(pressed).collect::<Vec<_>>(), input.modifiers.shift)
        });
        for key in pressed {
            match key {
                Key::ArrowLeft => self.step(-1.0, 0.0, shift),
                Key::ArrowRight => self.step(1.0, 0.0, shift),
                Key::ArrowUp => self.step(0.0, 1.0, shift),
                Key::ArrowDown => self.step(0.0, -1.0, shift),
                Key::Plus | Key::Equals => self.approach(KEY_SHARE),
                Key::Minus => self.approach(1.0 / KEY_SHARE),
                Key::Num0 => self.reset(),
                Key::Space => self.pause(),
                Key::F => self.focuses = !self.focuses,
                Key::C => self.copy(ui),
                Key::S => self.order_save(),
                Key::R => self.link.order(|orders| orders.revision += 1),
                Key::Q => ui.ctx().send_viewport_cmd(ViewportCommand::Close),
                _ => {}
            }
        }
    }

    /// Turns the camera by a key, or shifts it.
    fn step(&mut self, x: f64, y: f64, shifts: bool) {
        match shifts {
            true => pan(&mut self.camera, KEY_SHIFT * x, KEY_SHIFT * y),
            false => orbit(&mut self.camera, KEY_TURN * x, -KEY_TURN * y),
        }
        self.moved();
    }

    fn approach(&mut self, share: f64) {
        dolly(&mut self.camera, share);
        self.moved();
    }

    fn camera_settings(&mut self, ui: &mut Ui) {
        ui.heading("Camera");
        let mut camera = self.camera.clone();
        if let Some(mut degrees) = field_of_view(&camera) {
            if number(ui, "Field of view, degrees", &mut degrees, 0.01..=179.0) {
                (camera.vertical_fov, camera.projection) = (Some(degrees), None);
            }
            let mut f = f_number(&camera).min(PINHOLE);
            if number(ui, "f-number", &mut f, 1e-9..=PINHOLE) {
                set_f_number(&mut camera, if f < PINHOLE { f } else { f64::INFINITY });
            }
        }
        let mut distance = camera.focus_distance.unwrap_or((camera.look_at - camera.look_from).length());
        if number(ui, "Focus distance", &mut distance, 1e-30..=1e30) {
            camera.focus_distance = Some(distance);
        }
        if camera != self.camera {
            self.camera = camera;
            self.moved();
        }
        ui.toggle_value(&mut self.focuses, "Focus by a click")
            .on_hover_text("F. The next click makes sharp what it meets");
        ui.horizontal(|ui| {
            if ui.button("Reset").on_hover_text("0. The camera of the scene").clicked() {
                self.reset();
            }
            if ui.button("Copy").on_hover_text("C. The camera as text, to the clipboard and the terminal").clicked() {
                self.copy(ui);
            }
        });
    }

    fn picture_settings(&mut self, ui: &mut Ui, state: &ViewState) {
        ui.heading("Picture");
        number(ui, "Exposure, stops", &mut self.view.exposure, -100.0..=100.0);
        let curves = Tonemap::value_variants().iter().map(|curve| (*curve, word(curve)));
        choice(ui, "Curve", &mut self.view.tonemap, curves.collect());
        let mut layers = vec![
            (PictureLayer::Radiance, "radiance".to_owned()),
            (PictureLayer::Error, "error, 0.1 % to 100 %".to_owned()),
        ];
        layers.extend(AOVS.map(|aov| (PictureLayer::Of { aov, number: 0 }, word(&aov))));
        let lights = state.shown.iter().flat_map(|shown| shown.lights.iter().cloned()).enumerate();
        layers.extend(lights.map(|(number, name)| (PictureLayer::Of { aov: Aov::Lights, number }, name)));
        let mut layer = self.link.orders().layer;
        if choice(ui, "Layer", &mut layer, layers) {
            self.link.order(|orders| orders.layer = layer);
        }
        ui.horizontal(|ui| {
            if ui.button(if self.link.orders().paused { "Go on" } else { "Pause" }).on_hover_text("Space").clicked() {
                self.pause();
            }
            if ui.button("Save EXR and PNG").on_hover_text("S. With the samples so far").clicked() {
                self.order_save();
            }
        });
    }

    /// The values of the pixel under the mouse or of the last click, and the surface there.
    fn pixel(&self, ui: &mut Ui, state: &ViewState) {
        ui.heading("Pixel");
        let pixel = self.hovered.or(state.surface.as_ref().map(|surface| surface.pixel));
        if let (Some(pixel), Some(shown)) = (pixel, &state.shown) {
            ui.label(words_of_pixel(shown, pixel, state.size));
        }
        ui.label(match &state.surface {
            None => "A click finds the object and its distance".to_owned(),
            Some(PixelSurface { pixel: (x, y), names: None, .. }) => format!("{x}, {y}: no surface"),
            Some(PixelSurface { pixel: (x, y), names: Some((object, material)), distance, .. }) => {
                format!("{x}, {y}: {object}\nmaterial {material}\ndistance {distance:.6}")
            }
        });
        ui.separator();
        ui.label(RichText::new("Drag to turn. Shift or the right button shifts, the wheel goes nearer").weak());
    }

    /// The image, as large as there is room.
    fn image(&mut self, ui: &mut Ui, state: &ViewState) {
        let full = vec2(state.size.0 as f32, state.size.1 as f32);
        let (all, response) =
            ui.allocate_exact_size(ui.available_size().max(Vec2::splat(1.0)), Sense::click_and_drag());
        response.widget_info(|| WidgetInfo::labeled(Role::Image, true, "Image"));
        let rect = Rect::from_center_size(all.center(), full * (all.size() / full).min_elem());
        ui.painter().rect_filled(all, 0.0, Color32::from_gray(24));
        if let Some(shown) = &state.shown {
            Image::new((self.texture_of(ui, shown), rect.size())).paint_at(ui, rect);
        }
        self.mouse(ui, &response, rect, state.size);
    }

    fn mouse(&mut self, ui: &Ui, response: &Response, rect: Rect, (width, height): (u32, u32)) {
        let (shift, wheel) = ui.input(|input| (input.modifiers.shift, input.smooth_scroll_delta.y));
        let drag = response.drag_delta() / rect.height();
        if response.dragged() && drag != Vec2::ZERO {
            // In a mirrored image, left is right.
            let (x, y) = (f64::from(if self.camera.mirror { -drag.x } else { drag.x }), f64::from(drag.y));
            match response.dragged_by(PointerButton::Primary) && !shift {
                true => orbit(&mut self.camera, -TURN * x, -TURN * y),
                false => pan(&mut self.camera, -x, y),
            }
            self.moved();
        }
        if response.hovered() && wheel != 0.0 {
            self.approach((-WHEEL * f64::from(wheel)).exp());
        }
        let pixel = |at: Pos2| {
            let share = (at - rect.min) / rect.size();
            let along = |share: f32, all: u32| ((share * all as f32) as u32).min(all - 1);
            rect.contains(at).then(|| (along(share.x, width), along(share.y, height)))
        };
        self.hovered = response.hover_pos().and_then(pixel);
        if let Some(pixel) = response.interact_pointer_pos().filter(|_| response.clicked()).and_then(pixel) {
            self.focus = std::mem::take(&mut self.focuses).then_some(pixel);
            self.link.order(|orders| orders.pixel = Some(pixel));
        }
    }

    /// The texture of what is shown, as large as textures can be.
    fn texture_of(&mut self, ui: &Ui, shown: &Arc<Shown>) -> eframe::egui::TextureId {
        let view = (self.view.exposure, self.view.tonemap);
        if let Some((texture, of, by)) = &self.texture
            && Arc::ptr_eq(of, shown)
            && *by == view
        {
            return texture.id();
        }
        let (width, height) = (shown.picture.width as usize, shown.picture.height as usize);
        let step = width.max(height).div_ceil(ui.input(|input| input.max_texture_side).max(1)).max(1);
        let colours = shown.colours(&self.view);
        let pixels = (0..height).step_by(step).flat_map(|y| (0..width).step_by(step).map(move |x| y * width + x));
        let pixels = pixels.map(|index| colours[index]).map(|[r, g, b]| Color32::from_rgb(r, g, b)).collect();
        // A small picture is smooth. In the image, pixels are seen.
        let magnification = if shown.is_small { TextureFilter::Linear } else { TextureFilter::Nearest };
        let options = TextureOptions { magnification, ..TextureOptions::LINEAR };
        let image = ColorImage::new([width.div_ceil(step), height.div_ceil(step)], pixels);
        self.texture.insert((ui.ctx().load_texture("image", image, options), Arc::clone(shown), view)).0.id()
    }
}

/// How the command line names a value.
fn word(value: &impl ValueEnum) -> String {
    value.to_possible_value().map_or_else(String::new, |value| value.get_name().to_owned())
}

/// A number with its name. Returns whether the user has changed it: a value of the scene stays, even beyond the range.
fn number(ui: &mut Ui, name: &str, value: &mut f64, range: RangeInclusive<f64>) -> bool {
    let row = |ui: &mut Ui| {
        let label = ui.label(name);
        let speed = (value.abs() * 0.01).clamp(1e-9, 1e9).max(if *range.start() < 0.0 { 0.02 } else { 0.0 });
        let field = DragValue::new(value).range(range).clamp_existing_to_range(false).speed(speed).max_decimals(6);
        ui.add(field).labelled_by(label.id).changed()
    };
    ui.horizontal(row).inner
}

/// A list to choose from. Returns whether the choice is another one.
fn choice<T: Copy + PartialEq>(ui: &mut Ui, name: &str, chosen: &mut T, values: Vec<(T, String)>) -> bool {
    let before = *chosen;
    let selected = values.iter().find(|(value, _)| *value == before).map_or("", |(_, name)| name).to_owned();
    ComboBox::from_label(name).height(400.0).selected_text(selected).show_ui(ui, |ui| {
        for (value, name) in values {
            ui.selectable_value(chosen, value, name);
        }
    });
    *chosen != before
}

/// The line below the image: the samples, their error, and what takes time.
fn state_line(ui: &mut Ui, state: &ViewState) {
    for error in &state.errors {
        ui.colored_label(Color32::LIGHT_RED, error).on_hover_text("R tries again");
    }
    ui.horizontal_wrapped(|ui| {
        match state.shown.as_ref().filter(|shown| !shown.is_small) {
            None => drop(ui.label("a small picture of the view")),
            Some(shown) => {
                ui.label(format!("{} of {} samples, {:.3} a second", shown.samples, state.samples, shown.pace));
                ui.label(&shown.error);
                if !shown.reasons.is_empty() {
                    ui.colored_label(Color32::YELLOW, "unreliable").on_hover_text(shown.reasons.join("\n"));
                }
            }
        }
        ui.label(if state.is_compiling { "compiling" } else { "" });
        ui.label(&state.message);
    });
}

/// The value of a pixel of the image, its variance, and its error.
fn words_of_pixel(shown: &Shown, (x, y): (u32, u32), size: (u32, u32)) -> String {
    let index = shown.index((x, y), size);
    let Some(rgb) = shown.picture.rgb.get(index) else { return String::new() };
    let numbers = |values: &[f32; 3]| values.map(|value| format!("{value:.5}")).join(" ");
    let variance = shown.picture.variance[index];
    let words = match variance.contains(&UNKNOWN_VARIANCE) {
        true => "variance unknown".to_owned(),
        false => {
            let variance = variance.map(|value| format!("{value:.2e}")).join(" ");
            format!("variance {variance}\nrelative error {}", percent(shown.error_at(index)))
        }
    };
    let values = shown.values.get(index).map_or_else(String::new, |values| format!("\nlayer {}", numbers(values)));
    format!("{x}, {y}\nradiance {}\n{words}{values}", numbers(rgb))
}
