//! The sensor with its film, and the integrator.

use super::document::Node;
use super::properties::{Properties, unknown};
use super::reader::Reader;
use crate::error::{Result, require};
use crate::printable::quote;
use crate::scene::types::{Camera, ImageSize, Projection};

/// As many scattering events as there may be: a depth of -1.
const UNLIMITED: u32 = 1_000_000;

/// The film of a sensor, whose size may be that of a part of it.
struct Film {
    width: f64,
    height: f64,
    crop: [f64; 4],
}

impl Film {
    fn is_cropped(&self) -> bool {
        self.crop != [0.0, 0.0, self.width, self.height]
    }
}

/// The camera, the image and the samples per pixel.
pub fn sensor<'a>(node: &'a Node, reader: &mut Reader<'a, '_>) -> Result<(Camera, ImageSize, u32)> {
    let own = Properties::of(node);
    for clip in ["near_clip", "far_clip"].into_iter().filter_map(|name| own.find(name)) {
        reader.lose(clip, "it is not used: nothing is cut off");
    }
    let kind = own.kind_among(&["perspective", "thinlens", "orthographic"])?;
    let film = match own.elements("film", reader)?[..] {
        [] => Film { width: 768.0, height: 576.0, crop: [0.0, 0.0, 768.0, 576.0] },
        [film] => self::film(film, reader)?,
        _ => return Err(node.error("expected one film")),
    };
    let mut samples = 4;
    for sampler in own.elements("sampler", reader)? {
        let given = Properties::of(sampler);
        given.ignore(&["seed", "jitter"]);
        let count = given.integer_or("sample_count", 4)?;
        let count = u32::try_from(count).ok().filter(|count| (1..=1 << 31).contains(count));
        samples = count.ok_or_else(|| sampler.error("expected a sample_count from 1 to 2147483648"))?;
        given.end(reader);
    }
    let to_world = own.transform("to_world")?;
    let [x, y, z] = to_world.matrix3.to_cols_array_2d().map(glam::DVec3::from_array);
    let lengths = [x.length(), y.length(), z.length()];
    let angles = [x.dot(y), y.dot(z), z.dot(x)].map(f64::abs).into_iter().fold(0.0, f64::max);
    let has_size = lengths.iter().all(|length| *length > 0.0);
    let is_right = has_size && angles <= 1e-4 * lengths[0] * lengths[1].max(lengths[2]);
    require(is_right, || node.error("expected a to_world whose axes are at right angles"))?;
    let is_scaled = lengths.iter().any(|length| (length - 1.0).abs() > 1e-3);
    require(!is_scaled || kind == "orthographic", || node.error("expected a to_world without a scale"))?;
    let from = to_world.translation;
    // Media are where their boundaries are.
    reader.made.outside = own.elements("medium", reader)?.is_empty().then(|| (node.at.clone(), node.title(), from));
    let mut camera = Camera::pinhole(from, from + z / lengths[2], y / lengths[1], 45.0);
    camera.mirror = to_world.matrix3.determinant() < 0.0;
    camera.vertical_fov = None;
    // Shares of the film by which the axis is further to the left and further up.
    let shift = [own.number_or("principal_point_offset_x", 0.0)?, own.number_or("principal_point_offset_y", 0.0)?];
    for name in ["shutter_open", "shutter_close"] {
        own.number(name)?;
    }
    if kind == "orthographic" {
        require(!film.is_cropped(), || {
            node.error("expected a film without a crop: orthographic sensors have none here")
        })?;
        let is_even = (lengths[0] - lengths[1]).abs() <= 1e-3 * lengths[0];
        require(is_even, || node.error("expected a to_world that scales x and y alike"))?;
        camera.projection = Some(Projection::Orthographic { height: 2.0 * lengths[0] * film.height / film.width });
    } else {
        let wide = half_width(&own, &film)?;
        let high = wide * film.height / film.width;
        match film.is_cropped() || shift != [0.0; 2] {
            false => camera.vertical_fov = Some(2.0 * high.atan().to_degrees()),
            true => {
                let (fx, fy) = (0.5 * film.width / wide, 0.5 * film.height / high);
                let [left, top, width, _] = film.crop;
                let (cx, cy) = ((0.5 - shift[0]) * film.width - left, (0.5 - shift[1]) * film.height - top);
                // A mirror image has its left at the right.
                let cx = if camera.mirror { width - cx } else { cx };
                camera.projection = Some(Projection::Calibrated { fx, fy, cx, cy, distortion: None });
            }
        }
    }
    if kind == "thinlens" {
        let radius = own.number("aperture_radius")?;
        camera.aperture = 2.0 * radius.ok_or_else(|| node.error("expected its aperture_radius"))?;
        camera.focus_distance = Some(own.number_or("focus_distance", 1e4)?);
    } else {
        own.ignore(&["focus_distance"]);
    }
    own.end(reader);
    let [_, _, width, height] = film.crop.map(|length| length as u32);
    Ok((camera, ImageSize { width, height }, samples))
}

/// The tangent of half of the horizontal angle.
fn half_width(own: &Properties, film: &Film) -> Result<f64> {
    let fov = own.number("fov")?;
    let length = own.word("focal_length")?;
    let axis = own.word("fov_axis")?.unwrap_or("x");
    let (fov, axis) = match (fov, length) {
        (Some(_), Some(_)) => return Err(own.node.error("expected fov or focal_length, found both")),
        (Some(fov), None) => (fov, axis),
        (None, length) => {
            let length = length.unwrap_or("50mm");
            let number = length.strip_suffix("mm").unwrap_or(length).trim().parse::<f64>().ok();
            let number = number.filter(|number| number.is_finite() && *number > 0.0);
            let wrong = || own.node.error(format!("expected a focal_length such as 50mm, found {}", quote(length)));
            // The diagonal of a film of 36 x 24 mm.
            let diagonal = 36f64.hypot(24.0);
            (2.0 * (0.5 * diagonal / number.ok_or_else(wrong)?).atan().to_degrees(), "diagonal")
        }
    };
    require(fov > 0.0 && fov < 180.0, || own.node.error(format!("expected a fov above 0 and below 180, found {fov}")))?;
    let half = (0.5 * fov.to_radians()).tan();
    let high = film.height / film.width;
    match axis.to_ascii_lowercase().as_str() {
        "x" => Ok(half),
        "y" => Ok(half / high),
        "diagonal" => Ok(half / 1f64.hypot(high)),
        "smaller" => Ok(if high > 1.0 { half } else { half / high }),
        "larger" => Ok(if high > 1.0 { half / high } else { half }),
        other => {
            let message = format!("expected fov_axis x, y, diagonal, smaller or larger, found {}", quote(other));
            Err(own.node.error(message))
        }
    }
}

fn film(node: &Node, reader: &mut Reader) -> Result<Film> {
    let own = Properties::of(node);
    own.kind_among(&["hdrfilm", "ldrfilm"])?;
    own.ignore(&["file_format", "pixel_format", "component_format", "sample_border", "banner", "compensate", "gamma"]);
    own.ignore(&["high_quality_edges", "fog"]);
    let length = |name: &str, default: f64, most: f64| {
        let found = own.integer_or(name, default as i64)? as f64;
        let fits = found >= 0.0 && found <= most;
        require(fits, || node.error(format!("expected {name} from 0 to {most}, found {found}"))).map(|()| found)
    };
    let (width, height) = (length("width", 768.0, 65536.0)?, length("height", 576.0, 65536.0)?);
    let (left, top) = (length("crop_offset_x", 0.0, width)?, length("crop_offset_y", 0.0, height)?);
    let crop = [
        left,
        top,
        length("crop_width", width - left, width - left)?,
        length("crop_height", height - top, height - top)?,
    ];
    // Without one, Mitsuba takes a Gaussian.
    let filter = own.take(|child| child.tag == "rfilter").pop();
    let kind = filter.map_or(Ok("gaussian"), |filter| filter.required("type"))?;
    if kind != "box" {
        let message = format!("the film's filter {} is not used: --filter chooses one", quote(kind));
        reader.lose(filter.unwrap_or(node), &message);
    }
    own.end(reader);
    Ok(Film { width, height, crop })
}

/// The most scattering events of a path.
pub fn integrator<'a>(node: &'a Node, reader: &mut Reader<'a, '_>) -> Result<u32> {
    let own = Properties::of(node);
    own.ignore(&["samples_per_pass", "block_size", "timeout", "rr_depth"]);
    let depth = match own.kind()? {
        "path" | "volpath" | "volpathmis" => own.integer_or("max_depth", -1)?,
        "direct" => {
            own.ignore(&["shading_samples", "bsdf_samples"]);
            if own.integer_or("emitter_samples", 1)? > 1 {
                reader.lose(node, "Mitsuba counts lights without size emitter_samples times, and this program once");
            }
            2
        }
        "moment" | "aov" => {
            own.ignore(&["aovs"]);
            reader.lose(node, "its channels are left out: --aov has ours, and variance is stored");
            match own.take(|child| child.tag == "integrator")[..] {
                [inner] => return integrator(inner, reader),
                _ => return Err(node.error("expected one integrator in it")),
            }
        }
        _ => return Err(unknown(node, "path, volpath, volpathmis, direct, moment, aov")),
    };
    if own.flag_or("hide_emitters", false)? {
        reader.lose(node, "hide_emitters is not used: emitters and the sky are seen");
    }
    own.end(reader);
    match depth {
        ..0 => Ok(UNLIMITED),
        // Theirs counts the segments of a path, ours the events between them.
        1.. => Ok(u32::try_from(depth - 1).unwrap_or(UNLIMITED).min(UNLIMITED)),
        0 => Err(node.error("expected a max_depth of -1 or above 0: of 0 the image is black")),
    }
}
