//! Denoising by Intel's Open Image Denoise, a library that is loaded at run time and not needed for building.

mod library;

use std::ffi::OsString;
use std::path::{Path, PathBuf};

use crate::data::{Rgb, luminance};
use crate::error::{Error, Result};
use library::{FILE, Library, MAJOR};

/// Names the folder of the library where no option does.
pub const VARIABLE: &str = "OIDN_DIR";

/// An image with noise, row 0 on top, and what is known of its surfaces. All have the same size.
#[derive(Debug)]
pub struct Noisy {
    pub size: (u32, u32),
    /// Linear radiance.
    pub rgb: Vec<Rgb<f32>>,
    /// The albedo of the first rough surface, from 0 to 1, with its own noise.
    pub albedo: Option<Vec<Rgb<f32>>>,
    /// The normal there, with its own noise. The library takes it only with an albedo.
    pub normal: Option<Vec<Rgb<f32>>>,
}

/// The guides of the denoiser: an albedo and a normal without noise.
#[derive(Debug)]
pub struct Guides {
    size: (usize, usize),
    albedo: Option<Vec<Rgb<f32>>>,
    normal: Option<Vec<Rgb<f32>>>,
}

/// The library, ready for use. It runs on the processor: that is everywhere, takes a second, and needs no memory of the GPU that renders.
pub struct Denoiser(Library);

impl Denoiser {
    /// Loads the library from a folder, from that of the environment, or from where the system finds it.
    ///
    /// # Errors
    /// `Error::Denoiser`, which says how to get the library.
    pub fn open(folder: Option<&Path>) -> Result<Denoiser> {
        let of_environment = || std::env::var_os(VARIABLE).filter(|value| !value.is_empty()).map(PathBuf::from);
        let folder = folder.map(Path::to_owned).or_else(of_environment);
        let file = match &folder {
            Some(folder) => in_folder(folder)?,
            None => OsString::from(FILE),
        };
        let failed = |reason| Error::Denoiser(format!("{}: {reason}. {}", file.display(), how_to_get_it()));
        Library::load(&file).map(Denoiser).map_err(failed)
    }

    /// Its name and version.
    pub fn name(&self) -> String {
        format!("Open Image Denoise {}", self.0.version)
    }

    /// The image without its noise, as far as the library can distinguish noise from detail. Values that are not finite or negative count as 0; all
    /// values of the result are finite, and none is negative.
    ///
    /// # Errors
    /// `Error::Denoiser` with the library's words.
    pub fn denoise(&self, noisy: &Noisy) -> Result<Vec<Rgb<f32>>> {
        self.denoise_by(&noisy.rgb, &self.guides(noisy)?)
    }

    /// The albedo and the normal without their noise, each by itself. They are then exact enough that the image keeps all of their edges.
    ///
    /// # Errors
    /// As of [`Denoiser::denoise`].
    pub fn guides(&self, noisy: &Noisy) -> Result<Guides> {
        let size = (noisy.size.0 as usize, noisy.size.1 as usize);
        let clean = |name, image: &[Rgb<f32>]| {
            let image = finite(image, |v| v);
            self.0.filter(size, &[(name, &image)], &[]).map_err(|reason| self.failed(&reason))
        };
        let albedo = noisy.albedo.as_ref().map(|image| clean(c"albedo", image)).transpose()?;
        let normal =
            noisy.normal.as_ref().filter(|_| albedo.is_some()).map(|image| clean(c"normal", image)).transpose()?;
        Ok(Guides { size, albedo, normal })
    }

    /// Radiance without its noise, such as the image's, or that of some of its lights.
    ///
    /// # Errors
    /// As of [`Denoiser::denoise`].
    pub fn denoise_by(&self, radiance: &[Rgb<f32>], guides: &Guides) -> Result<Vec<Rgb<f32>>> {
        let Guides { size, albedo, normal } = guides;
        // The library takes darkness below 1e-8 for black. A factor of a power of two makes the result independent of the unit of radiance.
        let scale = scale_of(radiance);
        let rgb = finite(radiance, |v| (f64::from(v.max(0.0)) * scale) as f32);
        let mut images = vec![(c"color", rgb.as_slice())];
        images.extend(albedo.iter().map(|image| (c"albedo", image.as_slice())));
        images.extend(normal.iter().map(|image| (c"normal", image.as_slice())));
        let parameters = if albedo.is_some() { &[c"hdr", c"cleanAux"][..] } else { &[c"hdr"] };
        let mut denoised = self.0.filter(*size, &images, parameters).map_err(|reason| self.failed(&reason))?;
        let values = denoised.as_flattened_mut();
        if let Some(value) = values.iter().find(|v| !v.is_finite() || **v < 0.0) {
            return Err(self.failed(&format!("a pixel of its result is {value}")));
        }
        // Values that are too large for f32 are f32::MAX, as in the image of a render.
        values.iter_mut().for_each(|v| *v = ((f64::from(*v) / scale) as f32).min(f32::MAX));
        Ok(denoised)
    }

    fn failed(&self, reason: &str) -> Error {
        Error::Denoiser(format!("{} has failed: {reason}", self.name()))
    }
}

/// The image with a change to its values, and 0 for those that are not finite.
fn finite(image: &[Rgb<f32>], change: impl Fn(f32) -> f32) -> Vec<Rgb<f32>> {
    image.iter().map(|rgb| rgb.map(|v| if v.is_finite() { change(v) } else { 0.0 })).collect()
}

/// The power of two that brings the mean luminance near 1.
fn scale_of(image: &[Rgb<f32>]) -> f64 {
    let values =
        image.iter().map(|rgb| luminance(rgb.map(|v| if v.is_finite() { f64::from(v.max(0.0)) } else { 0.0 })));
    let mean = values.sum::<f64>() / image.len() as f64;
    if mean > 0.0 { (-mean.log2().round()).exp2() } else { 1.0 }
}

/// The library in a folder, or in the folder of it where installed packages have it.
fn in_folder(folder: &Path) -> Result<OsString> {
    let candidates = [folder.join(FILE), folder.join("lib").join(FILE), folder.join("bin").join(FILE)];
    let found = candidates.into_iter().find(|path| path.is_file());
    found.map(PathBuf::into_os_string).ok_or_else(|| {
        let name = folder.display();
        Error::Denoiser(format!("{name}: neither it nor its folder lib or bin has {FILE}. {}", how_to_get_it()))
    })
}

/// How to get the library, in words.
fn how_to_get_it() -> String {
    format!(
        "Denoising needs Intel's Open Image Denoise {MAJOR}. `pip install --target oidn pyoidn==2.5.1` puts it into a folder: then give \
         --oidn oidn/pyoidn/oidn/lib, or set {VARIABLE} to that folder. Packages with it are oidn (Fedora), openimagedenoise (Arch) and \
         open-image-denoise (Homebrew); https://www.openimagedenoise.org has the library for every system"
    )
}
