//! The findings as one HTML file without scripts, for light and dark themes, and wide and narrow screens. It loads
//! nothing from the network.

use std::fmt::Write as _;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;

use super::judge::Measured;
use super::model::Standing;
use super::report::{CAPTION, Findings, HEADINGS, MOST_CURVES, class_name, exponent_text, relmse_text, time_text};
use super::sweep::LEVEL;
use crate::error::Result;
use crate::output::plot::{Curve, Plot, svg};

const STYLE: &str = "
:root { color-scheme: light dark; --ink: #1b1b1f; --paper: #ffffff; --line: #d6d6dc; --soft: #5c5c64; --front: #e7f4ea; }
@media (prefers-color-scheme: dark) {
  :root { --ink: #e8e8ec; --paper: #17171b; --line: #3a3a42; --soft: #a6a6b0; --front: #1d3324; }
  figure svg { filter: invert(.91) hue-rotate(180deg); }
}
body { font: 16px/1.5 system-ui, sans-serif; color: var(--ink); background: var(--paper); margin: 2rem auto; padding: 0 1rem; max-width: 80rem; }
h1 { font-size: 1.6rem; } h2 { font-size: 1.2rem; margin-top: 2.5rem; }
ul { padding-left: 1.2rem; } li { margin: .2rem 0; } code { white-space: nowrap; }
p, li { max-width: 60rem; } p.note, li.note { color: var(--soft); }
.wide { overflow-x: auto; }
table { border-collapse: collapse; font-size: .85rem; font-variant-numeric: tabular-nums; white-space: nowrap; }
th, td { text-align: right; padding: .3rem .4rem; border-bottom: 1px solid var(--line); vertical-align: baseline; }
th:nth-child(-n+3), td:nth-child(-n+3) { text-align: left; }
th:first-child, td:first-child { position: sticky; left: 0; background: var(--paper); }
td:nth-child(2) { white-space: normal; min-width: 11rem; }
tr.front td { background: var(--front); }
figure { margin: 1rem 0; border: 1px solid var(--line); border-radius: 6px; overflow-x: auto; }
figure svg { display: block; width: 100%; max-width: 60rem; min-width: 38rem; height: auto; margin: auto; }
.pictures { display: grid; grid-template-columns: repeat(auto-fill, minmax(min(17rem, 100%), 1fr)); gap: 1.2rem; }
.pictures img { width: 100%; image-rendering: pixelated; display: block; border-radius: 4px; }
.pictures .pair { display: grid; grid-template-columns: 1fr 1fr; gap: 2px; margin-bottom: .3rem; }
";

/// Text with HTML's special characters escaped.
fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

/// The same, with the text between backticks in `<code>`.
fn marked(text: &str) -> String {
    let parts: Vec<String> = text.split('`').map(escaped).collect();
    let mark = |(i, part): (usize, &String)| match i % 2 {
        0 => part.clone(),
        _ => format!("<code>{part}</code>"),
    };
    parts.iter().enumerate().map(mark).collect()
}

/// The whole page, with the plot if there is one.
pub fn html(report: &Findings, plot: Option<&str>) -> String {
    let mut page = String::new();
    let scene = escaped(&report.scene);
    let _ = write!(
        page,
        "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n<meta name=\"viewport\" content=\"width=device-width, \
         initial-scale=1\">\n<title>{scene}: speed and accuracy</title>\n<style>{STYLE}</style>\n</head>\n<body>\n\
         <h1>{scene}: speed and accuracy</h1>\n<ul>\n"
    );
    for words in report.advice() {
        let _ = writeln!(page, "<li><strong>{}</strong></li>", marked(&words));
    }
    for words in report.basis() {
        let _ = writeln!(page, "<li class=\"note\">{}</li>", marked(&words));
    }
    page += "</ul>\n";
    if let Some(plot) = plot {
        let _ = write!(page, "<h2>Error against time</h2>\n<figure>\n{plot}</figure>\n");
        let _ = writeln!(
            page,
            "<p class=\"note\">{}</p>",
            marked(&[&[CAPTION.to_string()], &report.left_out()[..]].concat().join(" "))
        );
    }
    page += &table(report);
    if !report.shown.is_empty() {
        let _ = write!(
            page,
            "<h2>The same time for each</h2>\n<p class=\"note\">{}x{} pixels. Each setting has the number of samples that comes nearest to the time of {LEVEL} samples of the defaults; its own time is below. \
             The picture on the right is its FLIP map: the perceived difference, from black (none) to white.</p>\n<div class=\"pictures\">\n",
            report.size.0, report.size.1
        );
        for picture in &report.shown {
            let data = |bytes: &[u8]| format!("data:image/png;base64,{}", STANDARD.encode(bytes));
            let name = escaped(&picture.setting);
            let _ = writeln!(
                page,
                "<div><div class=\"pair\"><img alt=\"{name}\" src=\"{}\"><img alt=\"FLIP of {name}\" src=\"{}\"></div><strong>{name}</strong><br>\
                 {} samples, {}, relMSE {}, FLIP {:.3}</div>",
                data(&picture.picture),
                data(&picture.flip_map),
                picture.samples,
                time_text(Some(picture.seconds)),
                relmse_text(picture.relmse),
                picture.flip
            );
        }
        page += "</div>\n";
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
                marked(knob.about),
                marked(knob.gives_up)
            );
        }
    }
    page += "</ul>\n</body>\n</html>\n";
    page
}

/// The plot of error against seconds; none if no setting has an error.
///
/// # Errors
/// If the plot cannot be drawn.
pub fn plot(report: &Findings) -> Result<Option<String>> {
    let curve = |measured: &Measured| {
        let points = (0..=12).map(|power| {
            let samples = f64::from(1u32 << power);
            (samples * measured.model.seconds, measured.model.error(samples))
        });
        let name = format!("{} (p {})", measured.setting.name(), exponent_text(measured));
        // A mark is the measured noise at a number of samples plus the bias of the curve.
        let marks = measured.noises.iter().map(|&(samples, noise)| {
            (f64::from(samples) * measured.model.seconds, measured.model.squared_bias + noise)
        });
        Curve { name, points: points.collect(), marks: marks.collect() }
    };
    let mut curves: Vec<Curve> = report.drawn().0.into_iter().take(MOST_CURVES).map(curve).collect();
    curves.retain(|curve: &Curve| curve.points.iter().any(|point| point.1 > 0.0));
    if curves.is_empty() {
        return Ok(None);
    }
    svg(&Plot { title: "", x: "seconds", y: "relMSE; the dashed line falls as 1/N", curves, guide: true }).map(Some)
}

fn table(report: &Findings) -> String {
    let mut text = format!(
        "<h2>All settings</h2>\n<div class=\"wide\"><table>\n<tr>{}\n",
        HEADINGS.map(|heading| format!("<th>{heading}")).concat()
    );
    for measured in report.sorted() {
        let class = if measured.standing == Standing::Front { " class=\"front\"" } else { "" };
        let cells = report.cells(measured).map(|cell| format!("<td>{}", escaped(&cell))).concat();
        let _ = writeln!(text, "<tr{class}>{cells}");
    }
    for left in &report.unmeasured {
        let _ = writeln!(
            text,
            "<tr><td>{}<td colspan=\"{}\">not measured: {}",
            escaped(&left.setting.name()),
            HEADINGS.len() - 1,
            escaped(&left.why)
        );
    }
    text += "</table></div>\n<p class=\"note\">Sorted by the time to 1e-2. Green settings are on the front: no other setting reaches every target as soon. Noise and bias² are \
             relMSE. Noise is extrapolated to one sample a pixel; it falls as N^-p. The figure after ± is half the 95 % interval of the bias, and half the \
             interquartile range of the seconds over the rounds. Efficiency is 1 / (noise × seconds), relative to the defaults.</p>\n";
    text
}
