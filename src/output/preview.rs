//! The image so far in the terminal that stderr is: its pixels where the environment names a terminal that shows such, half blocks
//! elsewhere.
//!
//! The program sends no query to the terminal, because the answer would come where users type, or never.

use std::io::Write;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use icy_sixel::SixelImage;

use super::png;
use super::progress::Progress;
use super::view_transform::ViewTransform;
use crate::data::Rgb;
use crate::terminal::size_of_stderr;

/// The rows below the image: the progress, and what is typed next.
const ROWS_BELOW: usize = 3;
/// The pixels of a cell, where the terminal shows pixels: about as many as its own.
const CELL: (usize, usize) = (8, 16);
/// The pixels of a cell, where the terminal does not enlarge images: no more than its own, or the image would be higher than its rows.
const SMALL_CELL: (usize, usize) = (6, 12);
/// The bytes of an image that kitty takes at a time.
const KITTY_CHUNK: usize = 4096;

/// How a terminal shows images.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Protocol {
    /// sw.kovidgoyal.net/kitty/graphics-protocol
    Kitty,
    /// iterm2.com/documentation-images.html
    Iterm2,
    /// vt100.net/docs/vt3xx-gp/chapter14.html
    Sixel,
    /// Two pixels a cell, above each other, in 24 bits of colour or in the 256 colours of xterm.
    Blocks { true_colour: bool },
}

/// Shows images one over the other, at one position on the terminal.
pub struct Preview {
    protocol: Protocol,
    size: (usize, usize),
    view: ViewTransform,
    /// The columns and rows of the terminal at the last drawing, and the lines that had been printed below. If they have changed, the image no
    /// longer stands where it was drawn.
    drawn: Option<((usize, usize), usize)>,
}

impl Preview {
    /// A preview of images of this size, which the view shows as it shows them in a PNG.
    pub fn new(size: (u32, u32), view: ViewTransform) -> Preview {
        let protocol = Protocol::detect(&|name| std::env::var(name).unwrap_or_default());
        Preview { protocol, size: (size.0 as usize, size.1 as usize), view, drawn: None }
    }

    /// Draws the image above the progress, over the last one if that still stands there. `rgb` returns the radiance of a pixel, row 0 on top.
    pub fn show(&mut self, rgb: &dyn Fn(usize) -> Rgb<f32>, progress: &Progress) {
        let window = size_of_stderr();
        let Some(cells) = fitting(self.size, window) else { return };
        let drawn = Some((window, progress.lines()));
        let text = self.text(rgb, cells, drawn == self.drawn);
        self.drawn = drawn;
        // A terminal that is gone does not end a render.
        progress.above(|| _ = std::io::stderr().write_all(text.as_bytes()));
    }

    /// The image in so many columns and rows of the terminal. The cursor stands in the row below the last image, if that is to be drawn over,
    /// and stands below this image at the end.
    fn text(&self, rgb: &dyn Fn(usize) -> Rgb<f32>, (columns, rows): (usize, usize), over: bool) -> String {
        let of_cell = |size: (usize, usize)| {
            let of_blocks = matches!(self.protocol, Protocol::Blocks { .. });
            // Kitty and iTerm2 enlarge what is smaller.
            let most = if of_blocks { (usize::MAX, usize::MAX) } else { self.size };
            ((columns * size.0).min(most.0), (rows * size.1).min(most.1))
        };
        // Room below the cursor first, so that nothing scrolls while the image is drawn.
        let room = if over { String::new() } else { "\n".repeat(rows) };
        let body = match self.protocol {
            Protocol::Blocks { true_colour } => blocks(&self.pixels(rgb, of_cell((1, 2))), columns, true_colour),
            protocol => {
                let size = of_cell(if protocol == Protocol::Sixel { SMALL_CELL } else { CELL });
                let pixels = self.pixels(rgb, size);
                let file = || png::compress((size.0 as u32, size.1 as u32), &pixels).unwrap_or_default();
                let image = match protocol {
                    Protocol::Kitty => kitty(&file(), columns, rows),
                    Protocol::Iterm2 => iterm2(&file(), columns, rows),
                    _ => sixel(&pixels, size),
                };
                // Terminals differ in where an image leaves the cursor.
                format!("\x1b7{image}\x1b8\x1b[{rows}B")
            }
        };
        format!("{room}\r\x1b[{rows}A{body}\r")
    }

    /// The image in so many pixels, no more than it has, row 0 on top: each is the mean radiance of those that it stands for, as the view
    /// shows it.
    fn pixels(&self, rgb: &dyn Fn(usize) -> Rgb<f32>, (width, height): (usize, usize)) -> Vec<[u8; 3]> {
        let stands_for = |index: usize, count: usize, all: usize| {
            let begin = index * all / count;
            begin..((index + 1) * all / count).max(begin + 1)
        };
        let positions = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
        let mean = |(x, y): (usize, usize)| {
            let (across, down) = (stands_for(x, width, self.size.0), stands_for(y, height, self.size.1));
            let share = 1.0 / (across.len() * down.len()) as f32;
            let indices = down.flat_map(|y| across.clone().map(move |x| y * self.size.0 + x));
            indices.map(rgb).fold([0.0; 3], |sum, colour| [0, 1, 2].map(|c| sum[c] + share * colour[c]))
        };
        positions.map(|position| self.view.bytes(mean(position), position)).collect()
    }
}

impl Protocol {
    /// The protocol that the environment names. `variable` gives the value of a variable; the empty text if there is none.
    fn detect(variable: &dyn Fn(&str) -> String) -> Protocol {
        let is_set = |name: &str| !variable(name).is_empty();
        let has = |name: &str, words: &[&str]| words.iter().any(|word| variable(name).contains(word));
        let blocks = Protocol::Blocks { true_colour: has("COLORTERM", &["truecolor", "24bit"]) };
        // Terminal multiplexers pass on the environment of the terminal around them, but no images.
        let is_within = has("TERM", &["screen", "tmux"]) || ["TMUX", "STY", "ZELLIJ"].into_iter().any(is_set);
        if is_within {
            blocks
        } else if is_set("KITTY_WINDOW_ID") || has("TERM", &["kitty", "ghostty"]) {
            Protocol::Kitty
        } else if has("TERM_PROGRAM", &["iTerm", "WezTerm", "mintty", "rio", "WarpTerminal"])
            || has("LC_TERMINAL", &["iTerm", "WezTerm"])
            || is_set("KONSOLE_VERSION")
        {
            Protocol::Iterm2
        } else if has("TERM", &["foot", "mlterm", "contour", "sixel"]) || is_set("MLTERM") || is_set("WT_SESSION") {
            Protocol::Sixel
        } else {
            blocks
        }
    }
}

/// The columns and rows that an image takes: as many as fit, and at most one column a pixel. None if there is no room.
fn fitting((width, height): (usize, usize), window: (usize, usize)) -> Option<(usize, usize)> {
    // A character in the last column would leave the cursor beyond it.
    let (columns, rows) = (window.0.checked_sub(1)?, window.1.checked_sub(ROWS_BELOW)?);
    if columns == 0 || rows == 0 {
        return None;
    }
    // A cell is about twice as high as wide.
    let (width, height, most) = (width as f64, height as f64 / 2.0, (columns as f64, rows as f64));
    let scale = (most.0 / width).min(most.1 / height).min(1.0);
    let cells = |length: f64, most: usize| ((length * scale).round() as usize).clamp(1, most);
    Some((cells(width, columns), cells(height, rows)))
}

/// Rows of upper half blocks: the upper pixel is the character's colour, the lower one that behind it.
fn blocks(pixels: &[[u8; 3]], columns: usize, true_colour: bool) -> String {
    let colour = |[r, g, b]: [u8; 3]| match true_colour {
        true => format!("2;{r};{g};{b}"),
        false => format!("5;{}", of_256([r, g, b])),
    };
    let rows = pixels.chunks(2 * columns).map(|row| {
        let (upper, lower) = row.split_at(columns.min(row.len()));
        let cells = upper.iter().zip(lower).map(|(u, l)| format!("\x1b[38;{};48;{}m▀", colour(*u), colour(*l)));
        cells.collect::<String>() + "\x1b[0m\r\n"
    });
    rows.collect()
}

/// The nearest of xterm's 256 colours: of a cube of 6 x 6 x 6 or of 24 greys.
fn of_256(colour: [u8; 3]) -> usize {
    const LEVELS: [u8; 6] = [0, 95, 135, 175, 215, 255];
    let away = |a: u8, b: u8| u32::from(a.abs_diff(b)).pow(2);
    let distance = |other: [u8; 3]| colour.into_iter().zip(other).map(|(a, b)| away(a, b)).sum::<u32>();
    let cube = (0..216).map(|i| (16 + i, [i / 36, i / 6 % 6, i % 6].map(|level| LEVELS[level])));
    let greys = (0..24).map(|i| (232 + i, [8 + 10 * i as u8; 3]));
    cube.chain(greys).min_by_key(|(_, other)| distance(*other)).map_or(16, |(number, _)| number)
}

/// A PNG for kitty: with a number, by which the next image replaces it (i), in so many columns and rows (c, r), without an answer (q) and
/// without moving the cursor (C).
fn kitty(file: &[u8], columns: usize, rows: usize) -> String {
    let id = std::process::id();
    let text = STANDARD.encode(file);
    let chunks: Vec<_> = text.as_bytes().chunks(KITTY_CHUNK).map(String::from_utf8_lossy).collect();
    let first = format!("a=T,f=100,i={id},p=1,c={columns},r={rows},q=2,C=1,");
    let keys = std::iter::once(first.as_str()).chain(std::iter::repeat("q=2,"));
    let each = chunks.iter().zip(keys).enumerate();
    each.map(|(number, (chunk, keys))| {
        let more = u8::from(number + 1 < chunks.len());
        format!("\x1b_G{keys}m={more};{chunk}\x1b\\")
    })
    .collect()
}

/// A PNG for iTerm2.
fn iterm2(file: &[u8], columns: usize, rows: usize) -> String {
    let (length, text) = (file.len(), STANDARD.encode(file));
    format!("\x1b]1337;File=inline=1;size={length};width={columns};height={rows};preserveAspectRatio=0:{text}\x07")
}

/// The pixels in at most 256 colours; nothing if they cannot be so written.
fn sixel(pixels: &[[u8; 3]], (width, height): (usize, usize)) -> String {
    let opaque = pixels.iter().flat_map(|[r, g, b]| [*r, *g, *b, 255]).collect();
    SixelImage::from_rgba(opaque, width, height).encode().unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn preview(protocol: Protocol, size: (usize, usize)) -> Preview {
        Preview { protocol, size, view: ViewTransform::default(), drawn: None }
    }

    #[test]
    fn the_environment_tells_the_protocol() {
        let of = |set: &[(&str, &str)]| {
            let find = |name: &str| set.iter().find(|(key, _)| *key == name).map_or("", |(_, value)| value).to_owned();
            Protocol::detect(&find)
        };
        let blocks = |true_colour| Protocol::Blocks { true_colour };
        assert_eq!(of(&[]), blocks(false));
        assert_eq!(of(&[("TERM", "xterm-256color"), ("COLORTERM", "truecolor")]), blocks(true));
        assert_eq!(of(&[("TERM", "xterm-kitty")]), Protocol::Kitty);
        assert_eq!(of(&[("KITTY_WINDOW_ID", "1"), ("TERM", "xterm-256color")]), Protocol::Kitty);
        assert_eq!(of(&[("KITTY_WINDOW_ID", "1"), ("TMUX", "/tmp/tmux"), ("COLORTERM", "24bit")]), blocks(true));
        assert_eq!(of(&[("TERM_PROGRAM", "iTerm.app")]), Protocol::Iterm2);
        assert_eq!(of(&[("TERM", "foot"), ("COLORTERM", "truecolor")]), Protocol::Sixel);
        assert_eq!(of(&[("WT_SESSION", "1"), ("TERM", "xterm-256color")]), Protocol::Sixel);
        assert_eq!(of(&[("LC_TERMINAL", "iTerm2"), ("TERM", "screen-256color")]), blocks(false));
    }

    #[test]
    fn images_fit_and_keep_their_shape() {
        assert_eq!(fitting((20, 12), (80, 24)), Some((20, 6)));
        assert_eq!(fitting((1600, 900), (81, 40)), Some((80, 23)));
        assert_eq!(fitting((1600, 900), (400, 23)), Some((71, 20)));
        assert_eq!(fitting((1, 100_000), (80, 24)), Some((1, 21)));
        assert_eq!(fitting((100_000, 1), (80, 24)), Some((79, 1)));
        assert_eq!(
            (fitting((20, 12), (80, 3)), fitting((20, 12), (1, 24)), fitting((20, 12), (0, 0))),
            (None, None, None)
        );
    }

    /// Two columns are drawn as one, with the mean of their radiance and not of their codes.
    #[test]
    fn cells_have_the_mean_radiance() {
        let radiance = [[0.0; 3], [0.4, 0.2, 0.0], [0.1; 3], [0.1; 3]];
        let preview = preview(Protocol::Blocks { true_colour: true }, (2, 2));
        let text = preview.text(&|index| radiance[index], (1, 1), false);
        let view = ViewTransform::default();
        let ([r, g, b], [grey, ..]) = (view.bytes([0.2, 0.1, 0.0], (0, 0)), view.bytes([0.1; 3], (0, 1)));
        let cell = format!("\x1b[38;2;{r};{g};{b};48;2;{grey};{grey};{grey}m▀\x1b[0m");
        assert_eq!(text, format!("\n\r\x1b[1A{cell}\r\n\r"));
        // The next one is drawn over it.
        assert_eq!(preview.text(&|index| radiance[index], (1, 1), true), format!("\r\x1b[1A{cell}\r\n\r"));
    }

    #[test]
    fn a_colour_becomes_the_nearest_of_256() {
        for (colour, number) in
            [([0; 3], 16), ([255; 3], 231), ([255, 0, 0], 196), ([94, 136, 174], 67), ([9; 3], 232), ([129; 3], 244)]
        {
            assert_eq!(of_256(colour), number, "{colour:?}");
        }
    }

    /// The file within the sequences is the image, and the cursor is put back around it.
    #[test]
    fn terminals_that_show_pixels_get_a_png() {
        let radiance = |index: usize| [index as f32 / 20_000.0, 0.1, 0.7];
        let read = |text: &str| image::load_from_memory(&STANDARD.decode(text).expect("base 64")).unwrap().into_rgb8();
        let expected = |preview: &Preview, size| preview.pixels(&radiance, size).concat();

        let kitty = preview(Protocol::Kitty, (200, 100));
        let text = kitty.text(&radiance, (80, 20), true);
        let body = text.strip_prefix("\r\x1b[20A\x1b7").and_then(|text| text.strip_suffix("\x1b8\x1b[20B\r")).unwrap();
        let packets: Vec<_> =
            body.split_terminator("\x1b\\").map(|packet| packet.strip_prefix("\x1b_G").unwrap()).collect();
        assert!(packets.len() > 1 && packets.iter().all(|packet| packet.len() < KITTY_CHUNK + 100));
        assert!(packets[0].starts_with("a=T,f=100,i=") && packets[0].contains(",c=80,r=20,q=2,C=1,m=1;"));
        assert!(packets[1..].iter().rev().zip(0..).all(|(packet, last)| packet.starts_with(if last == 0 {
            "q=2,m=0;"
        } else {
            "q=2,m=1;"
        })));
        let file: String = packets.iter().map(|packet| packet.split_once(';').unwrap().1).collect();
        let image = read(&file);
        assert_eq!((image.dimensions(), image.into_raw()), ((200, 100), expected(&kitty, (200, 100))));

        let iterm2 = preview(Protocol::Iterm2, (200, 100));
        let text = iterm2.text(&radiance, (10, 2), true);
        let body = text.strip_prefix("\r\x1b[2A\x1b7\x1b]1337;File=inline=1;size=").unwrap();
        let (keys, file) = body.strip_suffix("\x07\x1b8\x1b[2B\r").and_then(|body| body.split_once(':')).unwrap();
        assert!(keys.ends_with(";width=10;height=2;preserveAspectRatio=0"), "{keys}");
        let image = read(file);
        assert_eq!((image.dimensions(), image.into_raw()), ((80, 32), expected(&iterm2, (80, 32))));

        let sixel = preview(Protocol::Sixel, (200, 100));
        let text = sixel.text(&radiance, (10, 2), true);
        let body = text.strip_prefix("\r\x1b[2A\x1b7").and_then(|text| text.strip_suffix("\x1b8\x1b[2B\r")).unwrap();
        let image = SixelImage::decode(body.as_bytes()).unwrap();
        assert_eq!((image.width, image.height), (60, 24));
        // The encoder diffuses the errors of its 256 colours, which keeps the mean; a sixel's colours are in percent, so that it is off by half
        // a percent at most.
        let expected = sixel.pixels(&radiance, (60, 24));
        for c in 0..3 {
            let mean = |codes: &mut dyn Iterator<Item = u8>| codes.map(f64::from).sum::<f64>() / 1440.0;
            let found = mean(&mut image.pixels.as_chunks::<4>().0.iter().map(|pixel| pixel[c]));
            let wanted = mean(&mut expected.iter().map(|pixel| pixel[c]));
            assert!((found - wanted).abs() < 1.3, "{found} for {wanted}");
        }
    }
}
