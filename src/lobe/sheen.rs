//! KHR_materials_sheen: fibres such as those of velvet, over the base. Their directional albedo is a table that shaders/lobe/sheen_albedo
//! interpolates.

use std::f64::consts::{PI, TAU};
use std::sync::LazyLock;

use super::kind::{Gltf, Lobe, To, field};
use crate::bitmap::Channel;
use crate::material::declared::pbr::FIELDS;
use crate::material::{LobeWidth, Pbr, Row, RowKind, Sets, Slot, is_zero, varying};
use crate::texture::Use;

const SHEEN: &RowKind = &RowKind::new("sheen", &["roughness"], Sets::Lobe);
const SHEEN_ROUGHNESS: &RowKind = &RowKind::new("sheen_roughness", &[], Sets::Share("lobes.sheen_roughness"));

pub const LOBE: Lobe = Lobe {
    label: Some("pbr sheen"),
    members: &[("sheen", "vec3<f32>"), ("sheen_roughness", "f32")],
    is_layer: true,
    widths: |_, _| vec![LobeWidth::Wide],
    table: Some(sheen_albedos),
    gltf: Some(Gltf {
        extension: "KHR_materials_sheen",
        fields: &[
            field("sheenColorFactor", "sheenColorTexture", To::Colour(0.0, |pbr| &mut pbr.sheen)),
            field(
                "sheenRoughnessFactor",
                "sheenRoughnessTexture",
                To::Share(Channel::A, |pbr| &mut pbr.sheen_roughness),
            ),
        ],
        has_direction: false,
    }),
    ..Lobe::new(&[SHEEN, SHEEN_ROUGHNESS], rows)
};

fn rows(pbr: &Pbr) -> Vec<Row<'_>> {
    if is_zero(&pbr.sheen) {
        return Vec::new();
    }
    let (roughness, varying) = varying(SHEEN_ROUGHNESS, &FIELDS.sheen_roughness, &pbr.sheen_roughness);
    let colour = Slot { field: &FIELDS.sheen, usage: Use::Tint, texture: &pbr.sheen };
    [Row::new(SHEEN, colour, &[roughness])].into_iter().chain(varying).collect()
}

/// Rows are roughnesses, and columns the cosines of the view.
const ROWS: usize = 32;
const COLUMNS: usize = 32;
/// Points of the grid on which the interpolated albedo is held against the true one, for each cell and axis.
const FINER: usize = 2;
/// Midpoints of the integral each way.
const RINGS: u32 = 64;
const SECTORS: u32 = 32;
/// The least roughness, as shaders/lib/charlie has it.
const LEAST_ROUGHNESS: f64 = 0.07;
/// Room for what the points between those of the grid and the integral are off.
const ROOM: f64 = 1.01;

/// The fibres' distribution and visibility: Estevez and Kulla, "Production Friendly Microfacet Sheen BRDF", SIGGRAPH 2017 course, in the form
/// of KHR_materials_sheen.
struct Charlie {
    alpha: f64,
}

impl Charlie {
    fn of_roughness(roughness: f64) -> Charlie {
        Charlie { alpha: roughness.max(LEAST_ROUGHNESS).powi(2) }
    }

    fn density(&self, sine2: f64) -> f64 {
        (2.0 + 1.0 / self.alpha) * sine2.powf(0.5 / self.alpha) / TAU
    }

    fn fit(&self, x: f64) -> f64 {
        let m = (1.0 - self.alpha).powi(2);
        let between = |from: f64, to: f64| from + m * (to - from);
        let (a, b, c) = (between(21.5473, 25.3245), between(3.829_87, 3.324_35), between(0.198_23, 0.168_01));
        let (d, e) = (between(-1.977_60, -1.273_93), between(-4.320_54, -4.859_67));
        a / (1.0 + b * x.powf(c)) + d * x + e
    }

    fn lambda(&self, cosine: f64) -> f64 {
        match cosine < 0.5 {
            true => self.fit(cosine).exp(),
            false => (2.0 * self.fit(0.5) - self.fit(1.0 - cosine)).exp(),
        }
    }

    /// The light that comes back at this cosine, for each of some cosines: an integral over the cosine of the light's square root, in which
    /// grazing light has its room.
    fn albedos(&self, cosines: &[f64]) -> Vec<f64> {
        let rings = (0..RINGS).map(|ring| ((f64::from(ring) + 0.5) / f64::from(RINGS)).powi(2));
        let lights: Vec<(f64, f64)> = rings.map(|cosine| (cosine, self.lambda(cosine))).collect();
        let azimuths: Vec<f64> =
            (0..SECTORS).map(|sector| (PI * (f64::from(sector) + 0.5) / f64::from(SECTORS)).cos()).collect();
        let albedo = |cosine: &f64| {
            let cosine = cosine.max(1e-6);
            let (sine, hidden) = ((1.0 - cosine * cosine).max(0.0).sqrt(), self.lambda(cosine));
            let ring = |(light, lambda): &(f64, f64)| {
                let sine_of_light = (1.0 - light * light).max(0.0).sqrt();
                let height2 = (cosine + light).powi(2);
                let of_azimuth = |azimuth: &f64| {
                    let across2 = sine * sine + sine_of_light * sine_of_light + 2.0 * sine * sine_of_light * azimuth;
                    self.density((across2 / (across2 + height2)).min(1.0))
                };
                let sum: f64 = azimuths.iter().map(of_azimuth).sum();
                sum * light.sqrt() / (4.0 * cosine * (1.0 + hidden + lambda))
            };
            // dz = 2 sqrt(z) d sqrt(z).
            lights.iter().map(ring).sum::<f64>() * 2.0 * TAU / f64::from(RINGS * SECTORS)
        };
        cosines.iter().map(albedo).collect()
    }
}

/// The directional albedo of white sheen, four columns an element. Row `i` has the roughness 0.07 + 0.93 (i/31)², and column `j` the cosine
/// (j/31)⁴, because the albedo changes most at grazing angles. Between them it is interpolated, and is nowhere less than the true one, so that no
/// light is added.
pub fn sheen_albedos() -> &'static [[f32; 4]] {
    static TABLE: LazyLock<Vec<[f32; 4]>> = LazyLock::new(make_sheen_albedos);
    &TABLE
}

fn make_sheen_albedos() -> Vec<[f32; 4]> {
    let fine = |count: usize| (count - 1) * FINER + 1;
    let share = |at: usize, count: usize| at as f64 / (fine(count) - 1) as f64;
    let cosines: Vec<f64> = (0..fine(COLUMNS)).map(|at| share(at, COLUMNS).powi(4)).collect();
    let row = |at: usize| {
        let roughness = LEAST_ROUGHNESS + (1.0 - LEAST_ROUGHNESS) * share(at, ROWS).powi(2);
        Charlie::of_roughness(roughness).albedos(&cosines)
    };
    let rows: Vec<Vec<f64>> = (0..fine(ROWS)).map(row).collect();
    let mut table: Vec<Vec<f64>> =
        (0..ROWS).map(|i| (0..COLUMNS).map(|j| rows[i * FINER][j * FINER]).collect()).collect();
    let known = table.clone();
    for (i, j) in (0..ROWS - 1).flat_map(|i| (0..COLUMNS - 1).map(move |j| (i, j))) {
        let mut lacking: f64 = 0.0;
        for (y, x) in (0..=FINER).flat_map(|y| (0..=FINER).map(move |x| (y, x))) {
            let (down, right) = (y as f64 / FINER as f64, x as f64 / FINER as f64);
            let along = |row: usize| known[row][j] + right * (known[row][j + 1] - known[row][j]);
            let interpolated = along(i) + down * (along(i + 1) - along(i));
            lacking = lacking.max(rows[i * FINER + y][j * FINER + x] - interpolated);
        }
        for (row, column) in [(i, j), (i, j + 1), (i + 1, j), (i + 1, j + 1)] {
            table[row][column] = table[row][column].max(known[row][column] + lacking);
        }
    }
    let all: Vec<f32> = table.into_iter().flatten().map(|albedo| (albedo * ROOM) as f32).collect();
    all.chunks_exact(4).map(|four| [four[0], four[1], four[2], four[3]]).collect()
}
