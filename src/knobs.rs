//! The settings of a render that trade one thing for another, each declared once: `--help`, what a render says of itself, and
//! whatever measures the trade take their words and values from here.

/// What a setting other than the default gives up.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Class {
    /// Nothing: the image is the same to the byte.
    Exact,
    /// More noise, or more time; what the image converges to is the same.
    Noise,
    /// Some of the image's pixels; each that is left converges to the mean over what it shows.
    Detail,
    /// What the image converges to is another one.
    Bias,
    /// The same image, but for the rounding of f32: right in ordinary scenes, wrong at the extremes of scale.
    Numerics,
}

impl Class {
    /// The heading in `--help` under which the settings stand.
    pub const fn heading(self) -> &'static str {
        match self {
            Class::Exact => "Speed (the image stays the same to the byte)",
            Class::Noise => "Noise (the expectation stays the same)",
            Class::Detail => "Detail (fewer pixels, each of them right)",
            Class::Bias => "Bias (each biases the result; off by default)",
            Class::Numerics => "Numerics (wrong at the extremes of scale; off by default)",
        }
    }
}

/// A setting that trades one thing for another.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Knob {
    /// The option's name, without dashes.
    pub name: &'static str,
    /// What it is.
    pub about: &'static str,
    /// Values to sweep over, as the option takes them.
    pub values: &'static [&'static str],
    /// The value where none is given; nothing where that is the scene's own.
    pub default: Option<&'static str>,
    pub class: Class,
    /// What its values other than the default give up, in a sentence.
    pub gives_up: &'static str,
}

impl Knob {
    /// For `--help`.
    pub fn help(&self) -> String {
        format!("{} {}", self.about, self.gives_up)
    }

    /// What a render says where the knob has a value that biases or is less exact.
    pub fn warning(&self, value: &str) -> String {
        let option = self.option(value);
        match self.class {
            Class::Bias => format!("{option} biases the result"),
            Class::Numerics => format!("{option} is wrong at the extremes of scale"),
            Class::Exact | Class::Noise | Class::Detail => option,
        }
    }

    /// The option as it is given: `--clamp 10`.
    pub fn option(&self, value: &str) -> String {
        format!("--{} {value}", self.name)
    }
}

pub const SPP: Knob = Knob {
    name: "spp",
    about: "Samples per pixel [default: the scene's].",
    values: &["1", "4", "16", "64", "256"],
    default: None,
    class: Class::Noise,
    gives_up: "Fewer are noisier: a quarter of them at about twice the error.",
};

pub const SIZE: Knob = Knob {
    name: "size",
    about: "Image size in pixels, or in percent of the scene's [default: the scene's].",
    values: &["25%", "50%", "100%"],
    default: None,
    class: Class::Detail,
    gives_up: "Fewer pixels give up detail: each is the mean over a larger square.",
};

pub const INTEGRATOR: Knob = Knob {
    name: "integrator",
    about: "How light is found: `mis` also sends rays to the lights that there are; `bsdf` follows the scattered rays alone until they meet one.",
    values: &["mis", "bsdf"],
    default: Some("mis"),
    class: Class::Noise,
    gives_up: "A path costs less by `bsdf`, and is noisier the smaller the lights.",
};

pub const ROULETTE: Knob = Knob {
    name: "roulette",
    about: "Russian roulette: paths that have become dark are ended at random, and those that go on count for them.",
    values: &["on", "off"],
    default: Some("on"),
    class: Class::Noise,
    gives_up: "Off, every path is followed to its end: less noise a path, and more time.",
};

pub const SAMPLER: Knob = Knob {
    name: "sampler",
    about: "How samples are placed: `sobol` spreads those of a pixel evenly, `independent` draws each by itself.",
    values: &["sobol", "independent"],
    default: Some("sobol"),
    class: Class::Noise,
    gives_up: "Independent samples are noisier where pixels are smooth, and tell their own error better.",
};

pub const MAX_DEPTH: Knob = Knob {
    name: "max-depth",
    about: "Scattering events of a path at most [default: the scene's].",
    values: &["1", "2", "4", "8", "16"],
    default: None,
    class: Class::Bias,
    gives_up: "Fewer than the scene's own biases the result: light that took longer ways is missing.",
};

pub const FRESNEL: Knob = Knob {
    name: "fresnel",
    about: "Reflection of clear solids: exact, or by Schlick's approximation.",
    values: &["exact", "schlick"],
    default: Some("exact"),
    class: Class::Bias,
    gives_up: "`schlick` biases the result: reflectances are off by up to 0.04 at an index of 1.5, 0.2 at 1.1, and 1 next to an index of 1.",
};

pub const CLAMP: Knob = Knob {
    name: "clamp",
    about: "The most radiance that a path may bring of light which took two scattering events or more, in the scene's units.",
    values: &["off", "1", "10", "100"],
    default: Some("off"),
    class: Class::Bias,
    gives_up: "A limit biases the result: rare bright paths, such as those of caustics, lose what is above it.",
};

pub const OFFSET: Knob = Knob {
    name: "offset",
    about: "How far off a surface rays start: `robust` by each shape's own bound of its rounding, `fast` by a fraction of the distance.",
    values: &["robust", "fast"],
    default: Some("robust"),
    class: Class::Numerics,
    gives_up: "`fast` loses the inside and the contacts of what is smaller than 1/16384 of its distance, and a huge shape close by shadows itself; no time saved was measured.",
};

pub const PRECISION: Knob = Knob {
    name: "precision",
    about: "How spheres are met: `strict` keeps the digits of small ones far away, `fast` is the quadratic formula of textbooks.",
    values: &["strict", "fast"],
    default: Some("strict"),
    class: Class::Numerics,
    gives_up: "`fast` is wrong about the edge of spheres that are hundreds of their radii away, and all over them from some thousands on.",
};

pub const BUILD: Knob = Knob {
    name: "build",
    about: "How long the hierarchies over meshes and objects may take to build, for how fast rays find their way through them.",
    values: &["fast", "medium", "best"],
    default: Some("medium"),
    class: Class::Exact,
    gives_up: "`fast` starts earlier and renders slower, `best` the reverse.",
};

/// All of them, those first that are the first to be measured where time is short.
pub const KNOBS: &[&Knob] =
    &[&SPP, &INTEGRATOR, &SAMPLER, &ROULETTE, &MAX_DEPTH, &FRESNEL, &CLAMP, &BUILD, &OFFSET, &PRECISION, &SIZE];
