//! What a scene of scenes/test expects of its image, as its leading comment says it (scenes/test/README.md has the grammar).

use std::collections::HashMap;
use std::f64::consts::PI;

use glam::DVec3;
use gpu_rt::data::Sampler;
use gpu_rt::film::Picture;
use gpu_rt::scene::Camera;

use super::render::Shot;
use super::stats::{pixel_test, sidak, student_two_sided};

/// False-alarm rate of one expectation.
pub const ALPHA: f64 = 1e-6;
/// What f32 may do to a value that carries no noise, relative to it: a run adds up to 8 equal values, with 35/8 roundings of the
/// whole on the way at most, and emission, each albedo, each product and the picture are rounded once each. In units of 2^-24 that is
/// less than 16 for paths of a few events.
const ROUNDING: f64 = 1e-6;
/// The side of the tiles that are tested as well as single pixels and the full image: small enough to show what is wrong with one object, large
/// enough to average noise.
const TILE: u32 = 8;

/// All that a scene file's comment says.
#[derive(Debug, Default)]
pub struct Expectations {
    lets: Vec<(String, Expr)>,
    pub list: Vec<Expectation>,
    /// Planted errors: texts of the file, and what replaces them.
    pub planted: Vec<(String, String)>,
    /// Flips of the image that must fail: of its columns, of its rows.
    pub flips: Vec<(bool, bool)>,
    /// The relative errors of the full image, and of one tile, that must fail.
    pub finds: f64,
    pub finds_in_tile: f64,
}

/// One `expect` line.
#[derive(Debug)]
pub struct Expectation {
    line: String,
    /// The scene's own max_depth where absent.
    pub depth: Option<u32>,
    area: Area,
    /// Columns and rows; the full image if absent.
    within: Option<[u32; 4]>,
    rgb: [Expr; 3],
    tolerance: Tolerance,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Area {
    /// The mean over the area.
    Mean,
    /// Each pixel, each tile, and the mean.
    Every,
}

#[derive(Clone, Debug)]
enum Tolerance {
    /// The image's own error estimate decides, at the false-alarm rate `ALPHA`. For samples without a rare value, which a pixel may
    /// have missed: its estimate would then be wrong.
    Noise,
    /// Every sample is either black or this colour, so that the expected value alone says what noise there is.
    Binary([Expr; 3]),
    /// A share of the expected value, pixel by pixel; nothing where that is zero.
    Relative(f64),
}

#[derive(Clone, Debug)]
enum Expr {
    Number(f64),
    Name(String),
    Call(String, Vec<Expr>),
}

impl Expectations {
    /// Reads the comment lines at the top of a scene file.
    pub fn parse(text: &str) -> Result<Expectations, String> {
        let mut all = Expectations { finds: 0.01, finds_in_tile: 0.1, ..Expectations::default() };
        let comment = text.lines().map_while(|line| line.strip_prefix("//"));
        for line in comment.map(str::trim) {
            let wrong = |reason: String| format!("`{line}`: {reason}");
            if let Some(rest) = line.strip_prefix("let ") {
                let (name, value) =
                    rest.split_once('=').ok_or_else(|| wrong("expected `let NAME = EXPRESSION`".into()))?;
                let value = Parser::full(value, Parser::sum).map_err(wrong)?;
                all.lets.push((name.trim().to_owned(), value));
            } else if let Some(rest) = line.strip_prefix("expect") {
                all.list.push(Expectation::parse(line, rest).map_err(wrong)?);
            } else if let Some(axes) = line.strip_prefix("fails: flipped") {
                all.flips.extend(match axes.trim() {
                    "x" => vec![(true, false)],
                    "y" => vec![(false, true)],
                    "" => vec![(true, false), (false, true), (true, true)],
                    _ => return Err(wrong("expected `flipped`, `flipped x` or `flipped y`".into())),
                });
            } else if let Some(rest) = line.strip_prefix("fails: ") {
                let (old, new) = rest.split_once(" => ").ok_or_else(|| wrong("expected `fails: OLD => NEW`".into()))?;
                all.planted.push((old.to_owned(), new.to_owned()));
            } else if let Some(rest) = line.strip_prefix("finds: ") {
                let percent = |text: &str| {
                    let number = text.strip_suffix(" %").and_then(|n| n.parse::<f64>().ok());
                    number.map(|n| n / 100.0).ok_or_else(|| wrong("expected `finds: 1 %`".into()))
                };
                match rest.strip_suffix(" in a tile") {
                    Some(tile) => all.finds_in_tile = percent(tile)?,
                    None => all.finds = percent(rest)?,
                }
            }
        }
        match all.list.is_empty() {
            true => Err("the scene expects nothing".into()),
            false => Ok(all),
        }
    }

    /// The depths at which something is expected.
    pub fn depths(&self) -> Vec<Option<u32>> {
        let mut depths: Vec<_> = self.list.iter().map(|e| e.depth).collect();
        depths.sort();
        depths.dedup();
        depths
    }

    /// What is expected of every pixel of an image of this size, at the scene's own depth.
    pub fn of_every(&self, (width, height): (u32, u32), camera: &Camera) -> Vec<[f64; 3]> {
        let full = |e: &&Expectation| (e.depth, e.area, e.within) == (None, Area::Every, None);
        let expectation = self.list.iter().find(full).expect("it expects something of every pixel");
        self.image(expectation, &Picture { width, height, ..Picture::default() }, camera)
    }

    /// Whether anything but black is expected at this depth.
    pub fn any_light(&self, depth: Option<u32>, shot: &Shot, camera: &Camera) -> bool {
        let at = self.list.iter().filter(|e| e.depth == depth);
        at.flat_map(|e| self.image(e, &shot.picture, camera)).any(|rgb| rgb != [0.0; 3])
    }

    /// The first pixel of a tile of this depth that is tested as one: that nearest to half of the brightest, if that is not black.
    pub fn tile(&self, depth: Option<u32>, shot: &Shot, camera: &Camera) -> Option<(u32, u32)> {
        let every = |e: &&Expectation| e.depth == depth && e.area == Area::Every;
        let mut bright: Vec<((u32, u32), f64)> = Vec::new();
        for e in self.list.iter().filter(every) {
            let [x0, y0, x1, y1] = e.bounds(&shot.picture);
            let columns = x0..x1;
            let pixels = (y0..y1).flat_map(|y| columns.clone().map(move |x| (x, y)));
            let area: Vec<Wanted> = pixels.zip(self.image(e, &shot.picture, camera)).collect();
            let sum = |tile: &[Wanted]| tile.iter().flat_map(|wanted| wanted.1).sum::<f64>();
            bright.extend(tiles(&area).iter().map(|(corner, tile)| (*corner, sum(tile))));
        }
        let half = 0.5 * bright.iter().fold(0.0, |most: f64, tile| most.max(tile.1));
        bright.retain(|tile| tile.1 > 0.0);
        bright.into_iter().min_by(|a, b| (a.1 - half).abs().total_cmp(&(b.1 - half).abs())).map(|tile| tile.0)
    }

    /// Checks the image of this depth; the error is the first expectation that it does not meet.
    pub fn check(&self, depth: Option<u32>, shot: &Shot, camera: &Camera) -> Result<(), String> {
        let at = self.list.iter().filter(|e| e.depth == depth);
        for expectation in at {
            let expected = self.image(expectation, &shot.picture, camera);
            expectation.check(shot, &expected).map_err(|reason| format!("{}\n    {reason}", expectation.line))?;
        }
        Ok(())
    }

    /// What is expected of the pixels of an expectation's area, row by row: the expression averaged over each pixel.
    fn image(&self, expectation: &Expectation, picture: &Picture, camera: &Camera) -> Vec<[f64; 3]> {
        let [x0, y0, x1, y1] = expectation.bounds(picture);
        let view = View::new(camera, (picture.width, picture.height));
        let columns = x0..x1;
        (y0..y1)
            .flat_map(|y| columns.clone().map(move |x| (x, y)))
            .map(|(x, y)| self.pixel(&expectation.rgb, &view, x, y))
            .collect()
    }

    /// The average over a pixel by Gauss and Legendre's rule of 4 x 4 points, which is exact for polynomials of degree 7: for what is
    /// smooth over a pixel its error is far below the rounding of f32.
    fn pixel(&self, rgb: &[Expr; 3], view: &View, x: u32, y: u32) -> [f64; 3] {
        // Abramowitz and Stegun, table 25.4, n = 4, moved to 0..1.
        const INNER: f64 = 0.339_981_043_584_856_3;
        const OUTER: f64 = 0.861_136_311_594_052_6;
        const RULE: [(f64, f64); 4] = [
            (0.5 - 0.5 * OUTER, 0.173_927_422_568_726_93),
            (0.5 - 0.5 * INNER, 0.326_072_577_431_273_07),
            (0.5 + 0.5 * INNER, 0.326_072_577_431_273_07),
            (0.5 + 0.5 * OUTER, 0.173_927_422_568_726_93),
        ];
        let mut mean = [0.0; 3];
        for (v, weight_v) in RULE {
            for (u, weight_u) in RULE {
                let names = self.names(view, f64::from(x) + u, f64::from(y) + v);
                for (mean, expr) in mean.iter_mut().zip(rgb) {
                    *mean += weight_u * weight_v * expr.value(&names);
                }
            }
        }
        mean
    }

    /// The values of all names at a point of the image.
    fn names(&self, view: &View, x: f64, y: f64) -> HashMap<&str, f64> {
        let d = view.direction(x, y);
        let mut names = HashMap::from([("pi", PI), ("x", x), ("y", y), ("dx", d.x), ("dy", d.y), ("dz", d.z)]);
        for (name, value) in &self.lets {
            let value = value.value(&names);
            names.insert(name, value);
        }
        names
    }
}

impl Expectation {
    /// Reads what follows `expect`: `[ at depth N]: AREA[ in (x0, y0, x1, y1)] = (R, G, B) within TOLERANCE`.
    fn parse(line: &str, rest: &str) -> Result<Expectation, String> {
        let (head, body) = rest.split_once(':').ok_or("expected a colon")?;
        let depth = match head.trim() {
            "" => None,
            head => {
                let number = head.strip_prefix("at depth ").and_then(|n| n.parse().ok());
                Some(number.ok_or("expected `at depth N`")?)
            }
        };
        let (area, value) = body.split_once('=').ok_or("expected `AREA = (R, G, B)`")?;
        let (area, within) = match area.trim().split_once('(') {
            None => (area.trim(), None),
            Some((area, numbers)) => {
                let numbers: Result<Vec<u32>, _> =
                    numbers.trim_end_matches(')').split(',').map(|n| n.trim().parse()).collect();
                let numbers = numbers.map_err(|error| format!("the area: {error}"))?;
                let within = match *numbers.as_slice() {
                    [x, y] => [x, y, x + 1, y + 1],
                    [x0, y0, x1, y1] if x0 < x1 && y0 < y1 => [x0, y0, x1, y1],
                    _ => return Err("expected (x, y) or (x0, y0, x1, y1)".into()),
                };
                (area.trim(), Some(within))
            }
        };
        let area = match (area, within) {
            ("mean", None) | ("mean in", Some(_)) => Area::Mean,
            ("every", None) | ("every in", Some(_)) => Area::Every,
            ("pixel", Some([x0, _, x1, _])) if x1 == x0 + 1 => Area::Mean,
            _ => return Err("expected mean, every, or either `in (x0, y0, x1, y1)`, or pixel (x, y)".into()),
        };
        let (value, tolerance) = value.rsplit_once(" within ").ok_or("expected `within noise` or `within 1e-6`")?;
        let tolerance = match tolerance.trim().strip_prefix("noise of 0 or ") {
            Some(colour) => Tolerance::Binary(Parser::triple(colour)?),
            None if tolerance.trim() == "noise" => Tolerance::Noise,
            None => Tolerance::Relative(tolerance.trim().parse().map_err(|_| "expected a tolerance")?),
        };
        Ok(Expectation { line: line.to_owned(), depth, area, within, rgb: Parser::triple(value)?, tolerance })
    }

    fn bounds(&self, picture: &Picture) -> [u32; 4] {
        let full = [0, 0, picture.width, picture.height];
        let bounds = self.within.unwrap_or(full);
        assert!(bounds[2] <= picture.width && bounds[3] <= picture.height, "{}: outside the image", self.line);
        bounds
    }

    fn check(&self, shot: &Shot, expected: &[[f64; 3]]) -> Result<(), String> {
        let [x0, y0, x1, y1] = self.bounds(&shot.picture);
        let columns = x0..x1;
        let pixels = (y0..y1).flat_map(|y| columns.clone().map(move |x| (x, y)));
        let area: Vec<Wanted> = pixels.zip(expected.iter().copied()).collect();
        if shot.sampler == Sampler::Sobol {
            return self.check_defaults(shot, &area);
        }
        if let (Tolerance::Relative(tolerance), Area::Every) = (&self.tolerance, self.area) {
            return area.iter().try_for_each(|wanted| {
                near(shot, std::slice::from_ref(wanted), *tolerance, &format!("pixel {:?}", wanted.0))
            });
        }
        let test = |area: &[Wanted], alpha: f64, what: &str| match &self.tolerance {
            Tolerance::Relative(tolerance) => near(shot, area, *tolerance, what),
            Tolerance::Noise => within_noise(shot, area, ROUNDING, alpha, what),
            Tolerance::Binary(colour) => {
                let colour = [0, 1, 2].map(|c| colour[c].value(&HashMap::new()));
                within_binary_noise(shot, area, colour, alpha, what)
            }
        };
        if self.area == Area::Mean {
            return test(&area, ALPHA, "the mean");
        }
        // Three tests share the false alarms: the full image, tiles, pixels.
        let alpha = sidak(ALPHA, 3);
        test(&area, alpha, "the mean")?;
        let tiles = tiles(&area);
        for (corner, tile) in &tiles {
            test(tile, sidak(alpha, tiles.len()), &format!("the tile at {corner:?}"))?;
        }
        match self.tolerance {
            Tolerance::Noise => pixels_within_noise(shot, &area, alpha),
            _ => area.iter().try_for_each(|wanted| {
                let what = format!("pixel {:?}", wanted.0);
                test(std::slice::from_ref(wanted), sidak(alpha, area.len()), &what)
            }),
        }
    }
}

impl Expectation {
    /// Checks an image by the program's defaults, whose samples may deviate where those of the scene's own way do not: rays to lights and
    /// roulette weigh them. Of the mean and of tiles the image's own error estimate decides. A pixel alone has one degree of freedom, which
    /// tells nothing; where it has no noise at all and none is expected, it is compared by itself.
    fn check_defaults(&self, shot: &Shot, area: &[Wanted]) -> Result<(), String> {
        let width = shot.picture.width;
        let mut rounding = ROUNDING;
        if let Tolerance::Relative(tolerance) = self.tolerance {
            rounding = tolerance.max(ROUNDING);
            let exact = |((x, y), expected): &&Wanted| {
                shot.picture.variance[(y * width + x) as usize] == [0.0; 3] || *expected == [0.0; 3]
            };
            if self.area == Area::Every {
                area.iter().filter(exact).try_for_each(|wanted| {
                    near(shot, std::slice::from_ref(wanted), tolerance, &format!("pixel {:?}", wanted.0))
                })?;
            }
        }
        let tiles = if self.area == Area::Every { tiles(area) } else { Vec::new() };
        let alpha = sidak(ALPHA, 1 + tiles.len());
        within_noise(shot, area, rounding, alpha, "the mean")?;
        tiles.iter().try_for_each(|(corner, tile)| {
            within_noise(shot, tile, rounding, alpha, &format!("the tile at {corner:?}"))
        })
    }
}

/// A pixel's position and its expected value.
type Wanted = ((u32, u32), [f64; 3]);

/// The means of what was found and of what is expected over an area.
fn means(shot: &Shot, area: &[Wanted]) -> ([f64; 3], [f64; 3]) {
    let n = area.len() as f64;
    let mean = |value: &dyn Fn(&Wanted) -> [f64; 3]| {
        let add = |sum: [f64; 3], v: [f64; 3]| [0, 1, 2].map(|c| sum[c] + v[c] / n);
        area.iter().map(value).fold([0.0; 3], add)
    };
    (mean(&|((x, y), _)| shot.pixel(*x, *y)), mean(&|wanted| wanted.1))
}

fn near(shot: &Shot, area: &[Wanted], tolerance: f64, what: &str) -> Result<(), String> {
    let (found, expected) = means(shot, area);
    let near = |c: usize| (found[c] - expected[c]).abs() <= tolerance * expected[c].abs();
    match (0..3).all(near) {
        true => Ok(()),
        false => Err(format!("{what} is {found:?}, expected {expected:?}")),
    }
}

/// Student's test of the mean over an area, in each channel. Noise aside, the mean may be off by `rounding`: what f32 does to it.
fn within_noise(shot: &Shot, area: &[Wanted], rounding: f64, alpha: f64, what: &str) -> Result<(), String> {
    let width = shot.picture.width;
    let found = shot.mean_over(area.iter().map(|((x, y), _)| (y * width + x) as usize));
    let (_, expected) = means(shot, area);
    for channel in 0..3 {
        let (value, expected) = (found.value[channel], expected[channel]);
        let excess = ((value - expected).abs() - rounding * expected).max(0.0);
        let t = match excess == 0.0 {
            true => 0.0,
            false => excess / found.variance[channel].sqrt(),
        };
        let p = student_two_sided(t, found.degrees[channel]);
        if area.len() as u32 > TILE * TILE {
            println!("{what}, channel {channel}: found {value:.6}, expected {expected:.6}, t = {t:.2}");
        }
        // A p-value that is not a number is no success.
        if p.is_nan() || p < sidak(alpha, 3) {
            return Err(format!(
                "{what}, channel {channel}: found {value}, expected {expected}, t = {t:.2}, p = {p:.1e}"
            ));
        }
    }
    Ok(())
}

/// Whether samples that are all 0 or `colour` can have this mean: by Chernoff's bound, P(|X/n - p| >= |x - p|) <= 2 exp(-n D(x, p))
/// with D the Kullback-Leibler divergence, which holds whatever the n and p, and where p differs from pixel to pixel too
/// (Hoeffding, "Probability inequalities for sums of bounded random variables", 1963, theorem 1).
fn within_binary_noise(shot: &Shot, area: &[Wanted], colour: [f64; 3], alpha: f64, what: &str) -> Result<(), String> {
    let samples = area.len() as f64 * f64::from(shot.picture.samples[0]);
    let (found, expected) = means(shot, area);
    for channel in 0..3 {
        let (x, p) = (found[channel] / colour[channel], expected[channel] / colour[channel]);
        let nearest = p.clamp(x - ROUNDING, x + ROUNDING).clamp(0.0, 1.0);
        let part = |x: f64, p: f64| if x == 0.0 { 0.0 } else { x * (x / p).ln() };
        let divergence = part(nearest, p) + part(1.0 - nearest, 1.0 - p);
        let bound = 2.0 * (-samples * divergence).exp();
        if area.len() as u32 > TILE * TILE {
            let z = (x - p) / (p * (1.0 - p) / samples).sqrt();
            println!("{what}, channel {channel}: found {x:.6} and expected {p:.6} of {}, z = {z:.2}", colour[channel]);
        }
        if bound.is_nan() || bound < sidak(alpha, 3) {
            return Err(format!(
                "{what}, channel {channel}: found {x}, expected {p} of {}, p <= {bound:.1e}",
                colour[channel]
            ));
        }
    }
    Ok(())
}

fn pixels_within_noise(shot: &Shot, area: &[Wanted], alpha: f64) -> Result<(), String> {
    let width = shot.picture.width;
    let pick = |values: &[[f32; 3]]| -> Vec<[f32; 3]> {
        area.iter().map(|((x, y), _)| values[(y * width + x) as usize]).collect()
    };
    let expected: Vec<_> = area.iter().map(|(_, e)| e.map(|v| v as f32)).collect();
    // Rounding enters as if it were noise of the reference.
    let rounding: Vec<_> = area.iter().map(|(_, e)| e.map(|v| (v * ROUNDING).powi(2) as f32)).collect();
    let (image, variance) = (pick(&shot.picture.rgb), pick(&shot.picture.variance));
    let degrees = f64::from(shot.runs() - 1);
    let test = pixel_test(&image, &variance, &expected, &rounding, degrees, alpha);
    match test.passed {
        true => Ok(()),
        false => Err(format!(
            "pixel {:?}: found {:?}, expected {:?}, variance {:?}, {test:?}",
            area[test.pixel].0, image[test.pixel], expected[test.pixel], variance[test.pixel]
        )),
    }
}

/// The complete tiles of an area, by the position of their first pixel.
fn tiles(area: &[Wanted]) -> Vec<((u32, u32), Vec<Wanted>)> {
    let mut tiles: HashMap<(u32, u32), Vec<Wanted>> = HashMap::new();
    for wanted in area {
        let (x, y) = wanted.0;
        tiles.entry((x / TILE, y / TILE)).or_default().push(*wanted);
    }
    let mut tiles: Vec<_> = tiles.into_iter().map(|((x, y), tile)| ((x * TILE, y * TILE), tile)).collect();
    tiles.retain(|(_, tile)| tile.len() as u32 == TILE * TILE);
    tiles.sort_by_key(|tile| tile.0);
    tiles
}

/// A pinhole camera in f64, as docs/light-transport.md defines it ("Camera and lens").
pub struct View {
    forward: DVec3,
    right: DVec3,
    up: DVec3,
    size: (f64, f64),
}

impl View {
    pub fn new(camera: &Camera, size: (u32, u32)) -> View {
        let (width, height) = (f64::from(size.0), f64::from(size.1));
        let half = (camera.vertical_fov.expect("it is perspective").to_radians() / 2.0).tan();
        let forward = (camera.look_at - camera.look_from).normalize();
        let right = forward.cross(camera.up).normalize();
        View { forward, right: right * (half * width / height), up: right.cross(forward) * half, size: (width, height) }
    }

    /// The unit direction through a point of the image, in pixels from its top left corner.
    pub fn direction(&self, x: f64, y: f64) -> DVec3 {
        let (u, v) = (2.0 * x / self.size.0 - 1.0, 1.0 - 2.0 * y / self.size.1);
        (self.forward + u * self.right + v * self.up).normalize()
    }
}

impl Expr {
    fn value(&self, names: &HashMap<&str, f64>) -> f64 {
        match self {
            Expr::Number(value) => *value,
            Expr::Name(name) => *names.get(name.as_str()).unwrap_or_else(|| panic!("{name} is not defined above")),
            Expr::Call(function, arguments) => {
                let arguments: Vec<f64> = arguments.iter().map(|a| a.value(names)).collect();
                match (function.as_str(), arguments.as_slice()) {
                    ("+", [a, b]) => a + b,
                    ("-", [a, b]) => a - b,
                    ("*", [a, b]) => a * b,
                    ("/", [a, b]) => a / b,
                    ("^", [a, b]) => a.powf(*b),
                    ("-", [a]) => -a,
                    ("sqrt", [a]) => a.sqrt(),
                    ("exp", [a]) => a.exp(),
                    ("sin", [a]) => a.sin(),
                    ("cos", [a]) => a.cos(),
                    ("acos", [a]) => a.acos(),
                    ("atan", [a]) => a.atan(),
                    ("abs", [a]) => a.abs(),
                    ("min", [a, b]) => a.min(*b),
                    ("max", [a, b]) => a.max(*b),
                    (function, arguments) => {
                        panic!("there is no function {function} of {} arguments", arguments.len())
                    }
                }
            }
        }
    }
}

/// Reads expressions by recursive descent: sums of products of powers of numbers, names, calls and parentheses.
struct Parser<'a> {
    rest: &'a str,
}

impl<'a> Parser<'a> {
    /// Reads a text to its end.
    fn full<T>(text: &'a str, read: impl Fn(&mut Parser<'a>) -> Result<T, String>) -> Result<T, String> {
        let mut parser = Parser { rest: text };
        let found = read(&mut parser)?;
        match parser.peek() {
            None => Ok(found),
            Some(_) => Err(format!("cannot read on from `{}`", parser.rest)),
        }
    }

    /// `(R, G, B)`
    fn triple(text: &'a str) -> Result<[Expr; 3], String> {
        let list = Parser::full(text, Parser::list)?;
        <[Expr; 3]>::try_from(list).map_err(|list| format!("{} values, expected 3", list.len()))
    }

    fn peek(&mut self) -> Option<char> {
        self.rest = self.rest.trim_start();
        self.rest.chars().next()
    }

    /// Takes the next character if it is one of these.
    fn take(&mut self, wanted: &str) -> Option<char> {
        let found = self.peek().filter(|c| wanted.contains(*c))?;
        self.rest = &self.rest[found.len_utf8()..];
        Some(found)
    }

    fn need(&mut self, wanted: &str) -> Result<(), String> {
        self.take(wanted).map(drop).ok_or_else(|| format!("expected {wanted} before `{}`", self.rest))
    }

    fn sum(&mut self) -> Result<Expr, String> {
        self.chain("+-", |parser| parser.chain("*/", Parser::factor))
    }

    /// Parts with these signs between them.
    fn chain(&mut self, signs: &str, part: impl Fn(&mut Self) -> Result<Expr, String>) -> Result<Expr, String> {
        let mut left = part(self)?;
        while let Some(sign) = self.take(signs) {
            left = Expr::Call(sign.to_string(), vec![left, part(self)?]);
        }
        Ok(left)
    }

    fn factor(&mut self) -> Result<Expr, String> {
        if self.take("-").is_some() {
            return Ok(Expr::Call("-".into(), vec![self.factor()?]));
        }
        let base = self.atom()?;
        Ok(if self.take("^").is_some() { Expr::Call("^".into(), vec![base, self.factor()?]) } else { base })
    }

    fn atom(&mut self) -> Result<Expr, String> {
        match self.peek() {
            Some('(') => {
                self.need("(")?;
                let inner = self.sum()?;
                self.need(")").map(|()| inner)
            }
            Some(c) if c.is_ascii_digit() => {
                let number = self.word(|c| c.is_ascii_digit() || c == '.');
                number.parse().map(Expr::Number).map_err(|_| format!("{number} is no number"))
            }
            Some(c) if c.is_alphabetic() => {
                let name = self.word(|c| c.is_alphanumeric() || c == '_');
                Ok(if self.peek() == Some('(') {
                    Expr::Call(name.into(), self.list()?)
                } else {
                    Expr::Name(name.into())
                })
            }
            _ => Err(format!("expected a value before `{}`", self.rest)),
        }
    }

    fn list(&mut self) -> Result<Vec<Expr>, String> {
        self.need("(")?;
        let mut list = vec![self.sum()?];
        while self.take(",").is_some() {
            list.push(self.sum()?);
        }
        self.need(")").map(|()| list)
    }

    fn word(&mut self, belongs: impl Fn(char) -> bool) -> &'a str {
        let end = self.rest.find(|c| !belongs(c)).unwrap_or(self.rest.len());
        let (word, rest) = self.rest.split_at(end);
        self.rest = rest;
        word
    }
}
