//! The window: the image, the settings beside it, and what the mouse and the keys do.

mod layers;
mod link;
mod navigation;
mod rendering;

use std::panic::{self, AssertUnwindSafe};
use std::sync::Arc;
use std::thread::{self, Builder, JoinHandle, sleep};
use std::time::{Duration, Instant};

use clap::ValueEnum;
use eframe::egui::{
    self, Button, CentralPanel, Color32, ColorImage, ComboBox, DragValue, Key, Panel, PointerButton, Pos2, Rect,
    Response, RichText, Role, ScrollArea, Sense, TextureHandle, TextureOptions, Ui, ViewportBuilder, ViewportCommand,
    WidgetInfo, pos2, vec2,
};
use eframe::{App, Error as WindowError, Frame, NativeOptions};

use super::args::WindowArgs;
use crate::aov::Aov;
use crate::commands::console::tell;
use crate::commands::scene::name_of;
use crate::commands::signals::{Signals, WAIT};
use crate::error::{Error, Result};
use crate::output::view_transform::{Tonemap, ViewTransform};
use crate::printable::percent;
use crate::scene::Camera;
use layers::{AOVS, Layer, Shown};
use link::Surface;
pub use link::{Findings, Link};
use navigation::{dolly, f_number, field_of_view, focus_at, orbit, pan, set_f_number, set_field_of_view, turn_around};
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
const LENS: &str = "f-number";
/// How long the thread that renders may take to end. A driver that compiles cannot be stopped.
const PATIENCE: Duration = Duration::from_secs(2);
/// The largest window at the start, and the width of the settings.
const LARGEST: (f32, f32) = (1600.0, 900.0);
const SETTINGS: f32 = 260.0;

/// The state of the window.
pub struct Window {
    link: Arc<Link>,
    /// Those that close it.
    signals: Option<Signals>,
    camera: Camera,
    /// The camera of the scene, and how often that had been read.
    scene: (Camera, u64),
    is_moved: bool,
    view: ViewTransform,
    layer: Layer,
    is_paused: bool,
    /// Whether the next click makes what it meets sharp, and the pixel of that click.
    focuses: bool,
    focus: Option<(u32, u32)>,
    /// The middle of the image, if what it shows becomes the target: other programs' files have none.
    target: Option<(u32, u32)>,
    /// The pixel under the mouse.
    hovered: Option<(u32, u32)>,
    texture: Option<(TextureHandle, Source)>,
}

/// What a texture is made of.
type Source = (usize, f64, Tonemap);

/// Opens the window, until it is closed or a signal comes.
///
/// # Errors
/// `Error::Usage` without a display, `Error::Device` without OpenGL or where the display has gone, `Error::Interrupted` after a signal. Else those of
/// `render`.
pub fn run(args: &WindowArgs) -> Result<()> {
    has_display()?;
    let signals = Signals::listen("nothing has been written");
    let link = Arc::<Link>::default();
    let rendering = Rendering::open(args, Arc::clone(&link))?;
    let mut window = Window::new(Arc::clone(&link), args.view.transform());
    window.signals = Some(signals.clone());
    let (width, height) = link.findings().size;
    if args.scene.path.extension().is_some_and(|ending| ending != "ron") {
        window.target = Some((width / 2, height / 2));
        link.order(|orders| orders.pixel = window.target);
    }
    let size = vec2((width as f32 + SETTINGS).clamp(640.0, LARGEST.0), (height as f32 + 60.0).clamp(480.0, LARGEST.1));
    let title = format!("{} - gpu-rt", name_of(&args.scene.path));
    let viewport = ViewportBuilder::default().with_title(title).with_app_id("gpu-rt").with_inner_size(size);
    let options = NativeOptions { viewport, ..NativeOptions::default() };
    let spawned = Builder::new().name("renderer".to_owned()).spawn(move || rendering.run());
    let renderer = spawned.map_err(|error| Error::Device(format!("the system gives no thread: {error}")))?;
    let (theirs, came) = (Arc::clone(&link), signals.clone());
    let camera = Arc::clone(&link);
    let create: eframe::AppCreator<'_> = Box::new(move |context| {
        let ctx = context.egui_ctx.clone();
        let _ = theirs.repaint.set(Box::new(move || ctx.request_repaint()));
        wake_for(came, theirs);
        Ok(Box::new(window))
    });
    let opened = caught(|| eframe::run_native("gpu-rt", options, create));
    if let Some(text) = camera.orders().camera {
        tell(&format!("camera: {text}"));
    }
    end(&link, renderer);
    match opened {
        _ if signals.have_come() => Err(signals.interrupted("the window is closed")),
        Ok(result) => result.map_err(|error| explained(&error)),
        Err(reason) => Err(Error::Device(format!("the display has failed: {reason}"))),
    }
}

/// The result of the window. Where its display goes, or another program destroys it, the libraries of windows panic: that is an error, whose reason is
/// returned.
fn caught<T>(window: impl FnOnce() -> T) -> std::result::Result<T, String> {
    let (this, before) = (thread::current().id(), Arc::new(panic::take_hook()));
    let others = Arc::clone(&before);
    panic::set_hook(Box::new(move |info| {
        if thread::current().id() != this {
            others(info);
        }
    }));
    let result = panic::catch_unwind(AssertUnwindSafe(window));
    panic::set_hook(Box::new(move |info| before(info)));
    result.map_err(|panic| {
        let text = panic.downcast_ref::<String>().cloned();
        text.or(panic.downcast_ref::<&str>().map(|text| (*text).to_owned())).unwrap_or_default()
    })
}

/// Wakes the window when a signal comes. Without a thread for that, a signal is noticed with the next picture.
fn wake_for(signals: Signals, link: Arc<Link>) {
    let wait = move || {
        while !signals.have_come() && !link.orders().ends {
            sleep(WAIT);
        }
        link.repaint.get().inspect(|repaint| repaint());
    };
    let _ = Builder::new().name("signals".to_owned()).spawn(wait);
}

/// Has the thread that renders end.
fn end(link: &Link, renderer: JoinHandle<()>) {
    link.order(|orders| orders.ends = true);
    let begin = Instant::now();
    while !renderer.is_finished() && begin.elapsed() < PATIENCE {
        thread::sleep(Duration::from_millis(5));
    }
    if !renderer.is_finished() {
        // Destructors of a driver that is at work may crash.
        signal_hook::low_level::exit(0);
    }
}

/// A display that is named may still not answer. Without a name it is known before a large scene is read.
fn has_display() -> Result<()> {
    let is_named = ["DISPLAY", "WAYLAND_DISPLAY", "WAYLAND_SOCKET"].iter().any(|name| std::env::var_os(name).is_some());
    match cfg!(all(unix, not(target_os = "macos"))) && !is_named {
        true => Err(no_display("neither DISPLAY nor WAYLAND_DISPLAY is set")),
        false => Ok(()),
    }
}

fn no_display(reason: &str) -> Error {
    Error::Usage(format!("there is no display for a window: {reason}. `gpu-rt render --preview` draws in the terminal"))
}

fn explained(error: &WindowError) -> Error {
    match error {
        WindowError::Winit(_) | WindowError::WinitEventLoop(_) => {
            let words = error.to_string();
            no_display(words.rsplit(": ").next().unwrap_or_default().trim_end_matches('.'))
        }
        _ => Error::Device(format!(
            "the window cannot be drawn by OpenGL: {error}. `gpu-rt render --preview` needs none"
        )),
    }
}

impl App for Window {
    fn ui(&mut self, ui: &mut Ui, _: &mut Frame) {
        self.draw(ui);
    }
}

impl Window {
    /// The window of a scene that has been read.
    pub fn new(link: Arc<Link>, view: ViewTransform) -> Window {
        let scene = link.findings().camera;
        Window {
            link,
            signals: None,
            camera: scene.0.clone(),
            scene,
            is_moved: false,
            view,
            layer: Layer::default(),
            is_paused: false,
            focuses: false,
            focus: None,
            target: None,
            hovered: None,
            texture: None,
        }
    }

    /// The camera of the view.
    pub fn camera(&self) -> &Camera {
        &self.camera
    }

    /// Draws the window, and takes what the user does.
    pub fn draw(&mut self, ui: &mut Ui) {
        if self.signals.as_ref().is_some_and(Signals::have_come) {
            ui.ctx().send_viewport_cmd(ViewportCommand::Close);
        }
        let findings = self.link.findings();
        self.take(&findings);
        if !ui.ctx().egui_wants_keyboard_input() {
            self.keys(ui);
        }
        Panel::right("settings").exact_size(SETTINGS).show(ui, |ui| {
            ScrollArea::vertical().show(ui, |ui| self.settings(ui, &findings));
        });
        Panel::bottom("state").show(ui, |ui| state(ui, &findings));
        CentralPanel::no_frame().show(ui, |ui| self.image(ui, &findings));
    }

    /// Takes what the thread has found.
    fn take(&mut self, findings: &Findings) {
        if findings.camera.1 != self.scene.1 {
            self.scene = findings.camera.clone();
            if !self.is_moved {
                self.camera = self.scene.0.clone();
            }
        }
        if let (Some(pixel), Some(surface)) = (self.target, &findings.surface)
            && surface.pixel == pixel
        {
            self.target = None;
            let cameras = [&mut self.camera, &mut self.scene.0];
            let is_usable = !self.is_moved && surface.names.is_some();
            cameras.into_iter().filter(|_| is_usable).for_each(|camera| turn_around(camera, surface.depth));
        }
        if let (Some(pixel), Some(surface)) = (self.focus, &findings.surface)
            && surface.pixel == pixel
        {
            self.focus = None;
            if surface.names.is_some() {
                focus_at(&mut self.camera, surface.depth);
                self.moved();
            }
        }
    }

    /// Orders an image from where the camera is now.
    fn moved(&mut self) {
        self.is_moved = true;
        let text = self.camera.text();
        self.link.order(|orders| {
            (orders.camera, orders.moved) = (Some(text), Some(Instant::now()));
            orders.revision += 1;
        });
    }

    fn reset(&mut self) {
        (self.camera, self.is_moved) = (self.scene.0.clone(), false);
        self.link.order(|orders| {
            orders.camera = None;
            orders.revision += 1;
        });
    }

    fn pause(&mut self) {
        self.is_paused = !self.is_paused;
        self.link.order(|orders| orders.paused = self.is_paused);
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
            let is_command = input.modifiers.command || input.modifiers.alt;
            let pressed = |key: &Key| !is_command && input.key_pressed(*key);
            (Key::ALL.iter().copied().filter(pressed).collect::<Vec<_>>(), input.modifiers.shift)
        });
        for key in pressed {
            let arrow = match key {
                Key::ArrowLeft => Some((-1.0, 0.0)),
                Key::ArrowRight => Some((1.0, 0.0)),
                Key::ArrowUp => Some((0.0, 1.0)),
                Key::ArrowDown => Some((0.0, -1.0)),
                _ => None,
            };
            match (arrow, key) {
                (Some((x, y)), _) if shift => pan(&mut self.camera, KEY_SHIFT * x, KEY_SHIFT * y),
                (Some((x, y)), _) => orbit(&mut self.camera, KEY_TURN * x, -KEY_TURN * y),
                (None, Key::Plus | Key::Equals) => dolly(&mut self.camera, KEY_SHARE),
                (None, Key::Minus) => dolly(&mut self.camera, 1.0 / KEY_SHARE),
                (None, Key::Num0) => self.reset(),
                (None, Key::Space) => self.pause(),
                (None, Key::F) => self.focuses = !self.focuses,
                (None, Key::C) => self.copy(ui),
                (None, Key::S) => self.order_save(),
                (None, Key::Q) => ui.ctx().send_viewport_cmd(ViewportCommand::Close),
                (None, Key::R) => self.link.order(|orders| orders.revision += 1),
                _ => {}
            }
            if arrow.is_some() || matches!(key, Key::Plus | Key::Equals | Key::Minus) {
                self.moved();
            }
        }
    }

    fn settings(&mut self, ui: &mut Ui, findings: &Findings) {
        ui.heading("Camera");
        let mut camera = self.camera.clone();
        let row = |ui: &mut Ui, name: &str, value: &mut f64, range: std::ops::RangeInclusive<f64>| {
            ui.horizontal(|ui| {
                let label = ui.label(name);
                let speed = (value.abs() * 0.01).clamp(1e-9, 1e9);
                // What the scene has stays, even beyond the range.
                let field = DragValue::new(value).range(range).clamp_existing_to_range(false).speed(speed);
                let is_lens = name == LENS;
                let words = move |n: f64| if is_lens && n >= PINHOLE { "pinhole".to_owned() } else { short(n) };
                let field = field.custom_formatter(move |n, _| words(n));
                ui.add(field).labelled_by(label.id).changed()
            })
            .inner
        };
        let mut has_changed = false;
        if let Some(mut degrees) = field_of_view(&camera) {
            if row(ui, "Field of view, degrees", &mut degrees, 0.01..=179.0) {
                set_field_of_view(&mut camera, degrees);
                has_changed = true;
            }
            let mut number = f_number(&camera).min(PINHOLE);
            if row(ui, LENS, &mut number, 1e-3..=PINHOLE) {
                set_f_number(&mut camera, if number < PINHOLE { number } else { f64::INFINITY });
                has_changed = true;
            }
        }
        let mut distance = camera.focus_distance.unwrap_or((camera.look_at - camera.look_from).length());
        if row(ui, "Focus distance", &mut distance, 1e-30..=1e30) {
            focus_at(&mut camera, distance);
            has_changed = true;
        }
        if has_changed {
            self.camera = camera;
            self.moved();
        }
        ui.toggle_value(&mut self.focuses, "Focus by a click")
            .on_hover_text("F. The next click on the image makes that sharp");
        ui.horizontal(|ui| {
            if ui.button("Reset").on_hover_text("0. The camera of the scene").clicked() {
                self.reset();
            }
            let copies = ui.button("Copy").on_hover_text("C. The camera as text, to the clipboard and to the terminal");
            if copies.clicked() {
                self.copy(ui);
            }
        });
        ui.separator();
        self.picture_settings(ui, findings);
        ui.separator();
        ui.horizontal(|ui| {
            let word = if self.is_paused { "Go on" } else { "Pause" };
            if ui.button(word).on_hover_text("Space").clicked() {
                self.pause();
            }
            let has_samples = findings.shown.as_ref().is_some_and(|shown| !shown.is_small);
            let saves = ui.add_enabled(has_samples, Button::new("Save EXR and PNG"));
            if saves.on_hover_text("S. Into the current folder, with the samples so far").clicked() {
                self.order_save();
            }
        });
        ui.separator();
        ui.heading("Pixel");
        let pixel = self.hovered.or(findings.surface.as_ref().map(|surface| surface.pixel));
        if let (Some(pixel), Some(shown)) = (pixel, &findings.shown) {
            ui.label(words_of_pixel(shown, pixel, findings.size));
        }
        match &findings.surface {
            None => ui.label(RichText::new("A click finds the object and its distance").weak()),
            Some(surface) => ui.label(words_of_surface(surface)),
        };
        ui.separator();
        ui.label(RichText::new("Drag to turn. Shift or the right button shifts, the wheel goes nearer").weak());
    }

    fn picture_settings(&mut self, ui: &mut Ui, findings: &Findings) {
        ui.heading("Picture");
        ui.horizontal(|ui| {
            let label = ui.label("Exposure, stops");
            ui.add(DragValue::new(&mut self.view.exposure).range(-100.0..=100.0).speed(0.02)).labelled_by(label.id);
        });
        let curve =
            |curve: Tonemap| curve.to_possible_value().map_or_else(String::new, |value| value.get_name().to_owned());
        ComboBox::from_label("Curve").selected_text(curve(self.view.tonemap)).show_ui(ui, |ui| {
            for one in Tonemap::value_variants() {
                ui.selectable_value(&mut self.view.tonemap, *one, curve(*one));
            }
        });
        let lights = findings.shown.as_ref().map(|shown| shown.lights.clone()).unwrap_or_default();
        let name = |layer: Layer| match layer {
            Layer::Radiance => "radiance".to_owned(),
            Layer::Error => "error, 0.1 % to 100 %".to_owned(),
            Layer::Of { aov: Aov::Lights, number } => lights.get(number).cloned().unwrap_or_default(),
            Layer::Of { aov, .. } => {
                aov.to_possible_value().map_or_else(String::new, |value| value.get_name().to_owned())
            }
        };
        let of_aovs = AOVS.map(|aov| Layer::Of { aov, number: 0 });
        let of_lights = (0..lights.len()).map(|number| Layer::Of { aov: Aov::Lights, number });
        let before = self.layer;
        ComboBox::from_label("Layer").height(400.0).selected_text(name(self.layer)).show_ui(ui, |ui| {
            for layer in [Layer::Radiance, Layer::Error].into_iter().chain(of_aovs).chain(of_lights) {
                ui.selectable_value(&mut self.layer, layer, name(layer));
            }
        });
        if self.layer != before {
            self.link.order(|orders| orders.layer = self.layer);
        }
    }

    /// The image, as large as there is room, and what the mouse does on it.
    fn image(&mut self, ui: &mut Ui, findings: &Findings) {
        let (width, height) = findings.size;
        let room = ui.available_size();
        let scale = (room.x / width as f32).min(room.y / height as f32).max(1e-6);
        let (all, response) = ui.allocate_exact_size(room.max(vec2(1.0, 1.0)), Sense::click_and_drag());
        response.widget_info(|| WidgetInfo::labeled(Role::Image, true, "Image"));
        let rect = Rect::from_center_size(all.center(), vec2(width as f32, height as f32) * scale);
        ui.painter().rect_filled(all, 0.0, Color32::from_gray(24));
        if let Some(shown) = &findings.shown {
            let texture = self.texture_of(ui, shown);
            let whole = Rect::from_min_max(Pos2::ZERO, pos2(1.0, 1.0));
            ui.painter().image(texture, rect, whole, Color32::WHITE);
        }
        self.mouse(ui, &response, rect, findings);
    }

    fn mouse(&mut self, ui: &Ui, response: &Response, rect: Rect, findings: &Findings) {
        let along = |delta: f32| f64::from(delta / rect.height());
        let (shift, wheel) = ui.input(|input| (input.modifiers.shift, input.smooth_scroll_delta.y));
        let drag = response.drag_delta();
        if response.dragged() && drag != egui::Vec2::ZERO {
            // In a mirrored image, left is right.
            let x = if self.camera.mirror { -along(drag.x) } else { along(drag.x) };
            match response.dragged_by(PointerButton::Primary) && !shift {
                true => orbit(&mut self.camera, -TURN * x, -TURN * along(drag.y)),
                false => pan(&mut self.camera, -x, along(drag.y)),
            }
            self.moved();
        }
        if response.hovered() && wheel != 0.0 {
            dolly(&mut self.camera, (-WHEEL * f64::from(wheel)).exp());
            self.moved();
        }
        let pixel = |at: Pos2| {
            let (width, height) = findings.size;
            let share = (at - rect.min) / rect.size();
            let along = |share: f32, all: u32| ((share * all as f32) as u32).min(all - 1);
            rect.contains(at).then(|| (along(share.x, width), along(share.y, height)))
        };
        if let Some(pixel) = response.interact_pointer_pos().filter(|_| response.clicked()).and_then(pixel) {
            self.focus = std::mem::take(&mut self.focuses).then_some(pixel);
            self.link.order(|orders| orders.pixel = Some(pixel));
        }
        self.hovered = response.hover_pos().and_then(pixel);
    }

    /// The texture of what is shown, as large as textures can be.
    fn texture_of(&mut self, ui: &Ui, shown: &Arc<Shown>) -> egui::TextureId {
        let key = (Arc::as_ptr(shown) as usize, self.view.exposure, self.view.tonemap);
        if let Some((texture, of)) = &self.texture
            && *of == key
        {
            return texture.id();
        }
        let most = ui.input(|input| input.max_texture_side);
        let [width, height] = [shown.size.0 as usize, shown.size.1 as usize];
        let step = width.max(height).div_ceil(most.max(1)).max(1);
        let colours = shown.colours(&self.view);
        let size = [width.div_ceil(step), height.div_ceil(step)];
        let pixels = (0..height).step_by(step).flat_map(|y| (0..width).step_by(step).map(move |x| y * width + x));
        let pixels = pixels.map(|index| colours[index]).map(|[r, g, b]| Color32::from_rgb(r, g, b)).collect();
        let image = ColorImage::new(size, pixels);
        // A small picture is smooth. In the image, pixels are seen.
        let options = match shown.is_small {
            true => TextureOptions::LINEAR,
            false => TextureOptions { magnification: egui::TextureFilter::Nearest, ..TextureOptions::LINEAR },
        };
        let texture = ui.ctx().load_texture("image", image, options);
        let id = texture.id();
        self.texture = Some((texture, key));
        id
    }
}

/// The line below the image: the samples, their error, and what takes time.
fn state(ui: &mut Ui, findings: &Findings) {
    for error in &findings.errors {
        ui.colored_label(Color32::LIGHT_RED, error);
    }
    ui.horizontal_wrapped(|ui| {
        match &findings.shown {
            Some(shown) if !shown.is_small => {
                ui.label(format!("{} of {} samples", shown.samples, findings.samples));
                if shown.pace > 0.0 {
                    ui.label(format!("{:.3} samples/s", shown.pace));
                }
                ui.label(&shown.error);
                if !shown.reasons.is_empty() {
                    let reasons = shown.reasons.join("\n");
                    ui.colored_label(Color32::YELLOW, "unreliable").on_hover_text(reasons);
                }
            }
            _ => drop(ui.label("a small picture of the view")),
        }
        ui.label(&findings.activity);
        ui.label(&findings.message);
    });
}

/// A number with six digits.
fn short(number: f64) -> String {
    let digits = (5.0 - number.abs().max(1e-300).log10().floor()).clamp(0.0, 12.0);
    let text = format!("{number:.*}", digits as usize);
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}

fn words_of_surface(surface: &Surface) -> String {
    let Surface { pixel: (x, y), names, distance, .. } = surface;
    match names {
        None => format!("{x}, {y}: no surface"),
        Some((object, material)) => format!("{x}, {y}: {object}\nmaterial {material}\ndistance {distance:.6}"),
    }
}

/// The value of a pixel of the image, its variance, and its error.
fn words_of_pixel(shown: &Shown, pixel: (u32, u32), size: (u32, u32)) -> String {
    let index = shown.index(pixel, size);
    let numbers = |values: [f32; 3]| values.map(|value| format!("{value:.5}")).join(" ");
    let small = |values: [f32; 3]| values.map(|value| format!("{value:.2e}")).join(" ");
    let Some(rgb) = shown.picture.rgb.get(index) else { return String::new() };
    let variance = shown.picture.variance[index];
    let error = Some(shown.error_at(index)).filter(|error| error.is_finite());
    let words = match error {
        Some(error) => format!("variance {}\nrelative error {}", small(variance), percent(error)),
        None => "variance unknown".to_owned(),
    };
    let values = shown.values.get(index).map_or_else(String::new, |values| format!("\nlayer {}", numbers(*values)));
    format!("{}, {}\nradiance {}\n{words}{values}", pixel.0, pixel.1, numbers(*rgb))
}
