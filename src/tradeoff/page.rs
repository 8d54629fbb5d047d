//! The findings as one HTML file without scripts, for light and dark themes, and wide and narrow screens. It loads
//! nothing from the network.

use std::fmt::Write as _;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;

use super::judge::Measured;
use super::model::Ranking;
use super::report::{CAPTION, Findings, HEADINGS, MOST_CURVES, class_name, error_text, exponent_text, time_text};
use super::sweep::LEVEL;
use crate::error::Result;
use crate::output::plot::{Curve, Plot, Width, svg};

// No width is fixed, so that no screen scrolls sideways: on narrow screens, each row of the table is a card.
const STYLE: &str = "
:root { color-scheme: light dark; --ink: #1b1b1f; --paper: #ffffff; --line: #d6d6dc; --soft: #5c5c64; --front: #e7f4ea; }
@media (prefers-color-scheme: dark) {
  :root { --ink: #e8e8ec; --paper: #17171b; --line: #3a3a42; --soft: #a6a6b0; --front: #1d3324; }
  figure svg { filter: invert(.91) hue-rotate(180deg); }
}
body { font: 16px/1.5 system-ui, sans-serif; color: var(--ink); background: var(--paper); margin: 1.5rem auto; padding: 0 1rem; max-width: 86rem; overflow-wrap: anywhere; }
h1 { font-size: 1.6rem; line-height: 1.25; margin: 0; } h2 { font-size: 1.2rem; margin-top: 2rem; }
ul { padding-left: 1.2rem; } li { margin: .2rem 0; } code, .figure { white-space: nowrap; }
p, li { max-width: 60rem; } .note { color: var(--soft); }
ul.advice { list-style: none; padding: 0; font-size: 1.05rem; } ul.advice li { margin: .5rem 0; }
details { border-top: 1px solid var(--line); padding: .6rem 0; } summary { font-weight: 600; cursor: pointer; } details[open] > summary { margin-bottom: .6rem; }
table { border-collapse: collapse; width: 100%; font-size: .82rem; font-variant-numeric: tabular-nums; }
th, td { text-align: right; padding: .3rem .35rem; border-bottom: 1px solid var(--line); vertical-align: baseline; }
th, td { white-space: nowrap; } td:nth-child(2) { white-space: normal; min-width: 9rem; }
th:nth-child(-n+3), td:nth-child(-n+3) { text-align: left; }
tr.front td { background: var(--front); }
@media (max-width: 82rem) {
  table { display: block; } thead { display: none; }
  tbody { display: grid; grid-template-columns: repeat(auto-fill, minmax(min(19rem, 100%), 1fr)); gap: .8rem; }
  tr { display: block; border: 1px solid var(--line); border-radius: 6px; padding: .4rem .6rem; }
  tr.front { background: var(--front); } tr.front td { background: none; }
  td, td:nth-child(-n+3) { display: flex; justify-content: space-between; gap: 1rem; text-align: right; white-space: normal; border: 0; padding: .1rem 0; }
  td::before { content: attr(data-heading); color: var(--soft); text-align: left; }
  td:first-child { font-weight: 600; font-size: .95rem; } td:first-child::before { content: none; }
}
figure { margin: 1rem 0; border: 1px solid var(--line); border-radius: 6px; }
figure svg { display: block; width: 100%; max-width: 60rem; height: auto; margin: auto; }
.narrow { display: none; }
@media (max-width: 40rem) { .wide { display: none; } .narrow { display: block; } }
.pictures { display: grid; grid-template-columns: repeat(auto-fill, minmax(min(17rem, 100%), 1fr)); gap: 1.2rem; margin-bottom: 2rem; }
.pictures img { width: 100%; image-rendering: pixelated; display: block; border-radius: 4px; }
.pictures .pair { display: grid; grid-template-columns: 1fr 1fr; gap: 2px; margin-bottom: .3rem; }
";

/// Text with HTML's special characters escaped.
fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

/// Escaped text, with the parts between backticks in `<code>`.
fn marked(text: &str) -> String {
    let parts: Vec<String> = text.split('`').map(escaped).collect();
    let mark = |(i, part): (usize, &String)| match i % 2 {
        0 => part.clone(),
        _ => format!("<code>{part}</code>"),
    };
    parts.iter().enumerate().map(mark).collect()
}

/// The page: the advice, the plot and the pictures. The rest is folded.
///
/// # Errors
/// If the plot cannot be drawn.
pub fn html(report: &Findings) -> Result<String> {
    let mut page = String::new();
    let scene = escaped(&report.scene);
    let basis = report.basis();
    let _ = write!(
        page,
        "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n<meta name=\"viewport\" content=\"width=device-width, \
         initial-scale=1\">\n<title>{scene}: speed and accuracy</title>\n<style>{STYLE}</style>\n</head>\n<body>\n\
         <h1>{scene}: speed and accuracy</h1>\n<p class=\"note\">{}</p>\n<ul class=\"advice\">\n",
        // The number of settings that were measured, and where: what the advice holds for.
        marked(basis.first().map_or("", String::as_str))
    );
    for words in report.advice() {
        // The answer leads; what could be had besides is less than that.
        let (answer, besides) = words.split_once("; ").unwrap_or((&words, ""));
        let _ = write!(page, "<li><strong>{}</strong>", marked(answer));
        if !besides.is_empty() {
            let _ = write!(page, "<br><span class=\"note\">{}</span>", marked(besides));
        }
        page += "</li>\n";
    }
    page += "</ul>\n";
    if let (Some(wide), Some(narrow)) = (plot(report, Width::Wide)?, plot(report, Width::Narrow)?) {
        let _ = write!(
            page,
            "<h2>Error against time</h2>\n<p class=\"note\">Lower is less error, further left is less time. A curve that becomes level has a bias, which more \
             samples do not remove.</p>\n<figure>\n<div class=\"wide\">\n{wide}</div>\n<div class=\"narrow\">\n{narrow}</div>\n</figure>\n"
        );
        for words in report.left_out() {
            let _ = writeln!(page, "<p class=\"note\">{}</p>", marked(&words));
        }
        page += &folded("How to read the plot", &format!("<p>{}</p>\n", marked(CAPTION)));
    }
    page += &folded("All settings", &table(report));
    page += &folded("The conditions of the measurement", &listed(&basis));
    page += &folded("What the settings give up", &listed(&given_up(report)));
    page += &pictures(report);
    page += "</body>\n</html>\n";
    Ok(page)
}

fn folded(heading: &str, contents: &str) -> String {
    format!("<details>\n<summary>{heading}</summary>\n{contents}</details>\n")
}

fn listed(lines: &[String]) -> String {
    let items: String = lines.iter().map(|words| format!("<li>{}</li>\n", marked(words))).collect();
    format!("<ul>\n{items}</ul>\n")
}

/// A sentence for each option that was swept.
fn given_up(report: &Findings) -> Vec<String> {
    let mut names: Vec<&str> = Vec::new();
    let mut lines = Vec::new();
    let all = report.measured.iter().map(|m| &m.setting).chain(report.unmeasured.iter().map(|left| &left.setting));
    for option in all.filter_map(|setting| setting.option) {
        if !names.contains(&option.name) {
            names.push(option.name);
            lines.push(format!(
                "`--{}` ({}): {} {}",
                option.name,
                class_name(option.class),
                option.about,
                option.trade_off
            ));
        }
    }
    lines
}

/// The pictures of all settings at equal time.
fn pictures(report: &Findings) -> String {
    if report.examples.is_empty() {
        return String::new();
    }
    let mut text = format!(
        "<h2>What each setting gives in the same time</h2>\n<p class=\"note\">{}x{} pixels, in about the time that the defaults take for {LEVEL} samples. \
         On the right is the perceived difference (FLIP), from black (none) to white.</p>\n<div class=\"pictures\">\n",
        report.size.0, report.size.1
    );
    for picture in &report.examples {
        let data = |bytes: &[u8]| format!("data:image/png;base64,{}", STANDARD.encode(bytes));
        let name = escaped(&picture.setting);
        let figures = [
            format!("{} samples", picture.samples),
            time_text(Some(picture.seconds)),
            format!("relative MSE {}, relMSE {}", error_text(picture.error), error_text(picture.relmse)),
            format!("FLIP {:.3}", picture.flip),
        ];
        let _ = writeln!(
            text,
            "<div><div class=\"pair\"><img alt=\"{name}\" src=\"{}\"><img alt=\"FLIP of {name}\" src=\"{}\"></div><strong>{name}</strong><br>{}</div>",
            data(&picture.picture),
            data(&picture.flip_map),
            figures.map(|figure| format!("<span class=\"figure\">{figure}</span>")).join(", ")
        );
    }
    text + "</div>\n"
}

/// The plot of error against seconds; none if no setting has an error.
///
/// # Errors
/// If the plot cannot be drawn.
pub fn plot(report: &Findings, width: Width) -> Result<Option<String>> {
    let curve = |measured: &Measured| {
        let points = (0..=12).map(|power| {
            let samples = f64::from(1u32 << power);
            (measured.model.seconds_of(samples), measured.model.error(samples))
        });
        let name = format!("{} (p {})", measured.setting.name(), exponent_text(measured));
        // A mark is the measured noise at a number of samples plus the bias of the curve.
        let marks = measured.noises.iter().map(|&(samples, noise)| {
            (measured.model.seconds_of(f64::from(samples)), measured.model.squared_bias + noise)
        });
        Curve { name, points: points.collect(), marks: marks.collect() }
    };
    let mut curves: Vec<Curve> = report.drawn().0.into_iter().take(MOST_CURVES).map(curve).collect();
    curves.retain(|curve: &Curve| curve.points.iter().any(|point| point.1 > 0.0));
    if curves.is_empty() {
        return Ok(None);
    }
    svg(&Plot { title: "", x: "seconds", y: "relative MSE; the dotted line falls as 1/N", curves, guide: true, width })
        .map(Some)
}

fn table(report: &Findings) -> String {
    let mut text =
        format!("<table>\n<thead><tr>{}</thead>\n<tbody>\n", HEADINGS.map(|heading| format!("<th>{heading}")).concat());
    for measured in report.sorted() {
        let class = if measured.ranking == Ranking::Front { " class=\"front\"" } else { "" };
        let cells = report.cells(measured);
        let cells = HEADINGS
            .iter()
            .zip(&cells)
            .map(|(heading, cell)| format!("<td data-heading=\"{heading}\">{}", escaped(cell)));
        let _ = writeln!(text, "<tr{class}>{}", cells.collect::<String>());
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
    text += "</tbody></table>\n<p class=\"note\">Sorted by the time to 1e-2. Green settings are on the front: no other setting reaches every target as soon. Noise and bias² are \
             relative MSE. Noise is extrapolated to one sample a pixel; it falls as N^-p. The figure after ± is half the 95 % interval, of the bias and of \
             the seconds. FLIP is the perceived difference; 0.05 shows little noise. Efficiency is 1 / (noise × seconds), relative to the defaults.</p>\n";
    text
}
