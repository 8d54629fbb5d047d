//! `render --preview`: what stands on a terminal.

use crate::common::program::command;
use crate::common::screen::{interrupted_on_terminal, on_terminal, screen};
use crate::sandbox::{ENDLESS, Sandbox};

use gpu_rt::output::view_transform::{Tonemap, ViewTransform};

/// The columns and rows of the sphere.
const CELLS: (usize, usize) = (20, 6);

fn preview(sandbox: &Sandbox, more: &[&str]) -> std::process::Command {
    let mut command = command(&sandbox.work(), &[&sandbox.render_sphere(), ["--preview"].as_slice(), more].concat());
    command.env("COLORTERM", "truecolor");
    command
}

/// The rows of a screen that have blocks.
fn image_rows(screen: &[String]) -> Vec<usize> {
    (0..screen.len()).filter(|row| screen[*row].contains('▀')).collect()
}

/// The colours of each cell are those of a PNG of the file; above the last words, and no wider than the terminal.
#[test]
fn the_terminal_shows_the_image_of_the_file() {
    let sandbox = Sandbox::new();
    sandbox.render(&[]).exits(0);
    let usual = sandbox.exr("sphere.exr").rgb;
    for more in
        [&["--exposure", "1", "--tonemap", "filmic"] as &[&str], &["--quiet", "--exposure", "1", "--tonemap", "filmic"]]
    {
        let text = on_terminal(preview(&sandbox, more), 80);
        let image = sandbox.exr("sphere.exr").rgb;
        assert!(image == usual, "another image");
        let view = ViewTransform { exposure: 1.0, tonemap: Tonemap::Filmic };
        let colour = |x: usize, y: usize| {
            let [r, g, b] = view.bytes(image[y * 20 + x], (x, y));
            format!("8;2;{r};{g};{b}")
        };
        for row in 0..CELLS.1 {
            let cell = |x| format!("\u{1b}[3{};4{}m▀", colour(x, 2 * row), colour(x, 2 * row + 1));
            let cells: String = (0..CELLS.0).map(cell).collect();
            assert!(text.contains(&cells), "row {row} of {text:?}");
        }
        let screen = screen(&text);
        let is_quiet = more.contains(&"--quiet");
        let rows = image_rows(&screen);
        assert_eq!(rows, (rows[0]..rows[0] + CELLS.1).collect::<Vec<_>>(), "{screen:#?}");
        let last = screen.iter().rfind(|row| !row.is_empty()).expect("there is something");
        assert_eq!(last.contains("16 samples"), !is_quiet, "{screen:#?}");
    }
}

/// Three images stand where the first one was drawn, above the progress. After a message the next one stands below it.
#[test]
fn images_are_drawn_over_each_other() {
    let sandbox = Sandbox::new();
    let images = |text: &str| text.matches('▀').count() / (CELLS.0 * CELLS.1);
    // The progress is there again.
    let is_enough = |text: &str| images(text) == 3 && text.rfind("spp") > text.rfind('▀');
    let (_, text) = interrupted_on_terminal(preview(&sandbox, &["--spp", ENDLESS]), 80, libc::SIGINT, is_enough);
    let so_far = text.char_indices().map(|(at, _)| &text[..at]).find(|text| is_enough(text)).expect("it was enough");
    let before = screen(so_far);
    let rows = image_rows(&before);
    assert_eq!(rows, (rows[0]..rows[0] + CELLS.1).collect::<Vec<_>>(), "{before:#?}");
    assert!(before[rows[0] + CELLS.1].contains("spp"), "{before:#?}");

    let after = screen(&text);
    let said = after.iter().position(|row| row.contains("ending the samples under way")).expect("it is said");
    let (above, below): (Vec<_>, Vec<_>) = image_rows(&after).into_iter().partition(|row| *row < said);
    assert_eq!((above.len(), below.len()), (CELLS.1, CELLS.1), "{after:#?}");
    assert!(
        after.last().is_some_and(|row| row.contains("sphere.exr holds"))
            || after.iter().any(|row| row.contains("error: interrupted"))
    );
    assert!(after.iter().all(|row| row.chars().count() <= 80), "{after:#?}");
}

#[test]
fn a_narrow_terminal_gets_a_small_image() {
    let sandbox = Sandbox::new();
    let screen = screen(&on_terminal(preview(&sandbox, &["--quiet"]), 12));
    assert_eq!(screen.iter().map(|row| row.chars().count()).collect::<Vec<_>>(), [11, 11, 11, 0], "{screen:#?}");
}

#[test]
fn without_a_terminal_it_is_refused() {
    let sandbox = Sandbox::new();
    sandbox.render(&["--preview"]).exits(2).on_stderr(&["--preview draws on standard error"]);
    assert!(sandbox.files().is_empty());
}
