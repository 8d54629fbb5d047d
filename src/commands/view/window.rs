//! The window: the image, the settings beside it, and what the mouse and the keys do.

mod layers;
mod link;
mod navigation;
mod rendering;

use std::ops::RangeInclusive;
use std::sync::Arc;
use std::thread::{Builder, sleep};
use std::time::{Duration, Instant};

use clap::ValueEnum;
use eframe::egui::{
    CentralPanel, Color32, ColorImage, ComboBox, Context, DragValue, Event, Image, Key, Panel, PointerButton, Pos2,
    Rect, Response, RichText, Role, ScrollArea, Sense, TextureFilter, TextureHandle, TextureOptions, Ui, Vec2,
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
use crate::guard::caught;
use crate::options::Word;
use crate::output::view_transform::{Tonemap, ViewTransform};
use crate::printable::percent;
use crate::scene::Camera;
use layers::{AOVS, PictureLayer, Shown};
pub use link::{Link, ViewState};
use navigation::{dolly, field_of_view, focal_length, orbit, pan};
pub use rendering::Rendering;

/// The angle for a drag over the height of the image, in radians.
const TURN: f64 = 3.0;
/// The drag that a key stands for, in heights of the image.
const KEY_DRAG: f64 = 0.04;
/// The share of the distance for a key, and the power of e for a point of the wheel.
const KEY_SHARE: f64 = 0.9;
const WHEEL: f64 = 0.005;
/// The largest f-number: above it a lens is a pinhole.
const PINHOLE: f64 = 1e4;
/// How long the thread that renders may take to end. A driver that compiles cannot be stopped.
const PATIENCE: Duration = Duration::from_secs(2);
/// The width of the settings, in points.
const SETTINGS: f32 = 260.0;

/// The state of the window.
#[derive(Default)]
pub struct Window {
    link: Arc<Link>,
    /// The signals that close it.
    signals: Signals,
    /// The camera of the view.
    pub camera: Camera,
    /// The camera of the scene.
    read: Camera,
    view: ViewTransform,
    /// Whether the next click makes what it meets sharp, and the pixel of that click.
    focuses: bool,
    focus: Option<(u32, u32)>,
    /// The pixel under the mouse.
    hovered: Option<(u32, u32)>,
    /// The texture of a picture, with that, the exposure and the curve.
    texture: Option<(TextureHandle, Arc<Shown>, ViewTransform)>,
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
    let window = Window { signals: signals.clone(), ..Window::new(Arc::clone(&link), args.view.transform()) };
    let (width, height) = link.state().size;
    let size = vec2(width as f32 + SETTINGS, height as f32 + 60.0).clamp(vec2(640.0, 480.0), vec2(1600.0, 900.0));
    let title = format!("{} - gpu-rt", name_of(&args.scene.path));
    let viewport = ViewportBuilder::default().with_title(title).with_app_id("gpu-rt").with_inner_size(size);
    let options = NativeOptions { viewport, ..NativeOptions::default() };
    let no_thread = |error| Error::Device(format!("the system gives no thread: {error}"));
    let renderer = Builder::new().name("renderer".to_owned()).spawn(move || rendering.run()).map_err(no_thread)?;
    let (theirs, came) = (Arc::clone(&link), signals.clone());
    let create: AppCreator<'_> = Box::new(move |context| {
        let ctx = context.egui_ctx.clone();
        let _ = theirs.repaint.set(Box::new(move || ctx.request_repaint()));
        // Without a thread for that, a signal is noticed with the next picture.
        let _ = Builder::new().spawn(move || {
            while !came.have_come() {
                sleep(WAIT);
            }
            theirs.tell(|_| ());
        });
        Ok(Box::new(window))
    });
    // The libraries of the window panic if another program destroys it.
    let opened = caught(|| eframe::run_native("gpu-rt", options, create));
    link.orders().camera.iter().for_each(|text| tell(&format!("camera: {text}")));
    link.order(|orders| orders.ends = true);
    let begin = Instant::now();
    while !renderer.is_finished() && begin.elapsed() < PATIENCE {
        sleep(Duration::from_millis(5));
    }
    let result = match opened {
        _ if signals.have_come() => Err(signals.interrupted("the window is closed")),
        Ok(Ok(())) => Ok(()),
        Ok(Err(error)) if link.repaint.get().is_none() => Err(explained(&error)),
        Ok(Err(error)) => Err(Error::Device(format!("the display has failed: {error}"))),
        Err(reason) => Err(Error::Device(format!("the display has failed: {reason}"))),
    };
    if !renderer.is_finished() {
        // Destructors of a driver that is at work may crash.
        result.as_ref().err().iter().for_each(|error| tell_error(error));
        signal_hook::low_level::exit(result.map_or_else(|error| error.exit_status(), |()| 0).into());
    }
    result
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
        Window { link, view, camera: read.clone(), read, ..Window::default() }
    }

    /// Draws the window, and takes what the user does.
    pub fn draw(&mut self, ui: &mut Ui) {
        let state = self.link.state();
        self.take(&state);
        for event in ui.input(|input| input.events.clone()) {
            if let Event::Key { key, pressed: true, modifiers, .. } = event
                && !(modifiers.command || modifiers.alt || ui.ctx().egui_wants_keyboard_input())
            {
                self.press(key, modifiers.shift, ui);
            }
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
        if self.camera == self.read {
            self.camera = state.camera.clone();
        }
        self.read = state.camera.clone();
        let Some(surface) = &state.surface else { return };
        if self.focus.take_if(|pixel| *pixel == surface.pixel).is_some() && surface.depth.is_some() {
            self.camera.focus_distance = surface.depth;
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

    /// Does what a key stands for.
    fn press(&mut self, key: Key, shift: bool, ui: &Ui) {
        match key {
            Key::ArrowLeft => self.drag(-KEY_DRAG, 0.0, shift),
            Key::ArrowRight => self.drag(KEY_DRAG, 0.0, shift),
            Key::ArrowUp => self.drag(0.0, KEY_DRAG, shift),
            Key::ArrowDown => self.drag(0.0, -KEY_DRAG, shift),
            Key::Plus | Key::Equals => self.approach(KEY_SHARE),
            Key::Minus => self.approach(1.0 / KEY_SHARE),
            Key::Num0 => {
                self.camera = self.read.clone();
                self.link.order(|orders| (orders.camera, orders.revision) = (None, orders.revision + 1));
            }
            Key::Space => self.link.order(|orders| orders.paused = !orders.paused),
            Key::F => self.focuses = !self.focuses,
            Key::C => {
                let text = format!("camera: {}", self.camera.text());
                tell(&text);
                ui.ctx().copy_text(text);
            }
            Key::S => self.link.order(|orders| orders.save = Some(self.view)),
            Key::R => self.link.order(|orders| orders.revision += 1),
            Key::Q => ui.ctx().send_viewport_cmd(ViewportCommand::Close),
            _ => {}
        }
    }

    /// Buttons in a row, with the key that each stands for.
    fn buttons(&mut self, ui: &mut Ui, buttons: [(&str, &str, Key); 2]) {
        ui.horizontal(|ui| {
            for (name, hint, key) in buttons {
                if ui.button(name).on_hover_text(hint).clicked() {
                    self.press(key, false, ui);
                }
            }
        });
    }

    /// Turns the camera, or shifts it, to the right and upwards, in heights of the image.
    fn drag(&mut self, right: f64, up: f64, shifts: bool) {
        match shifts {
            true => pan(&mut self.camera, right, up),
            false => orbit(&mut self.camera, TURN * right, -TURN * up),
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
            let length = focal_length(degrees);
            let mut f = (length / camera.aperture).min(PINHOLE);
            if number(ui, "f-number", &mut f, 1e-9..=PINHOLE) {
                camera.aperture = if f < PINHOLE { length / f } else { 0.0 };
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
        let copies = "C. The camera as text, to the clipboard and the terminal";
        self.buttons(ui, [("Reset", "0. The camera of the scene", Key::Num0), ("Copy", copies, Key::C)]);
    }

    fn picture_settings(&mut self, ui: &mut Ui, state: &ViewState) {
        ui.heading("Picture");
        number(ui, "Exposure, stops", &mut self.view.exposure, -100.0..=100.0);
        let curves = Tonemap::value_variants().iter().map(|curve| (*curve, curve.word()));
        choice(ui, "Curve", &mut self.view.tonemap, curves.collect());
        let mut layers = vec![
            (PictureLayer::Radiance, "radiance".to_owned()),
            (PictureLayer::Error, "error, 0.1 % to 100 %".to_owned()),
        ];
        layers.extend(AOVS.map(|aov| (PictureLayer::Of { aov, number: 0 }, aov.word())));
        let lights = state.shown.iter().flat_map(|shown| shown.lights.iter().cloned()).enumerate();
        layers.extend(lights.map(|(number, name)| (PictureLayer::Of { aov: Aov::Lights, number }, name)));
        let mut layer = self.link.orders().layer;
        if choice(ui, "Layer", &mut layer, layers) {
            self.link.order(|orders| orders.layer = layer);
        }
        let pause = if self.link.orders().paused { "Go on" } else { "Pause" };
        let saves = ("Save EXR and PNG", "S. With the samples so far", Key::S);
        self.buttons(ui, [(pause, "Space", Key::Space), saves]);
    }

    /// The values of the pixel under the mouse or of the last click, and the surface there.
    fn pixel(&self, ui: &mut Ui, state: &ViewState) {
        ui.heading("Pixel");
        let pixel = self.hovered.or(state.surface.as_ref().map(|surface| surface.pixel));
        if let (Some(pixel), Some(shown)) = (pixel, &state.shown) {
            ui.label(words_of_pixel(shown, pixel, state.size));
        }
        let surface = state.surface.as_ref().map(|surface| surface.words.as_str());
        ui.label(surface.unwrap_or("A click finds the object and its distance"));
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
            self.drag(-x, y, shift || !response.dragged_by(PointerButton::Primary));
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
        if let Some((texture, of, by)) = &self.texture
            && Arc::ptr_eq(of, shown)
            && *by == self.view
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
        self.texture.insert((ui.ctx().load_texture("image", image, options), Arc::clone(shown), self.view)).0.id()
    }
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
    let (variance, error) = (shown.picture.variance[index], percent(shown.error_at(index)));
    let words = match variance.contains(&UNKNOWN_VARIANCE) {
        true => "variance unknown".to_owned(),
        false => format!("variance {}\nrelative error {error}", variance.map(|value| format!("{value:.2e}")).join(" ")),
    };
    let values = shown.values.get(index).map_or_else(String::new, |values| format!("\nlayer {}", numbers(values)));
    format!("{x}, {y}\nradiance {}\n{words}{values}", numbers(rgb))
}
