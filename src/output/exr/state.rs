//! The state of a render in its image file: what it takes to go on, or to join the file with others.
//!
//! The exact totals of the pixels are a part of the file. An attribute of that part describes the rest as JSON.

use std::path::{Path, PathBuf};

use ::exr::meta::attribute::SampleType;
use ::exr::meta::header::Header;
use serde::{Deserialize, Serialize};

use super::attribute::{Attribute, CHECKSUM, STATE, attribute_text, checksum, decoded};
use super::read::{Opened, attributes_of, open, pixels_of, read_part};
use crate::aov::{Aovs, SceneSpace};
use crate::data::{LampPixel, SampleVariance, Sampler};
use crate::error::{Error, Result};
use crate::film::{Accumulation, Bound, Film, Totals, add_devices, sample_variance_of, word_names};
use crate::identity::Identity;
use crate::job::Frame;
use crate::samples::Samples;

/// The description of a film with which a render goes on: its image, its samples, and its form. In files as JSON, but for the size.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct State {
    format: u32,
    pub identity: Identity,
    /// The devices and drivers that have rendered it.
    pub devices: Vec<(String, String)>,
    /// The samples that each pixel has.
    pub samples: Samples,
    /// The number of times that `--noise` has compared the error with the requested one.
    #[serde(rename = "looks")]
    pub checks: u32,
    /// The size, the scale and the sampler of the film.
    #[serde(skip)]
    pub size: (u32, u32),
    pub exponent: i32,
    pub sampler: Sampler,
    /// The space in which the kernels see the scene, if there are channels of `--aov`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub space: Option<SceneSpace>,
    /// Whether the film has sums of light paths.
    pub light_paths: bool,
    /// The groups of lights that the film has sums of.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub light_groups: Vec<String>,
    /// The largest radiance of what is not sampled as a light, in device units. States of before do not have it.
    #[serde(default)]
    not_sampled: Option<f64>,
    /// The pixels that lamps cover in part. States of before do not have them.
    #[serde(default)]
    lamps: Vec<LampPixel>,
    pub totals: Totals,
    /// The checksum of all words of all pixels.
    checksum: u32,
}

/// The version of the format. A reader refuses others. Format 1 had no checksum of the header.
const FORMAT: u32 = 2;

impl State {
    /// The state of a film.
    pub fn new(identity: Identity, film: &Accumulation) -> State {
        let Accumulation { film, samples, checks, devices } = film;
        State {
            format: FORMAT,
            identity,
            devices: devices.clone(),
            samples: samples.clone(),
            checks: *checks,
            size: (film.width(), film.height()),
            exponent: film.exponent,
            sampler: film.sampler,
            space: film.space(),
            light_paths: film.has_light_paths(),
            light_groups: film.aovs().groups().to_vec(),
            not_sampled: Some(film.bound.not_sampled),
            lamps: film.bound.lamps.clone(),
            totals: film.totals,
            checksum: 0,
        }
    }

    /// An empty film for it.
    pub fn film(&self) -> Result<Accumulation> {
        let film = Film::with_sampler(self.size.0, self.size.1, self.exponent, self.sampler)?;
        // Before that was noted: the brightest of all, if lights were not sampled.
        let brightest = if self.identity.samples_lights() { 0.0 } else { 1.0 };
        let film = film.of_part(self.frame());
        let mut film = film.with_channels(&self.aovs(), self.space.unwrap_or_default(), self.light_paths)?;
        film.bound = Bound { not_sampled: self.not_sampled.unwrap_or(brightest), lamps: self.lamps.clone() };
        Ok(Accumulation::empty(film))
    }

    /// The channels of `--aov`.
    fn aovs(&self) -> Aovs {
        self.identity.aovs().of_groups(&self.light_groups)
    }

    /// The part of the image that its pixels are of.
    fn frame(&self) -> Frame {
        self.identity.frame(self.size).unwrap_or(Frame::full(self.size))
    }

    /// Why the pixels of another one cannot be added to its own, in words; nothing where they can. `mine` and `theirs` name the two. Drivers
    /// may differ.
    pub fn difference(&self, mine: &str, other: &State, theirs: &str) -> Option<String> {
        let of_film = |state: &State| (state.size, state.exponent, state.sampler);
        let difference = self.identity.difference(mine, &other.identity, theirs);
        difference.or((of_film(self) != of_film(other)).then(|| "their films differ".to_string()))
    }

    /// The text of the state in the file, for pixels with this checksum.
    pub(super) fn describe(&self, checksum: u32) -> String {
        serde_json::json!(State { checksum, ..self.clone() }).to_string()
    }

    /// The state that the part `header` describes. `picture` is the header of the first part.
    fn of_header(header: &Header, picture: &Header) -> std::result::Result<State, String> {
        let wrong = |what: &str| format!("its state is damaged: {what}");
        let attributes = attributes_of(header);
        let about = attribute_text(&attributes, STATE);
        if about.is_empty() {
            return Err(wrong("it does not say what it is of"));
        }
        let read = serde_json::from_str::<serde_json::Value>(&about).map_err(|error| wrong(&error.to_string()))?;
        match &read["format"] {
            format if format.as_u64() == Some(u64::from(FORMAT)) => {}
            format => {
                return Err(format!(
                    "its state has the format {format}, and this version of gpu-rt reads {FORMAT}: only the version that wrote it goes on with it"
                ));
            }
        }
        if attribute_text(&attributes, CHECKSUM) != checksum(&about, &picture.own_attributes) {
            return Err("its header is damaged: the state, or attributes of gpu-rt, are not those that were written"
                .to_string());
        }
        let state: State = serde_json::from_value(read).map_err(|error| wrong(&error.to_string()))?;
        let size = |length: usize| u32::try_from(length).map_err(|_| wrong("its size is not supported"));
        Ok(State { size: (size(header.layer_size.0)?, size(header.layer_size.1)?), ..state })
    }
}

/// The number of the part that holds the state: the one that has its name or its attribute, so that damage of one of them is no file without a
/// state, which a render would begin anew.
fn state_part(headers: &[Header]) -> Option<usize> {
    let name = |header: &Header| header.own_attributes.layer_name.as_ref().map(decoded);
    let has = |header: &Header| header.own_attributes.other.keys().any(|name| name.as_slice() == STATE.as_bytes());
    headers.iter().position(|header| name(header).as_deref() == Some(STATE) || has(header))
}

/// An open file with a state. Its contents are consistent, even if the file is replaced meanwhile.
pub struct StateFile {
    pub state: State,
    path: PathBuf,
    opened: Opened,
    /// The number of the part that holds the state.
    part: usize,
}

impl StateFile {
    /// Opens a file and reads its header; nothing where it has no state.
    ///
    /// # Errors
    /// `Error::File` where it cannot be read or is damaged.
    pub fn open(path: &Path) -> Result<Option<StateFile>> {
        let opened = open(path).map_err(Error::file(path, "read"))?;
        let headers = opened.headers();
        let Some(part) = state_part(headers) else { return Ok(None) };
        let state = State::of_header(&headers[part], &headers[0]).map_err(Error::file(path, "read"))?;
        Ok(Some(StateFile { state, path: path.to_owned(), opened, part }))
    }

    /// The attributes of the picture.
    pub fn attributes(&self) -> Vec<(String, Attribute)> {
        self.opened.headers().first().map_or(Vec::new(), attributes_of)
    }

    /// Adds its samples to a film of the same image. It takes memory for some rows.
    ///
    /// # Errors
    /// `Error::File` where they cannot be read, or are not those that were written. The film may then have a part of them.
    pub fn add_to(self, to: &mut Accumulation) -> Result<()> {
        let StateFile { state, path, opened, part } = self;
        to.film.add([], state.totals);
        let names = to.film.word_names();
        read_pixels(opened, part, &state, &names, |pixel, words| to.film.add_words(pixel, words))
            .map_err(Error::file(&path, "read"))?;
        to.samples.join(&state.samples);
        to.checks = to.checks.saturating_add(state.checks);
        add_devices(&mut to.devices, &state.devices);
        Ok(())
    }

    /// The variance of the samples of each pixel, row 0 on top.
    ///
    /// # Errors
    /// `Error::File` where they cannot be read, or are not those that were written.
    pub fn sample_variances(self) -> Result<Vec<SampleVariance>> {
        let StateFile { state, path, opened, part } = self;
        let count =
            pixels_of(&opened.headers()[part], size_of::<SampleVariance>()).map_err(Error::file(&path, "read"))?;
        let mut sample_variances = Vec::with_capacity(count);
        let has_light_paths = state.light_paths;
        let names = word_names(&state.aovs(), has_light_paths);
        let light_paths = has_light_paths.then(|| state.totals.light_paths_of_a_pixel(state.frame().full));
        let add = |_, words: &[u16]| sample_variances.push(sample_variance_of(words, state.exponent, light_paths));
        read_pixels(opened, part, &state, &names, add).map_err(Error::file(&path, "read"))?;
        Ok(sample_variances)
    }
}

/// Reads the state of a file, but for its pixels; nothing where it has none.
///
/// # Errors
/// `Error::File` where it cannot be read or is damaged.
pub fn read_state(path: &Path) -> Result<Option<State>> {
    Ok(StateFile::open(path)?.map(|file| file.state))
}

/// Adds the samples of a file to a film of the same image, as [`StateFile::add_to`] does. The state is that which was read
/// before.
///
/// # Errors
/// `Error::File` where they cannot be read, or are not those of the state. The film may then have a part of them.
pub fn add_film(path: &Path, state: &State, film: &mut Accumulation) -> Result<()> {
    let changed = || Error::file(path, "read")("it has changed while it was read");
    let file = StateFile::open(path)?.ok_or_else(changed)?;
    StateFile { state: state.clone(), ..file }.add_to(film)
}

/// Hands out the words of all pixels, which have these names, in the order of the image.
fn read_pixels(
    opened: Opened,
    part: usize,
    state: &State,
    names: &[String],
    mut use_pixel: impl FnMut(usize, &[u16]),
) -> std::result::Result<(), String> {
    let header = &opened.headers()[part];
    let (width, height) = (state.size.0 as usize, state.size.1 as usize);
    if (header.layer_size.0, header.layer_size.1) != (width, height) {
        return Err("it has changed while it was read".to_string());
    }
    let word = |name: String| names.iter().position(|known| *known == name);
    let words: Option<Vec<usize>> = header.channels.list.iter().map(|channel| word(channel.name.to_string())).collect();
    let plain = header.channels.list.iter().all(|channel| channel.sample_type == SampleType::F16);
    let words = words.filter(|_| plain).ok_or("its state is damaged: it has channels of another kind")?;
    let mut checksum = crc32fast::Hasher::new();
    // The channels of a row come one after another.
    let mut row: Vec<u16> = Vec::new();
    let count = width * names.len();
    row.try_reserve_exact(count).map_err(|_| "its rows are longer than the memory".to_string())?;
    row.resize(count, 0);
    let mut next = (0, 0);
    let mut in_order = true;
    read_part(opened, part, |channel, (column, line), bytes| {
        in_order &= (line, channel) == next && column == 0 && bytes.len() == 2 * width;
        if !in_order {
            return;
        }
        let values = bytes.as_chunks().0.iter().map(|word| u16::from_ne_bytes(*word));
        row.chunks_exact_mut(names.len()).zip(values).for_each(|(pixel, value)| pixel[words[channel]] = value);
        next = (line, channel + 1);
        if next.1 == words.len() {
            for (pixel, words) in row.chunks_exact_mut(names.len()).enumerate() {
                use_pixel(line * width + pixel, words);
                words.iter_mut().for_each(|word| *word = word.to_le());
                checksum.update(bytemuck::cast_slice(words));
                words.iter_mut().for_each(|word| *word = u16::from_le(*word));
            }
            next = (line + 1, 0);
        }
    })?;
    if !in_order || next != (height, 0) {
        return Err("its state is damaged: rows are missing".to_string());
    }
    match checksum.finalize() == state.checksum {
        true => Ok(()),
        false => Err("its state is damaged: the totals of its pixels are not those that were written".to_string()),
    }
}
