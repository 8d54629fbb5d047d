//! The camera with its film, and the integrator.

use glam::{DAffine3, DVec3};

use super::params::Params;
use super::reader::{Film, Reader};
use crate::error::{Result, require};
use crate::printable::quote;
use crate::scene::types::{Camera, ImageSize, Projection};

pub fn film(kind: &str, params: &Params, reader: &mut Reader) -> Result<()> {
    require(["rgb", "gbuffer"].contains(&kind), || params.error("this film is not read: expected rgb"))?;
    params.ignore(&["filename", "savefp16", "diagonal", "maxcomponentvalue", "coordinatesystem"]);
    let length = |name: &str, default: i64| {
        let found = params.integer_or(name, default)?;
        let wrong = || params.error_at(name, format!("expected {name} from 1 to 65536, found {found}"));
        require((1..=65536).contains(&found), wrong).map(|()| found as f64)
    };
    let (width, height) = (length("xresolution", 1280)?, length("yresolution", 720)?);
    let share = edges(params, "cropwindow", "float")?;
    let pixels = edges(params, "pixelbounds", "integer")?;
    let crop = match (pixels, share) {
        (Some(pixels), _) => pixels,
        (None, Some([a, b, c, d])) => [a * width, b * width, c * height, d * height].map(f64::ceil),
        (None, None) => [0.0, width, 0.0, height],
    };
    let most = [width, width, height, height];
    let crop = [0, 1, 2, 3].map(|side| crop[side].clamp(0.0, most[side]));
    let has_pixels = crop[1] > crop[0] && crop[3] > crop[2];
    require(has_pixels, || params.error("expected a crop that leaves a pixel"))?;
    if let Some(sensor) = params.word("sensor")?.filter(|sensor| *sensor != "cie1931") {
        let message = format!("the sensor {} is not used: colours are those of the observer of 1931", quote(sensor));
        reader.lose(params, "sensor", &message);
    }
    if params.number_or("whitebalance", 0.0)? != 0.0 {
        reader.lose(params, "whitebalance", "the white is not balanced here");
    }
    let scale = params.number_or("iso", 100.0)? / 100.0;
    reader.film = Film { width, height, crop, scale };
    reader.made.parts.image = Some(ImageSize { width: (crop[1] - crop[0]) as u32, height: (crop[3] - crop[2]) as u32 });
    reader.end(params);
    Ok(())
}

/// The left and the right edge of a window, and those along its height.
fn edges(params: &Params, name: &str, kind: &str) -> Result<Option<[f64; 4]>> {
    match params.numbers(name, &[kind])? {
        None => Ok(None),
        Some(&[a, b, c, d]) if a < b && c < d => Ok(Some([a, b, c, d])),
        Some(_) => {
            Err(params.error_at(name, "expected four numbers: left, right, and two along the height; each pair rises"))
        }
    }
}

/// The camera, once the film is known.
pub fn camera(kind: &str, params: &Params, to_world: &DAffine3, reader: &mut Reader) -> Result<()> {
    let [x, y, z] = to_world.matrix3.to_cols_array_2d().map(DVec3::from_array);
    let lengths = [x.length(), y.length(), z.length()];
    let longest = lengths.into_iter().fold(0.0, f64::max);
    let angles = [x.dot(y), y.dot(z), z.dot(x)].map(f64::abs).into_iter().fold(0.0, f64::max);
    let is_even = lengths.iter().all(|length| (longest - length).abs() <= 1e-3 * longest);
    let is_one = is_even && angles <= 1e-4 * longest * longest;
    require(is_one, || params.error("expected a transform of turns, shifts and one scale before the camera"))?;
    // A negative 0 is written as 0.
    let plain = |v: DVec3| v + DVec3::ZERO;
    let from = plain(to_world.translation);
    let mut camera = Camera::pinhole(from, from + plain(z / longest), plain(y / longest), 45.0);
    camera.vertical_fov = None;
    reader.made.outside = (!reader.state.has_outside).then(|| (params.at.clone(), params.title.clone(), from));
    // With an x that is the viewer's left, as LookAt alone gives, the image is mirrored.
    camera.mirror = to_world.matrix3.determinant() > 0.0;
    reader.film.scale *= params.number_or("shutterclose", 1.0)? - params.number_or("shutteropen", 0.0)?;
    let Film { width, height, crop: [left, right, top, bottom], .. } = reader.film;
    let aspect = params.number_or("frameaspectratio", width / height)?;
    let usual = if aspect > 1.0 { [-aspect, aspect, -1.0, 1.0] } else { [-1.0, 1.0, -1.0 / aspect, 1.0 / aspect] };
    let [x0, x1, y0, y1] = edges(params, "screenwindow", "float")?.unwrap_or(usual);
    let has_even_pixels = ((x1 - x0) / width - (y1 - y0) / height).abs() <= 1e-6 * (x1 - x0) / width;
    let is_whole = [left, right, top, bottom] == [0.0, width, 0.0, height];
    let is_plain = has_even_pixels && is_whole && x0 == -x1 && y0 == -y1;
    match kind {
        "perspective" => {
            let fov = params.number_or("fov", 90.0)?;
            let wrong = || params.error_at("fov", format!("expected a fov above 0 and below 180, found {fov}"));
            require(fov > 0.0 && fov < 180.0, wrong)?;
            let half = (0.5 * fov.to_radians()).tan();
            if is_plain {
                camera.vertical_fov = Some(2.0 * (half * y1).atan().to_degrees());
            } else {
                let (fx, fy) = (width / (half * (x1 - x0)), height / (half * (y1 - y0)));
                let (cx, cy) = (-x0 / (x1 - x0) * width - left, y1 / (y1 - y0) * height - top);
                // A mirror image has its left at the right.
                let cx = if camera.mirror { right - left - cx } else { cx };
                camera.projection = Some(Projection::Calibrated { fx, fy, cx, cy, distortion: None });
            }
        }
        "orthographic" => {
            let message = "expected the usual screenwindow and no crop: parallel rays have no others here";
            require(is_plain, || params.error(message))?;
            camera.projection = Some(Projection::Orthographic { height: 2.0 * y1 * longest });
        }
        "spherical" => {
            let is_read = params.word("mapping")? == Some("equirectangular") && is_whole;
            let wrong = || params.error_at("mapping", "expected equirectangular, and no crop: others are not read");
            require(is_read, wrong)?;
            // Its image shows the right, the front, the left and the back: the left is in the middle.
            camera.look_at = from - plain(x / longest);
            camera.mirror = !camera.mirror;
            camera.projection =
                Some(Projection::Equirectangular { horizontal: (-180.0, 180.0), vertical: (-90.0, 90.0) });
        }
        _ => return Err(params.error("this camera is not read: expected perspective, orthographic or spherical")),
    }
    let radius = params.number_or("lensradius", 0.0)? * longest;
    let focus = params.number_or("focaldistance", 1e6)? * longest;
    if radius > 0.0 {
        require(kind == "perspective", || params.error_at("lensradius", "only a perspective camera has a lens here"))?;
        (camera.aperture, camera.focus_distance) = (2.0 * radius, Some(focus));
    }
    reader.end(params);
    reader.made.place(&["camera", "image", "render"], &params.at);
    reader.made.parts.camera = Some(camera);
    Ok(())
}

pub fn integrator(kind: &str, params: &Params, reader: &mut Reader) -> Result<()> {
    let known = ["path", "volpath", "simplepath", "simplevolpath", "bdpt", "mlt", "sppm", "lightpath"];
    require(known.contains(&kind), || params.error("this integrator is not read: expected path or volpath"))?;
    let depth = params.integer_or("maxdepth", 5)?;
    let depth = u32::try_from(depth).ok().filter(|depth| (1..=1_000_000).contains(depth));
    reader.made.parts.render.max_depth =
        depth.ok_or_else(|| params.error_at("maxdepth", "expected a maxdepth from 1 to 1000000"))?;
    if params.flag_or("regularize", false)? {
        reader.lose(params, "", "regularize is not used: nothing is blurred");
    }
    let others = "lightsampler samplelights samplebsdf bootstrapsamples chains mutationsperpixel largestepprobability sigma photonsperiteration \
                  radius seed visualizestrategies visualizeweights";
    params.ignore(&others.split_whitespace().collect::<Vec<_>>());
    reader.end(params);
    Ok(())
}

pub fn sampler(params: &Params, reader: &mut Reader) -> Result<()> {
    let count = params.integer_or("pixelsamples", 16)?;
    let count = u32::try_from(count).ok().filter(|count| (1..=1 << 31).contains(count));
    reader.made.parts.render.samples =
        count.ok_or_else(|| params.error_at("pixelsamples", "expected 1 to 2147483648"))?;
    params.ignore(&["seed", "randomization", "xsamples", "ysamples", "jitter"]);
    reader.end(params);
    Ok(())
}
