//! Plots as SVG: curves over logarithmic axes.

use plotters::prelude::*;

use crate::error::{Error, Result};

/// A curve and its points.
#[derive(Clone, Debug)]
pub struct Curve {
    pub name: String,
    /// x and y, both above 0. Other points are left out.
    pub points: Vec<(f64, f64)>,
    /// Measured points, drawn as dots. Outside of their range the curve is extrapolated, and dashed. Without them it is solid.
    pub marks: Vec<(f64, f64)>,
}

/// The width of a plot, which its letters and its legend follow.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Width {
    /// For documents, and for the screens of computers.
    Wide,
    /// For the screens of telephones: letters of the same size on half the width.
    Narrow,
}

/// The contents of a plot.
#[derive(Clone, Debug)]
pub struct Plot<'a> {
    pub title: &'a str,
    pub x: &'a str,
    pub y: &'a str,
    /// In the legend's order; the first is drawn thicker.
    pub curves: Vec<Curve>,
    /// Whether a dotted line falls as 1/x from the first curve's first point, as the error of independent samples does.
    pub guide: bool,
    pub width: Width,
}

impl Width {
    /// The width, the height without the legend, which is below the curves, and the columns of the legend.
    fn layout(self) -> (u32, u32, usize) {
        match self {
            Width::Wide => (900, 540, 3),
            Width::Narrow => (450, 400, 1),
        }
    }
}

const LEGEND_ROW: u32 = 24;
/// The lengths of a dash and of the gap after it, in pixels.
const DASHES: (u32, u32) = (6, 5);
const DOTS: (u32, u32) = (1, 5);

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
    let (width, height, columns) = plot.width.layout();
    let rows = plot.curves.len().div_ceil(columns) as u32;
    let size = (width, height + rows * LEGEND_ROW + LEGEND_ROW / 2);
    let drawn = draw(plot, &SVGBackend::with_string(&mut text, size).into_drawing_area());
    drawn.map_err(|error| Error::Usage(format!("the plot cannot be drawn: {error}")))?;
    Ok(text)
}

/// The parts of a curve, each with whether it lies within the range of the measured points. Neighbours share a point.
fn parts(points: &[(f64, f64)], marks: &[(f64, f64)]) -> Vec<(bool, Vec<(f64, f64)>)> {
    let (first, last) = marks.iter().fold((f64::MAX, f64::MIN), |(a, b), mark| (a.min(mark.0), b.max(mark.0)));
    let mut parts: Vec<(bool, Vec<(f64, f64)>)> = Vec::new();
    for pair in points.windows(2) {
        let measured = marks.is_empty() || (first <= pair[0].0 && pair[1].0 <= last);
        match parts.last_mut() {
            Some((same, part)) if *same == measured => part.push(pair[1]),
            _ => parts.push((measured, pair.to_vec())),
        }
    }
    parts
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
    let (width, height, columns) = plot.width.layout();
    let (above, below) = area.split_vertically(height);
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
        let line = colour.stroke_width(if i == 0 { 3 } else { 2 });
        for (measured, part) in parts(&shown(&curve.points), &curve.marks) {
            if measured {
                chart.draw_series(LineSeries::new(part, line))?;
            } else {
                chart.draw_series(DashedLineSeries::new(part, DASHES.0, DASHES.1, line))?;
            }
        }
        chart.draw_series(shown(&curve.marks).into_iter().map(|mark| Circle::new(mark, 4, colour.filled())))?;
        let column = width as usize / columns * (i % columns);
        let (x, y) = (column as i32 + 24, (i / columns) as i32 * LEGEND_ROW as i32 + LEGEND_ROW as i32 / 2);
        below.draw(&PathElement::new([(x, y), (x + 24, y)], line))?;
        below.draw(&Text::new(curve.name.as_str(), (x + 32, y - 8), ("sans-serif", 15)))?;
    }
    if let Some((x, y)) =
        plot.curves.first().and_then(|curve| shown(&curve.points).first().copied()).filter(|_| plot.guide)
    {
        let (left, right) = (range(|p| p.0).start, range(|p| p.0).end);
        let below_frame = x * y / range(|p| p.1).start;
        let ends = [left.max(x * y / range(|p| p.1).end), right.min(below_frame)].map(|at| (at, x * y / at));
        chart.draw_series(DashedLineSeries::new(ends, DOTS.0, DOTS.1, BLACK.mix(0.6).stroke_width(2)))?;
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
    fn a_curve_is_dashed_where_nothing_was_measured() {
        let points = [1.0, 2.0, 4.0, 8.0, 16.0, 32.0].map(|x| (x, 1.0 / x));
        let of = |marks: &[(f64, f64)]| {
            parts(&points, marks)
                .iter()
                .map(|(measured, part)| (*measured, part[0].0, part[part.len() - 1].0))
                .collect::<Vec<_>>()
        };
        assert_eq!(of(&[]), [(true, 1.0, 32.0)]);
        assert_eq!(of(&points), [(true, 1.0, 32.0)]);
        assert_eq!(of(&[(2.0, 0.6), (8.0, 0.1)]), [(false, 1.0, 2.0), (true, 2.0, 8.0), (false, 8.0, 32.0)]);
        assert_eq!(of(&[(1.0, 1.0), (5.0, 0.1)]), [(true, 1.0, 4.0), (false, 4.0, 32.0)]);
        // A solid part is one line, a dashed one is many.
        let lines = |marks: &[(f64, f64)], width| {
            let curve = Curve { name: "relMSE".into(), points: points.to_vec(), marks: marks.to_vec() };
            svg(&Plot { title: "", x: "seconds", y: "error", curves: vec![curve], guide: false, width })
                .unwrap()
                .matches("<polyline")
                .count()
        };
        for width in [Width::Wide, Width::Narrow] {
            let solid = lines(&points, width);
            assert!(lines(&points[1..4], width) > solid + 5, "{solid} when all of it was measured");
        }
    }

    #[test]
    fn a_plot_holds_its_words_and_every_point_that_can_be_shown() {
        let curve =
            |points: &[(f64, f64)]| Curve { name: "relMSE".into(), points: points.to_vec(), marks: points.to_vec() };
        let plot = |curves| Plot {
            title: "cornell & smoke",
            x: "seconds",
            y: "error",
            curves,
            guide: false,
            width: Width::Wide,
        };
        let text = svg(&plot(vec![curve(&[(0.1, 1.0), (1.0, 0.1), (10.0, 0.0), (f64::NAN, 1.0)])])).unwrap();
        for word in ["<svg", "cornell &amp; smoke", "seconds", "error", "relMSE"] {
            assert!(text.contains(word), "{word} in {text}");
        }
        assert_eq!(text.matches("<circle").count(), 2);
        // A line that falls as 1/x is many dots.
        let dots = |guide| {
            let falling = [(1.0, 1.0), (2.0, 0.4), (4.0, 0.3)];
            svg(&Plot { guide, ..plot(vec![curve(&falling)]) }).unwrap().matches("<polyline").count()
        };
        assert!(dots(true) > dots(false) + 5, "{} {}", dots(true), dots(false));
        assert_eq!([0.1 + 0.2, 3e-5, 250.0, 30_000.0].map(|value| short(&value)), ["0.3", "3e-5", "250", "3e4"]);
        // One point is a plot too; none is an error.
        assert!(svg(&plot(vec![curve(&[(1.0, 1.0)])])).is_ok());
        assert!(svg(&plot(vec![curve(&[(1.0, 0.0)])])).unwrap_err().to_string().contains("no points"));
    }
}
