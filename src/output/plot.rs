//! Plots as SVG: curves over logarithmic axes.

use plotters::prelude::*;

use crate::error::{Error, Result};

/// A curve and its points.
#[derive(Clone, Debug)]
pub struct Curve {
    pub name: String,
    /// x and y, both above 0. Other points are left out.
    pub points: Vec<(f64, f64)>,
    /// Measured points, drawn as dots.
    pub marks: Vec<(f64, f64)>,
}

/// The contents of a plot.
#[derive(Clone, Debug)]
pub struct Plot<'a> {
    pub title: &'a str,
    pub x: &'a str,
    pub y: &'a str,
    /// In the legend's order; the first is drawn thicker.
    pub curves: Vec<Curve>,
    /// Whether a dashed line falls as 1/x from the first curve's first point, as the error of independent samples does.
    pub guide: bool,
}

const WIDTH: u32 = 900;
const HEIGHT: u32 = 540;
/// The columns of the legend, which is below the curves.
const LEGEND_COLUMNS: usize = 3;
const LEGEND_ROW: u32 = 24;

/// Colours that are distinct on white, also for most people with colour blindness: those of M. Okabe and K. Ito ("Color
/// Universal Design", 2008) without yellow, and darker versions of them.
const COLOURS: [RGBColor; 10] = [
    RGBColor(0, 0, 0),
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(230, 159, 0),
    RGBColor(86, 180, 233),
    RGBColor(110, 60, 0),
    RGBColor(90, 40, 110),
    RGBColor(120, 120, 120),
];

/// The plot as an SVG document, both axes logarithmic.
///
/// # Errors
/// `Error::Usage` if no curve has a point.
pub fn svg(plot: &Plot<'_>) -> Result<String> {
    let mut text = String::new();
    let rows = plot.curves.len().div_ceil(LEGEND_COLUMNS) as u32;
    let size = (WIDTH, HEIGHT + rows * LEGEND_ROW + LEGEND_ROW / 2);
    let drawn = draw(plot, &SVGBackend::with_string(&mut text, size).into_drawing_area());
    drawn.map_err(|error| Error::Usage(format!("the plot cannot be drawn: {error}")))?;
    Ok(text)
}

type Drawn = std::result::Result<(), Box<dyn std::error::Error>>;

fn draw(plot: &Plot<'_>, area: &DrawingArea<SVGBackend<'_>, plotters::coord::Shift>) -> Drawn {
    let shown = |points: &[(f64, f64)]| {
        let good = |(x, y): &&(f64, f64)| *x > 0.0 && *y > 0.0 && x.is_finite() && y.is_finite();
        points.iter().filter(good).copied().collect::<Vec<_>>()
    };
    let both = |curve: &Curve| [shown(&curve.points), shown(&curve.marks)].concat();
    let all: Vec<(f64, f64)> = plot.curves.iter().flat_map(both).collect();
    if all.is_empty() {
        return Err("it has no points".into());
    }
    // The axes are a little wider than the points, so that none lies on the frame.
    let range = |of: fn(&(f64, f64)) -> f64| {
        let ends = all.iter().map(of).fold((f64::MAX, f64::MIN_POSITIVE), |(a, b), v| (a.min(v), b.max(v)));
        ends.0 / 1.5..ends.1 * 1.5
    };
    area.fill(&WHITE)?;
    let (above, below) = area.split_vertically(HEIGHT);
    let mut builder = ChartBuilder::on(&above);
    if !plot.title.is_empty() {
        builder.caption(plot.title, ("sans-serif", 22));
    }
    let mut chart = builder
        .margin(16)
        .x_label_area_size(48)
        .y_label_area_size(72)
        .build_cartesian_2d(range(|p| p.0).log_scale(), range(|p| p.1).log_scale())?;
    chart
        .configure_mesh()
        .x_desc(plot.x)
        .y_desc(plot.y)
        .x_label_formatter(&short)
        .y_label_formatter(&short)
        .label_style(("sans-serif", 15))
        .light_line_style(BLACK.mix(0.06))
        .draw()?;
    for (i, curve) in plot.curves.iter().enumerate() {
        let colour = COLOURS[i % COLOURS.len()];
        let points = shown(&curve.points);
        let line = colour.stroke_width(if i == 0 { 3 } else { 2 });
        chart.draw_series(LineSeries::new(points.iter().copied(), line))?;
        chart.draw_series(shown(&curve.marks).into_iter().map(|mark| Circle::new(mark, 4, colour.filled())))?;
        let column = WIDTH as usize / LEGEND_COLUMNS * (i % LEGEND_COLUMNS);
        let (x, y) = (column as i32 + 24, (i / LEGEND_COLUMNS) as i32 * LEGEND_ROW as i32 + LEGEND_ROW as i32 / 2);
        below.draw(&PathElement::new([(x, y), (x + 24, y)], line))?;
        below.draw(&Text::new(curve.name.as_str(), (x + 32, y - 8), ("sans-serif", 15)))?;
    }
    if let Some((x, y)) =
        plot.curves.first().and_then(|curve| shown(&curve.points).first().copied()).filter(|_| plot.guide)
    {
        let (left, right) = (range(|p| p.0).start, range(|p| p.0).end);
        let below_frame = x * y / range(|p| p.1).start;
        let ends = [left.max(x * y / range(|p| p.1).end), right.min(below_frame)].map(|at| (at, x * y / at));
        chart.draw_series(DashedLineSeries::new(ends, 6, 6, BLACK.mix(0.4).stroke_width(1)))?;
    }
    area.present()?;
    Ok(())
}

/// A number as 1e-3 if it is far from 1, else with plain digits. Of 0.30000000000000004 only the digits that count are left.
fn short(value: &f64) -> String {
    let value: f64 = format!("{value:.3e}").parse().unwrap_or(*value);
    match (1e-2..1e4).contains(&value) {
        true => format!("{value}"),
        false => format!("{value:e}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_plot_holds_its_words_and_every_point_that_can_be_shown() {
        let curve =
            |points: &[(f64, f64)]| Curve { name: "relMSE".into(), points: points.to_vec(), marks: points.to_vec() };
        let plot = |curves| Plot { title: "cornell & smoke", x: "seconds", y: "error", curves, guide: false };
        let text = svg(&plot(vec![curve(&[(0.1, 1.0), (1.0, 0.1), (10.0, 0.0), (f64::NAN, 1.0)])])).unwrap();
        for word in ["<svg", "cornell &amp; smoke", "seconds", "error", "relMSE"] {
            assert!(text.contains(word), "{word} in {text}");
        }
        assert_eq!(text.matches("<circle").count(), 2);
        // A line that falls as 1/x is many dashes.
        let dashes = |guide| {
            let falling = [(1.0, 1.0), (2.0, 0.4), (4.0, 0.3)];
            svg(&Plot { guide, ..plot(vec![curve(&falling)]) }).unwrap().matches("<polyline").count()
        };
        assert!(dashes(true) > dashes(false) + 5, "{} {}", dashes(true), dashes(false));
        assert_eq!([0.1 + 0.2, 3e-5, 250.0, 30_000.0].map(|value| short(&value)), ["0.3", "3e-5", "250", "3e4"]);
        // One point is a plot too; none is an error.
        assert!(svg(&plot(vec![curve(&[(1.0, 1.0)])])).is_ok());
        assert!(svg(&plot(vec![curve(&[(1.0, 0.0)])])).unwrap_err().to_string().contains("no points"));
    }
}
