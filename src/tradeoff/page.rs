//! The report as one HTML file: no network, no scripts, for light and dark screens, wide and narrow.

use std::fmt::Write as _;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;

use super::judge::{Measured, TARGETS};
use super::model::Standing;
use super::report::{Report, bias_text, class_name, efficiency_text, target_name, time_text};
use crate::error::Result;
use crate::output::plot::{Curve, Plot, svg};

const STYLE: &str = "
:root { color-scheme: light dark; --ink: #1b1b1f; --paper: #ffffff; --line: #d6d6dc; --soft: #66666e; --front: #e7f4ea; }
@media (prefers-color-scheme: dark) { :root { --ink: #e8e8ec; --paper: #17171b; --line: #3a3a42; --soft: #9a9aa4; --front: #1d3324; } }
body { font: 16px/1.5 system-ui, sans-serif; color: var(--ink); background: var(--paper); margin: 2rem auto; padding: 0 1rem; max-width: 76rem; }
h1 { font-size: 1.6rem; } h2 { font-size: 1.2rem; margin-top: 2.5rem; }
p.note, li.note { color: var(--soft); }
.wide { overflow-x: auto; }
table { border-collapse: collapse; font-variant-numeric: tabular-nums; white-space: nowrap; }
th, td { text-align: right; padding: .3rem .7rem; border-bottom: 1px solid var(--line); }
th:nth-child(-n+3), td:nth-child(-n+3) { text-align: left; }
tr.front td { background: var(--front); }
figure { margin: 1rem 0; background: #fff; border: 1px solid var(--line); border-radius: 6px; }
figure svg { display: block; width: 100%; height: auto; }
.pictures { display: grid; grid-template-columns: repeat(auto-fill, minmax(17rem, 1fr)); gap: 1.2rem; }
.pictures img { width: 100%; image-rendering: pixelated; display: block; border-radius: 4px; }
.pictures .pair { display: grid; grid-template-columns: 1fr 1fr; gap: 2px; }
";

/// Text where HTML expects text.
fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

/// The whole page, with the plot where there is one.
pub fn html(report: &Report, plot: Option<&str>) -> String {
    let mut page = String::new();
    let scene = escaped(&report.scene);
    let _ = write!(
        page,
        "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n<meta name=\"viewport\" content=\"width=device-width, \
         initial-scale=1\">\n<title>{scene}: speed and accuracy</title>\n<style>{STYLE}</style>\n</head>\n<body>\n\
         <h1>{scene}: speed and accuracy</h1>\n<ul>\n"
    );
    for words in report.advice() {
        let _ = writeln!(page, "<li><strong>{}</strong></li>", escaped(&words));
    }
    for words in report.basis() {
        let _ = writeln!(page, "<li class=\"note\">{}</li>", escaped(&words));
    }
    page += "</ul>\n";
    if let Some(plot) = plot {
        let _ = write!(page, "<h2>Error against time</h2>\n<figure>\n{plot}</figure>\n");
        page += "<p class=\"note\">bias² + c N^-p, by the measured bias and the noise measured at 4, 16 and 64 samples. A line that ends level is a bias that no \
             time removes. Of what is dominated only the biased settings are drawn.</p>\n";
    }
    page += &table(report);
    if !report.shown.is_empty() {
        page += "<h2>The same time for each</h2>\n<div class=\"pictures\">\n";
        for picture in &report.shown {
            let data = |bytes: &[u8]| format!("data:image/png;base64,{}", STANDARD.encode(bytes));
            let name = escaped(&picture.setting);
            let _ = writeln!(
                page,
                "<div><div class=\"pair\"><img alt=\"{name}\" src=\"{}\"><img alt=\"FLIP of {name}\" src=\"{}\"></div><strong>{name}</strong><br>\
                 {} samples, {}, relMSE {:.1e}, FLIP {:.3}</div>",
                data(&picture.picture),
                data(&picture.flip_map),
                picture.samples,
                time_text(Some(picture.seconds)),
                picture.relmse,
                picture.flip
            );
        }
        page += "</div>\n<p class=\"note\">Right of each picture its FLIP map: what an eye sees of the difference, from black (nothing) to white.</p>\n";
    }
    page += "<h2>What the settings give up</h2>\n<ul>\n";
    let mut told: Vec<&str> = Vec::new();
    let all = report.measured.iter().map(|m| &m.setting).chain(report.unmeasured.iter().map(|left| &left.setting));
    for knob in all.filter_map(|setting| setting.knob) {
        if !told.contains(&knob.name) {
            told.push(knob.name);
            let _ = writeln!(
                page,
                "<li><code>--{}</code> ({}): {} {}</li>",
                knob.name,
                class_name(knob.class),
                escaped(knob.about),
                escaped(knob.gives_up)
            );
        }
    }
    page += "</ul>\n</body>\n</html>\n";
    page
}

/// Error against seconds of what is on the front, and of what is biased; nothing where nothing has an error.
///
/// # Errors
/// Where the plot cannot be drawn.
pub fn plot(report: &Report) -> Result<Option<String>> {
    let mut curves: Vec<Curve> = Vec::new();
    let mut sorted = report.sorted();
    // The defaults in front; the others keep their order.
    sorted.sort_by_key(|measured| measured.setting.knob.is_some());
    for measured in sorted {
        if measured.standing == Standing::Dominated && measured.setting.knob.is_some() && !measured.biased {
            continue;
        }
        let points = (0..=12).map(|power| {
            let samples = f64::from(1u32 << power);
            (samples * measured.model.seconds, measured.model.error(samples))
        });
        let slope = measured.model.noise.exponent;
        let name = format!("{} (p {slope:.2})", measured.setting.name());
        curves.push(Curve { name, points: points.collect() });
    }
    curves.retain(|curve: &Curve| curve.points.iter().any(|point| point.1 > 0.0));
    if curves.is_empty() {
        return Ok(None);
    }
    svg(&Plot { title: "", x: "seconds", y: "relMSE", curves }).map(Some)
}

fn table(report: &Report) -> String {
    let mut text = String::from(
        "<h2>All settings</h2>\n<div class=\"wide\"><table>\n<tr><th>setting<th>verdict<th>gives up<th>ms a sample<th>variance, 1 sample<th>p\
         <th>bias of the mean<th>bias², relMSE",
    );
    for target in TARGETS {
        let _ = write!(text, "<th>to {}", target_name(target));
    }
    text += "<th>efficiency\n";
    let base = report.measured.first().map_or(1.0, Measured::efficiency);
    for measured in report.sorted() {
        let class = if measured.standing == Standing::Front { " class=\"front\"" } else { "" };
        let _ = write!(
            text,
            "<tr{class}><td>{}<td>{}<td>{}<td>{:.2} ± {:.2}<td>{:.3}<td>{:.2}<td>{}<td>{:.1e}",
            escaped(&measured.setting.name()),
            escaped(&measured.verdict()),
            class_name(measured.setting.class()),
            1e3 * measured.seconds,
            1e3 * measured.seconds_spread,
            measured.model.noise.noise,
            measured.model.noise.exponent,
            bias_text(measured),
            measured.squared.value.max(0.0),
        );
        for time in measured.times {
            let _ = write!(text, "<td>{}", time_text(time));
        }
        let _ = writeln!(text, "<td>{}", efficiency_text(measured, base));
    }
    for left in &report.unmeasured {
        let _ = writeln!(
            text,
            "<tr><td>{}<td>not measured: {}<td>{}{}",
            escaped(&left.setting.name()),
            escaped(&left.why),
            class_name(left.setting.class()),
            "<td>".repeat(6 + TARGETS.len())
        );
    }
    text += "</table></div>\n<p class=\"note\">Sorted by the time to 1e-2. Green: on the front, no other setting reaches every target as soon. \
             Efficiency is 1 / (variance × seconds), over that of the defaults. p: the noise falls as N^-p.</p>\n";
    text
}
