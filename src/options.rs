//! The options of a render, each declared once: its name, its values and how they are read, its words for `--help`, and its trade-off.
//! Their values are facts for the heads of shaders (src/plan/facts.rs). The command line, what a render says of itself, `plan` and `tradeoff` read this table.

use std::collections::BTreeMap;
use std::fmt::Display;

use clap::builder::{PossibleValue, PossibleValuesParser, Resettable};
use clap::{Arg, ArgMatches, Command, ValueEnum};

use crate::aov::{Aovs, ChannelNames, SeenSurface};
use crate::bvh::Quality;
use crate::data::{RUN_LENGTH, Sampler};

/// The options of a render, without its scene and its job. The default is that of the command line.
#[derive(Clone, Debug, PartialEq)]
pub struct RenderOptions {
    pub integrator: Integrator,
    pub roulette: Switch,
    pub sampler: Sampler,
    pub filter: Filter,
    pub fresnel: Fresnel,
    /// The most indirect radiance that a path may add, in scene units; `None` for no limit.
    pub clamp: Option<f64>,
    pub light_paths: LightPaths,
    pub precision: Precision,
    pub build: Quality,
    /// For tests and benchmarks: no option of the program, and the bytes are the same.
    pub walk: Walk,
    pub aov: Aovs,
    pub features: FeatureSet,
    /// This and the next three are the device's choice where absent.
    pub scatter: Option<Scatter>,
    /// Paths in flight.
    pub slots: Option<u32>,
    /// Invocations of a workgroup.
    pub workgroup: Option<u32>,
    /// Bounces of a submission.
    pub bounces: Option<u32>,
}

impl Default for RenderOptions {
    fn default() -> RenderOptions {
        RenderOptions {
            integrator: Integrator::Mis,
            roulette: Switch::On,
            sampler: Sampler::Sobol,
            filter: Filter::Box,
            fresnel: Fresnel::Exact,
            clamp: None,
            light_paths: LightPaths::Auto,
            precision: Precision::Strict,
            build: Quality::Medium,
            walk: Walk::Coded,
            aov: Aovs::default(),
            features: FeatureSet::Scene,
            scatter: None,
            slots: None,
            workgroup: None,
            bounces: None,
        }
    }
}

impl RenderOptions {
    /// The options that bias the result or are less exact, with their values.
    pub fn biases(&self) -> impl Iterator<Item = (&'static OptionSpec, String)> {
        let biased = TRADE_OFFS.iter().filter(|spec| matches!(spec.class, Class::Bias | Class::Numerics));
        biased.filter(|spec| !spec.is_default(self)).filter_map(|spec| Some((*spec, spec.value(self)?)))
    }

    /// The options that change the image, by their names, with their values.
    pub fn of_image(&self) -> impl Iterator<Item = (&'static str, String)> {
        // Without channels of `--aov`, their settings do not matter.
        let counts = |spec: &&OptionSpec| match spec.class {
            Class::Exact => false,
            Class::Channels => !self.aov.is_empty() && !spec.is_default(self),
            _ => true,
        };
        let known = all().filter(counts).filter(|spec| spec.reading.is_some());
        known.map(|spec| (spec.name, spec.value(self).unwrap_or_else(|| "none".to_string())))
    }

    /// The options that settings name as [`RenderOptions::of_image`] does. What cannot be read has its default.
    pub fn of_settings(settings: &BTreeMap<String, String>) -> RenderOptions {
        let mut options = RenderOptions::default();
        for (reading, text) in all().filter_map(|spec| Some((spec.reading?, settings.get(spec.name)?))) {
            _ = (reading.read)(&mut options, text);
        }
        options
    }

    /// The options that are not at their defaults, as words of the command line.
    pub fn words(&self) -> Vec<String> {
        let known = all().filter(|spec| !spec.is_default(self));
        known.filter_map(|spec| Some([format!("--{}", spec.name), spec.value(self)?])).flatten().collect()
    }

    /// The names of all options that [`RenderOptions`] holds.
    pub fn names() -> Vec<&'static str> {
        all().filter(|spec| spec.reading.is_some()).map(|spec| spec.name).collect()
    }
}

/// An option whose values are words.
pub trait Word: ValueEnum {
    /// How the command line spells it.
    fn word(&self) -> String {
        self.to_possible_value().map_or(String::new(), |value| value.get_name().to_string())
    }

    fn read(text: &str) -> Result<Self, String> {
        Self::from_str(text, false).map_err(|_| "expected another word".to_string())
    }

    /// All words, without help of their own.
    fn all() -> Vec<PossibleValue> {
        let values = Self::value_variants().iter().filter_map(Self::to_possible_value);
        values.map(|value| value.help(Resettable::Reset)).collect()
    }
}

impl<W: ValueEnum> Word for W {}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Switch {
    On,
    Off,
}

/// How rays walk through meshes (docs/gpu.md).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Walk {
    /// Nodes name each of their children by a code.
    Coded,
    /// Nodes name the place of their first child, beside which the others stand. Fewer registers are in use at a time.
    Siblings,
}

/// How paths find light.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Integrator {
    /// BSDF sampling and light sampling, combined by multiple importance sampling.
    Mis,
    /// BSDF sampling only.
    Bsdf,
}

/// What a pixel is the mean over: how samples are spread around its middle.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Filter {
    /// Uniform over its square.
    Box,
    /// A tent two pixels wide.
    Tent,
    /// A Gaussian of half a pixel, cut off at 1.5 pixels.
    Gauss,
    /// The cubic of Mitchell and Netravali, four pixels wide, with negative lobes.
    Mitchell,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Fresnel {
    Exact,
    Schlick,
}

/// The light paths of a run of eight samples.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LightPaths {
    /// As many as the scene and the other options are worth.
    Auto,
    Off,
    /// 1 to [`MOST_LIGHT_PATHS`].
    Count(u32),
}

/// The most light paths of a run: one for each of its samples.
pub const MOST_LIGHT_PATHS: u32 = RUN_LENGTH;

impl LightPaths {
    /// The light paths of a run. `Auto` has none until the scene has decided.
    pub fn count(self) -> u32 {
        match self {
            LightPaths::Auto | LightPaths::Off => 0,
            LightPaths::Count(count) => count,
        }
    }

    fn read(text: &str) -> Result<LightPaths, String> {
        match text {
            "auto" => Ok(LightPaths::Auto),
            "off" => Ok(LightPaths::Off),
            _ => number(text, 1..=MOST_LIGHT_PATHS)
                .map(LightPaths::Count)
                .map_err(|_| format!("expected `auto`, `off` or a whole number from 1 to {MOST_LIGHT_PATHS}")),
        }
    }
}

impl Display for LightPaths {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            LightPaths::Auto => f.write_str("auto"),
            LightPaths::Off => f.write_str("off"),
            LightPaths::Count(count) => write!(f, "{count}"),
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Precision {
    Strict,
    Fast,
}

/// What kernels are linked with. The image is the same.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum FeatureSet {
    /// Just what the scene requires.
    Scene,
    /// Everything that a scene can require.
    All,
}

/// How the stages of a bounce are linked into kernels. The image does not depend on it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Scatter {
    /// Intersect, scatter and refill in one kernel that does several bounces a dispatch.
    Fused,
    /// A kernel a stage; scatter is one kernel for all materials, an invocation a slot.
    Linked,
    /// A kernel a stage, and of scatter a kernel and a queue for each material.
    Queues,
}

/// What an option's values other than the default give up.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Class {
    /// Nothing: the image is the same to the byte.
    Exact,
    /// More noise, or more time; what the image converges to is the same.
    Noise,
    /// Some of the image's pixels; each that is left converges to the mean over what it shows.
    Detail,
    /// Nothing: what a pixel is the mean over is a matter of taste.
    Look,
    /// What the image converges to is another one.
    Bias,
    /// Nothing: the picture is the same to the byte, and the file has further channels.
    Channels,
    /// An image that differs by the rounding of f32: right in ordinary scenes, wrong at the extremes of scale.
    Numerics,
}

impl Class {
    /// The heading in `--help` under which the options stand.
    pub const fn heading(self) -> &'static str {
        match self {
            Class::Exact => "Speed (the image stays the same to the byte)",
            Class::Noise => "Noise (the expectation stays the same)",
            Class::Detail => "Detail (fewer pixels, each of them right)",
            Class::Look => "Look (the reconstruction filter)",
            Class::Channels => "More channels (the picture keeps its bytes)",
            Class::Bias => "Bias (each biases the result; off by default)",
            Class::Numerics => "Numerics (wrong at the extremes of scale; off by default)",
        }
    }
}

/// The declaration of an option.
#[derive(Clone, Copy, Debug)]
pub struct OptionSpec {
    /// The option's name, without dashes.
    pub name: &'static str,
    /// What it is.
    pub about: &'static str,
    /// Values that `tradeoff` sweeps over, as the option takes them.
    pub values: &'static [&'static str],
    /// The value where none is given; nothing where the scene or the device has one.
    pub default: Option<&'static str>,
    pub class: Class,
    /// What its values other than the default give up, in a sentence.
    pub trade_off: &'static str,
    /// How its value gets into [`RenderOptions`]; `None` for an option that a command has by itself.
    reading: Option<Reading>,
    /// Whether `--help` leaves it out.
    is_hidden: bool,
}

/// All words of an option.
type Words = fn() -> Vec<PossibleValue>;

/// How a value is parsed and written.
#[derive(Clone, Copy, Debug)]
struct Reading {
    /// The name of its value in `--help`, and its words, if it takes only these.
    takes: (&'static str, Option<Words>),
    read: fn(&mut RenderOptions, &str) -> Result<(), String>,
    /// The value; nothing where it is left to the device.
    value: fn(&RenderOptions) -> Option<String>,
}

/// The reading of a field of [`RenderOptions`] whose values are words.
macro_rules! word {
    ($($field:ident).+: $type:ty) => {
        Some(Reading {
            takes: ("WORD", Some(<$type>::all)),
            read: |options, text| <$type>::read(text).map(|value| options.$($field).+ = value),
            value: |options| Some(options.$($field).+.word()),
        })
    };
}

/// The reading of a number in a range. The device chooses it where it is not given.
macro_rules! number {
    ($field:ident: $range:expr) => {
        Some(Reading {
            takes: ("N", None),
            read: |options, text| number(text, $range).map(|value| options.$field = Some(value)),
            value: |options| options.$field.map(|value| value.to_string()),
        })
    };
}

impl OptionSpec {
    /// For `--help`.
    pub fn help(&self) -> String {
        format!("{} {}", self.about, self.trade_off).trim_end().to_string()
    }

    /// What a render says where the option has a value that biases or is less exact.
    pub fn warning(&self, value: &str) -> String {
        let option = self.option(value);
        match self.class {
            Class::Bias => format!("{option} biases the result"),
            Class::Numerics => format!("{option} is wrong at the extremes of scale"),
            Class::Exact | Class::Noise | Class::Detail | Class::Look | Class::Channels => option,
        }
    }

    /// The option as it is given: `--clamp 10`.
    pub fn option(&self, value: &str) -> String {
        format!("--{} {value}", self.name).trim_end().to_string()
    }

    /// Whether the option has its default value.
    pub fn is_default(&self, options: &RenderOptions) -> bool {
        self.default == self.value(options).as_deref()
    }

    /// The option as it was given, for the reasons of a plan: `--roulette on, the default`.
    pub fn as_given(&self, options: &RenderOptions) -> String {
        let given = self.option(&self.value(options).unwrap_or_default());
        if self.is_default(options) { format!("{given}, the default") } else { given }
    }

    /// Its value; nothing where that is left to the scene or the device.
    pub fn value(&self, options: &RenderOptions) -> Option<String> {
        self.reading.and_then(|reading| (reading.value)(options))
    }

    /// The option for the command line.
    fn arg(&'static self) -> Arg {
        let arg = Arg::new(self.name).long(self.name).help_heading(self.class.heading());
        let arg = arg.help(self.about).long_help(self.help());
        let arg = arg.hide(self.is_hidden);
        let Some(Reading { read, takes: (name, words), .. }) = self.reading else { return arg };
        let check = move |text: &str| read(&mut RenderOptions::default(), text).map(|()| text.to_string());
        let arg = match words {
            Some(words) => arg.value_name(name).value_parser(PossibleValuesParser::new(words())),
            None => arg.value_name(name).value_parser(check),
        };
        match self.default {
            Some(default) => arg.default_value(default),
            None => arg,
        }
    }
}

impl clap::Args for RenderOptions {
    fn augment_args(command: Command) -> Command {
        command.args(all().filter(|spec| spec.reading.is_some()).map(OptionSpec::arg))
    }

    fn augment_args_for_update(command: Command) -> Command {
        RenderOptions::augment_args(command)
    }
}

impl clap::FromArgMatches for RenderOptions {
    fn from_arg_matches(matches: &ArgMatches) -> Result<RenderOptions, clap::Error> {
        let mut options = RenderOptions::default();
        options.update_from_arg_matches(matches)?;
        Ok(options)
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), clap::Error> {
        for (spec, reading) in all().filter_map(|spec| Some((spec, spec.reading?))) {
            if let Some(text) = matches.get_one::<String>(spec.name) {
                let refused = |why| clap::Error::raw(clap::error::ErrorKind::InvalidValue, why);
                (reading.read)(self, text).map_err(refused)?;
            }
        }
        Ok(())
    }
}

/// The default of the option of this name, where it trades something off.
pub fn default_of(name: &str) -> Option<&'static str> {
    TRADE_OFFS.iter().find(|spec| spec.name == name)?.default
}

/// An integer of a range.
fn number(text: &str, range: std::ops::RangeInclusive<u32>) -> Result<u32, String> {
    let known = text.parse().ok().filter(|number| range.contains(number));
    known.ok_or_else(|| format!("expected a whole number from {} to {}", range.start(), range.end()))
}

fn clamp_limit(text: &str) -> Result<Option<f64>, String> {
    match (text, text.parse::<f64>()) {
        ("off", _) => Ok(None),
        (_, Ok(limit)) if limit > 0.0 && limit.is_finite() => Ok(Some(limit)),
        _ => Err("expected `off` or a radiance above 0, such as 10".to_string()),
    }
}

pub const SPP: OptionSpec = OptionSpec {
    name: "spp",
    about: "Samples per pixel [default: the scene's].",
    values: &["1", "4", "16", "64", "256"],
    class: Class::Noise,
    trade_off: "A quarter of the samples has about twice the error.",
    ..PLAIN
};

pub const SIZE: OptionSpec = OptionSpec {
    name: "size",
    about: "Image size in pixels: width and height, or a width that keeps the scene's aspect; or in percent of the scene's [default: the scene's].",
    values: &["25%", "50%", "100%"],
    class: Class::Detail,
    trade_off: "Fewer pixels show less detail: each is the mean over a larger square.",
    ..PLAIN
};

pub const INTEGRATOR: OptionSpec = OptionSpec {
    name: "integrator",
    about: "How paths find light: `mis` combines light sampling and BSDF sampling (power heuristic); `bsdf` uses BSDF sampling only.",
    values: &["mis", "bsdf"],
    default: Some("mis"),
    class: Class::Noise,
    trade_off: "A `bsdf` path costs less. Its noise grows as the lights get smaller.",
    reading: word!(integrator: Integrator),
    ..PLAIN
};

pub const ROULETTE: OptionSpec = OptionSpec {
    name: "roulette",
    about: "Russian roulette: ends dark paths at random and weights the survivors.",
    values: &["on", "off"],
    default: Some("on"),
    class: Class::Noise,
    trade_off: "Off, every path runs to its end: less noise per path, more time.",
    reading: word!(roulette: Switch),
    ..PLAIN
};

pub const SAMPLER: OptionSpec = OptionSpec {
    name: "sampler",
    about: "How samples are drawn: `sobol` uses Owen-scrambled Sobol points, `independent` uses independent random numbers.",
    values: &["sobol", "independent"],
    default: Some("sobol"),
    class: Class::Noise,
    trade_off: "Independent samples are noisier in smooth pixels, and estimate their own error better.",
    reading: word!(sampler: Sampler),
    ..PLAIN
};

pub const MAX_DEPTH: OptionSpec = OptionSpec {
    name: "max-depth",
    about: "The most scattering events per path [default: the scene's].",
    values: &["1", "2", "4", "8", "16"],
    class: Class::Bias,
    trade_off: "Fewer than the scene's own biases the result: the image lacks the light of longer paths.",
    ..PLAIN
};

pub const CLAMP: OptionSpec = OptionSpec {
    name: "clamp",
    about: "The most indirect radiance (two scattering events or more) that a path may add, in scene units.",
    values: &["off", "1", "10", "100"],
    default: Some("off"),
    class: Class::Bias,
    trade_off: "A limit biases the result: bright rare paths, such as caustics, lose the radiance above it.",
    reading: Some(Reading {
        takes: ("off|N", None),
        read: |options, text| clamp_limit(text).map(|limit| options.clamp = limit),
        value: |options| Some(options.clamp.map_or("off".to_string(), |limit| limit.to_string())),
    }),
    ..PLAIN
};

pub const LIGHT_PATHS: OptionSpec = OptionSpec {
    name: "light-paths",
    about: "Paths from the lights through mirrors and glass, for each run of 8 samples of a pixel: a number from 1 to 8, `off`, or \
            `auto`, which is 1 if lights look small from a mirror or glass, 4 if one has no size, and otherwise off.",
    values: &["auto", "off", "1", "8"],
    default: Some("auto"),
    class: Class::Noise,
    trade_off: "They find caustics, and take time from the other paths.",
    reading: Some(Reading {
        takes: ("auto|off|N", None),
        read: |options, text| LightPaths::read(text).map(|paths| options.light_paths = paths),
        value: |options| Some(options.light_paths.to_string()),
    }),
    ..PLAIN
};

/// It leaves the image as it is, and writes another one beside it. `tradeoff` sweeps it nevertheless.
pub const DENOISE: OptionSpec = OptionSpec {
    name: "denoise",
    about: "Also write NAME.denoised.exr beside NAME.exr, and with --png a picture of it: the final image, denoised by Open Image \
            Denoise. NAME.exr gets the channels albedo and normal.",
    values: &[""],
    class: Class::Bias,
    trade_off: "A denoised image loses detail that looks like noise, which biases the result.",
    ..PLAIN
};

/// The options that trade one thing for another. Where time is short, the first ones are measured first.
pub const TRADE_OFFS: &[&OptionSpec] = &[
    &SPP,
    &INTEGRATOR,
    &SAMPLER,
    &ROULETTE,
    &LIGHT_PATHS,
    &MAX_DEPTH,
    &OptionSpec {
        name: "fresnel",
        about: "Fresnel reflectance of dielectrics: exact, or Schlick's approximation.",
        values: &["exact", "schlick"],
        default: Some("exact"),
        class: Class::Bias,
        trade_off: "`schlick` biases the result: reflectances are off by up to 0.04 at an index of 1.5, 0.2 at 1.1, and 1 next to an index of 1.",
        reading: word!(fresnel: Fresnel),
        ..PLAIN
    },
    &CLAMP,
    &OptionSpec {
        name: "build",
        about: "The quality of the BVH: build time against traversal time.",
        values: &["medium", "best"],
        default: Some("medium"),
        class: Class::Exact,
        trade_off: "`best` builds two to three times as long, and cuts the boxes of long thin faces, which takes memory.",
        reading: word!(build: Quality),
        ..PLAIN
    },
    &OptionSpec {
        name: "precision",
        about: "The ray-sphere intersection: `strict` is accurate for small distant spheres, `fast` is the textbook's quadratic formula.",
        values: &["strict", "fast"],
        default: Some("strict"),
        class: Class::Numerics,
        trade_off: "`fast` is wrong at the edge of spheres hundreds of radii away, and everywhere on spheres thousands of radii away.",
        reading: word!(precision: Precision),
        ..PLAIN
    },
    &SIZE,
    &OptionSpec {
        name: "filter",
        about: "The reconstruction filter: `box` is the pixel's square, `tent` is 2 pixels wide, `gauss` 3, `mitchell` 4.",
        values: &["box", "tent", "gauss", "mitchell"],
        default: Some("box"),
        class: Class::Look,
        trade_off: "`tent` and `gauss` have smoother edges and less detail. `mitchell` has sharper edges; where the filter is negative, \
                    pixels beside a bright edge may be too. Wide filters overlap, but neighbouring pixels have independent noise.",
        reading: word!(filter: Filter),
        ..PLAIN
    },
];

pub const AOV: OptionSpec = OptionSpec {
    name: "aov",
    about: "Further channels of the EXR, with commas between: `albedo`, `normal`, `depth`, `position`, `object`, `material`, `direct`, `indirect`, `lights`, `cryptomatte` \
            (and for glTF `cryptoasset`); and of sample 0 `motion`, `depth0`, `distance0`, `position0`, `normal0`, `uv0`, `face0`, `offset0`.",
    class: Class::Channels,
    reading: Some(Reading {
        takes: ("LIST", None),
        read: |options, text| Aovs::parse(text).map(|list| options.aov.set(list)),
        value: |options| options.aov.words(),
    }),
    ..PLAIN
};

/// The further channels of a file.
const OF_FILES: &[&OptionSpec] = &[
    &AOV,
    &OptionSpec {
        name: "aov-surface",
        about: "The surface that `albedo` and `normal` show: the `first` one, or the first `rough` one, behind mirrors and clear glass, \
                as denoisers want it.",
        default: Some("rough"),
        class: Class::Channels,
        reading: word!(aov.surface: SeenSurface),
        ..PLAIN
    },
    &OptionSpec {
        name: "aov-names",
        about: "How the EXR names its channels: `plain`, or `blender`, like the passes in Blender's multilayer files.",
        default: Some("plain"),
        class: Class::Channels,
        reading: word!(aov.names: ChannelNames),
        ..PLAIN
    },
];

/// What changes the speed and never the image, and is not swept over.
const TUNING: &[&OptionSpec] = &[
    &OptionSpec {
        name: "slots",
        about: "Paths in flight [default: by the device and the image].",
        reading: number!(slots: 1..=1 << 24),
        ..PLAIN
    },
    &OptionSpec {
        name: "workgroup",
        about: "Invocations per workgroup [default: by the device].",
        reading: number!(workgroup: 1..=256),
        ..PLAIN
    },
    &OptionSpec {
        name: "bounces",
        about: "Bounces per submission [default: measured, for about 100 ms].",
        reading: number!(bounces: 1..=4096),
        ..PLAIN
    },
    &OptionSpec {
        name: "scatter",
        about: "How the stages of a bounce become kernels: one kernel for all; one per stage; or one per stage, with a scatter kernel \
                and a queue per material [default: by the device, the scene and the number of paths].",
        reading: Some(Reading {
            takes: ("WORD", Some(Scatter::all)),
            read: |options, text| Scatter::read(text).map(|scatter| options.scatter = Some(scatter)),
            value: |options| options.scatter.as_ref().map(Word::word),
        }),
        ..PLAIN
    },
    &OptionSpec {
        name: "features",
        about: "What kernels contain: only what the scene requires, or everything that any scene can require.",
        default: Some("scene"),
        reading: word!(features: FeatureSet),
        // For tests and `plan`: a render with all features is neither better nor faster.
        is_hidden: true,
        ..PLAIN
    },
];

/// An option that gives nothing up. Each entry says what is different.
const PLAIN: OptionSpec = OptionSpec {
    name: "",
    about: "",
    values: &[],
    default: None,
    class: Class::Exact,
    trade_off: "",
    reading: None,
    is_hidden: false,
};

/// Every option.
fn all() -> impl Iterator<Item = &'static OptionSpec> {
    TRADE_OFFS.iter().chain(OF_FILES).chain(TUNING).copied()
}
