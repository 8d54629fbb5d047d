//! The files of a page: a folder for a server, or one file that opens from a disk.

use std::io::Write as _;
use std::path::Path;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use flate2::Compression;
use flate2::write::GzEncoder;

use super::Page;
use crate::error::Result;
use crate::output::atomic;

const HTML: &str = include_str!("player/index.html");
const STYLE: &str = include_str!("player/style.css");
/// The player's modules, each after those that it imports. The first is also the worker's.
const MODULES: [(&str, &str); 8] = [
    ("film.js", include_str!("player/film.js")),
    ("device.js", include_str!("player/device.js")),
    ("camera.js", include_str!("player/camera.js")),
    ("renderer.js", include_str!("player/renderer.js")),
    ("show.js", include_str!("player/show.js")),
    ("save.js", include_str!("player/save.js")),
    ("controls.js", include_str!("player/controls.js")),
    ("main.js", include_str!("player/main.js")),
];

/// Writes the page as files of a folder, which is there.
///
/// # Errors
/// If a file cannot be written.
pub fn write_folder(page: &Page, folder: &Path) -> Result<()> {
    let head = "<link rel=\"stylesheet\" href=\"style.css\">";
    let script = "<script type=\"module\" src=\"main.js\"></script>";
    let html = filled(page, head, "picture.png", script);
    let picture = page.picture.iter().map(|(bytes, _)| ("picture.png", &bytes[..]));
    let plan = page.plan.to_string();
    let data = packed(&page.data);
    let own = [
        ("index.html", html.as_bytes()),
        ("style.css", STYLE.as_bytes()),
        ("plan.json", plan.as_bytes()),
        ("data.gz", &data),
    ];
    let modules = MODULES.iter().map(|(name, text)| (*name, text.as_bytes()));
    own.into_iter().chain(picture).chain(modules).try_for_each(|(name, bytes)| atomic::write(&folder.join(name), bytes))
}

/// Writes the page as one file: one script without imports, which fetches nothing.
///
/// # Errors
/// If the file cannot be written.
pub fn write_single(page: &Page, path: &Path) -> Result<()> {
    let head = format!("<style>\n{STYLE}</style>");
    let picture = page.picture.as_ref().map_or(&[][..], |(bytes, _)| bytes);
    let picture = format!("data:image/png;base64,{}", STANDARD.encode(picture));
    let modules: String = MODULES.iter().map(|(_, text)| joined(text)).collect();
    // Within a script, these would end it or begin a comment.
    let plan = page.plan.to_string().replace("</", "<\\/").replace("<!", "\\u003c!");
    let script = format!(
        "<script type=\"application/json\" id=\"plan\">{plan}</script>\n\
         <script type=\"text/plain\" id=\"data\">{}</script>\n\
         <script type=\"text/plain\" id=\"worker\">\n{}</script>\n\
         <script type=\"module\">\n{modules}</script>",
        STANDARD.encode(packed(&page.data)),
        joined(MODULES[0].1),
    );
    atomic::write(path, filled(page, &head, &picture, &script).as_bytes())
}

fn filled(page: &Page, head: &str, picture: &str, script: &str) -> String {
    let escaped = |text: &str| text.replace('&', "&amp;").replace('<', "&lt;").replace('"', "&quot;");
    let title = escaped(&page.title);
    let of_words = |words: &str| {
        let alt = format!("{title}, rendered before");
        format!("<img src=\"{picture}\" alt=\"{alt}\"><figcaption>{}</figcaption>", escaped(words))
    };
    let still = page.picture.as_ref().map_or(String::new(), |(_, words)| of_words(words));
    let parts = [("{{title}}", &*title), ("{{head}}", head), ("{{still}}", &*still), ("{{script}}", script)];
    parts.iter().fold(HTML.to_owned(), |html, (name, text)| html.replace(name, text))
}

/// The text of a module as a part of one script.
fn joined(text: &str) -> String {
    let lines = text.lines().filter(|line| !line.starts_with("import "));
    lines.map(|line| format!("{}\n", line.strip_prefix("export ").unwrap_or(line))).collect()
}

fn packed(bytes: &[u8]) -> Vec<u8> {
    let mut packed = GzEncoder::new(Vec::new(), Compression::best());
    // Memory takes all bytes.
    let written = packed.write_all(bytes).and_then(|()| packed.finish());
    written.unwrap_or_default()
}
