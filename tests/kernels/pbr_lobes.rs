//! What glTF's material has around its base: its lobes against their formulas in f64, and the light that they keep (bsdf.rs has the comparison).

use std::f64::consts::{PI, TAU};

use glam::DVec3;

use crate::bsdf::Wrong::{Expression, Text};
use crate::bsdf::{Bsdf, Material, Rows, Wrong, material, respond_by_their_formulas};
use crate::common::microfacets::{
    ABSORBED, In, Lobes, SPECULAR, albedo_table, answers, density, kernel, masking, schlick, shadowing,
    view_and_normal, visible,
};
use crate::common::oracles::fresnel;
use crate::common::rows::glass;
use crate::common::stats::Random;
use crate::common::vectors::{U, exact, rounded, unit};
use crate::pbr::{
    Formula, body, brightness, ends_of_layer, film_share, formula, layer_with_film, metal_with_film, rows,
    share_of_facets, share_of_far_side, with_film,
};
use crate::rough::{boundary, exact_pane, fresnel_of_a_pane};
use crate::thin_film::off as thin_film_off;

/// The modules of all lobes.
pub const ALL: [&str; 8] = [
    "lobe/specular",
    "lobe/transmission",
    "lobe/sheen",
    "lobe/coat",
    "lobe/anisotropy",
    "lobe/iridescence",
    "lobe/diffuse_transmission",
    "lobe/dispersion",
];

/// A row with a share of glass: a solid, or a pane.
pub fn glassy(row: In, share: f64, ior: f64, is_solid: bool) -> In {
    let glass = glass(ior);
    let contrasts = [glass.numbers[1], glass.numbers[2]];
    let ior = if is_solid { ior as f32 } else { 0.0 };
    In { lobes: Lobes { transmission: share as f32, ior, contrasts, ..row.lobes }, ..row }
}

/// `1 - weight` of one, and `weight` of another, drawn with the probability `share`; each of the two with what it is off by.
fn mixed(inner: Bsdf, outer: Bsdf, (weight, weight_off): (f64, f64), (share, share_off): (f64, f64)) -> Bsdf {
    let by = |a: f64, b: f64, share: f64| (1.0 - share) * a + share * b;
    let rounded = 8.0 * U;
    let value = [0, 1, 2].map(|c| by(inner.value[c], outer.value[c], weight));
    let pdf = by(inner.pdf, outer.pdf, share);
    Bsdf {
        value,
        pdf,
        off: [0, 1, 2].map(|c| {
            by(inner.off[c], outer.off[c], weight) + rounded * value[c] + weight_off * (inner.value[c] + outer.value[c])
        }),
        pdf_off: by(inner.pdf_off, outer.pdf_off, share) + rounded * pdf + share_off * (inner.pdf + outer.pdf),
        is_unknown: inner.is_unknown || outer.is_unknown,
        weight_off: None,
    }
}

/// The base, with the limits of pbr.rs.
fn base(row: &In, view: DVec3, normal: DVec3, direction: DVec3) -> Bsdf {
    let cos_view = view.dot(normal);
    let passes = direction.dot(normal) < 0.0 && row.lobes.through > 0.0;
    if direction.dot(normal) < 4.0 * U && !passes {
        return Bsdf { is_unknown: direction.dot(normal) > -4.0 * U, ..Bsdf::default() };
    }
    let is_smooth = row.material.numbers[0] < 1.0 / 1024.0;
    let Formula { value, facets, cosine } = match is_smooth && !passes {
        // Without its microfacets.
        true => {
            let cosine = direction.dot(normal).max(0.0) / PI;
            let layer = layer_with_film(row, view.dot((view + direction).normalize()));
            let passed = 1.0 - layer.into_iter().fold(0.0, f64::max);
            let matt = (1.0 - f64::from(row.material.numbers[2])) * passed * cosine;
            let [near, _] = body(row);
            let cosine = (1.0 - share_of_far_side(row)) * cosine;
            Formula { value: near.map(|base| base * matt), facets: 0.0, cosine }
        }
        false => formula(row, view, normal, direction),
    };
    let alpha = f64::from(row.material.numbers[0].max(1.0 / 1024.0)).powi(2);
    let share = share_of_facets(row, cos_view);
    let pdf = share * facets + (1.0 - share) * cosine;
    let mirrored = if passes { direction - 2.0 * direction.dot(normal) * normal } else { direction };
    let turned = 4.0 * U / (view + mirrored).length();
    let light = direction.dot(normal).abs().max(1e-9);
    let of_film = film_off(row, view.dot((view + mirrored).normalize()), turned);
    let of_alpha = if is_smooth { 0.0 } else { 4.0 * turned / alpha };
    let limit = 96.0 * U + of_alpha + 4.0 * U / light + 4.0 * U / (cos_view + alpha) + 16.0 * turned;
    let white = facets * shadowing(cos_view, light, alpha) / masking(cos_view, alpha) + cosine;
    Bsdf {
        value,
        pdf,
        off: value.map(|value| limit * value + (5.0 * turned + of_film) * white),
        pdf_off: limit * pdf + 5.0 * turned * pdf,
        is_unknown: light < 4.0 * U,
        weight_off: None,
    }
}

/// By how much f32 moves what a film reflects at a cosine that is off by this.
fn film_off(row: &In, cosine: f64, turned: f64) -> f64 {
    if row.lobes.film == 0.0 {
        return 0.0;
    }
    let [ior, thickness] = [row.lobes.film_ior, row.lobes.film_thickness].map(f64::from);
    let by = |cosine: f64| {
        let cosine = cosine.clamp(0.0, 1.0);
        let all = layer_with_film(row, cosine).into_iter().chain(metal_with_film(row, cosine));
        all.collect::<Vec<f64>>()
    };
    let (below, above) = (by(cosine - 2.0 * turned), by(cosine + 2.0 * turned));
    let moved = below.iter().zip(&above).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    thin_film_off(ior, thickness) + 2.0 * moved
}

fn is_rough_glass(row: &In) -> bool {
    let (roughness, least) = (row.material.numbers[0], 1.0 / 1024.0f32);
    match row.lobes.ior > 0.0 {
        true => roughness.powi(2) * row.lobes.contrasts[0].abs().min(1.0) >= least.powi(2),
        false => roughness >= least,
    }
}

/// The row of the glass by itself.
fn of_glass(row: &In) -> In {
    let [outside, inside] = row.lobes.contrasts;
    let mut own = *row;
    (own.material.numbers[1], own.material.numbers[2]) = (outside, inside);
    let index = row.lobes.ior + row.followed * row.lobes.dispersion;
    own.second.numbers[0] = index;
    own
}

fn tint(row: &In, normal: DVec3, direction: DVec3) -> [f64; 3] {
    if direction.dot(normal) < 0.0 { row.colour.map(f64::from) } else { [1.0; 3] }
}

fn with_glass(row: &In, view: DVec3, normal: DVec3, direction: DVec3) -> Bsdf {
    let under = base(row, view, normal, direction);
    let weight = f64::from(row.lobes.transmission);
    if weight == 0.0 {
        return under;
    }
    let mut glass = Bsdf::default();
    if is_rough_glass(row) {
        let of_bsdf = if row.lobes.ior > 0.0 { boundary } else { exact_pane };
        let own = of_bsdf(&of_glass(row), direction);
        let limit = own.pdf_off / own.pdf;
        let (split, split_off) = split_of_glass(row, view, normal, direction);
        let tint = tint(row, normal, direction);
        let value = [0, 1, 2].map(|c| tint[c] * own.value[c] * split.value[c]);
        let pdf = own.pdf * split.pdf;
        glass = Bsdf {
            value,
            pdf,
            off: value.map(|value| (limit + split_off) * value),
            pdf_off: (limit + split_off) * pdf,
            // A response that is 0 here may be one on the edge of what microfacets see there.
            is_unknown: own.is_unknown || pdf == 0.0,
            weight_off: None,
        };
    }
    mixed(under, glass, (weight, 0.0), share_of_glass(row, view.dot(normal)))
}

/// What film and dispersion change of plain glass: factors of the value and of the density, and by how much f32 may move them. The row's own index
/// is that of the channel which is followed (`of_glass`).
fn split_of_glass(row: &In, view: DVec3, normal: DVec3, direction: DVec3) -> (Bsdf, f64) {
    if film_share(row) == 0.0 && row.lobes.dispersion == 0.0 {
        return (Bsdf { value: [1.0; 3], pdf: 1.0, ..Bsdf::default() }, 0.0);
    }
    let is_solid = row.lobes.ior > 0.0;
    let reflects = direction.dot(normal) > 0.0;
    let index = |channel: f64| f64::from(row.lobes.ior) + channel * f64::from(row.lobes.dispersion);
    let eta_at = |channel: f64| match is_solid {
        true if row.front == 1 => index(channel),
        true => 1.0 / index(channel),
        false => (1.0 + f64::from(row.lobes.contrasts[0])).sqrt(),
    };
    let eta = eta_at(f64::from(row.followed));
    let sum = match (reflects, is_solid) {
        (true, _) => view + direction,
        (false, true) => view + eta * direction,
        (false, false) => view + direction - 2.0 * direction.dot(normal) * normal,
    };
    let cos_facet = view.dot(sum.normalize()).abs().min(1.0);
    let by = |cosine: f64| {
        let plain = fresnel_of_a_pane(cosine, eta);
        let all = [-1.0, 0.0, 1.0].map(|channel| fresnel_of_a_pane(cosine, eta_at(channel)));
        let outside = match is_solid && row.front == 0 {
            true => (1.0 - (1.0 - cosine * cosine) / (eta * eta)).max(0.0).sqrt(),
            false => cosine,
        };
        if plain >= 1.0 || film_share(row) == 0.0 {
            return (all, plain, plain);
        }
        let film = with_film(row, [0.0; 3], ends_of_layer(row), outside);
        let share = if row.f90 == 0.0 { 0.0 } else { film_share(row) };
        let with = |c: usize, plain: f64| (1.0 - share) * plain + film[c];
        let chance = (0..3).map(|c| with(c, plain)).fold(0.0, f64::max);
        ([0, 1, 2].map(|c| with(c, all[c])), chance, plain)
    };
    let factors = |(colour, chance, plain): ([f64; 3], f64, f64)| match reflects {
        true => Bsdf { value: colour.map(|c| c / plain), pdf: chance / plain, ..Bsdf::default() },
        false => {
            let passed = (1.0 - chance) / (1.0 - plain);
            Bsdf { value: [passed; 3], pdf: passed, ..Bsdf::default() }
        }
    };
    let turned = 16.0 * U / sum.length();
    let (own, near) =
        (factors(by(cos_facet)), [-1.0, 1.0].map(|sign| factors(by((cos_facet + sign * turned).clamp(0.0, 1.0)))));
    let relative = |of: fn(&Bsdf) -> f64| {
        let moved = near.iter().map(|near| (of(near) / of(&own) - 1.0).abs()).fold(0.0, f64::max);
        if of(&own) > 0.0 { moved } else { 0.0 }
    };
    let moved =
        [relative(|it| it.value[0]), relative(|it| it.value[1]), relative(|it| it.value[2]), relative(|it| it.pdf)];
    let least = own.value.into_iter().chain([own.pdf]).filter(|it| *it > 0.0).fold(f64::INFINITY, f64::min);
    let of_film = film_off(row, cos_facet, turned) / (by(cos_facet).2 * least).max(1e-9);
    (own, 64.0 * U + of_film + 2.0 * moved.into_iter().fold(0.0, f64::max))
}

fn albedo_of_glass(row: &In, cos_view: f64) -> f64 {
    let ior = (1.0 + f64::from(row.lobes.contrasts[0])).sqrt();
    let eta = if row.front == 1 || row.lobes.ior == 0.0 { ior } else { 1.0 / ior };
    let reflected = fresnel_of_a_pane(cos_view, eta);
    reflected + (1.0 - reflected) * row.colour.iter().map(|c| f64::from(*c)).sum::<f64>() / 3.0
}

/// The probability of the glass, and by how much the rounding of the cosine moves it.
fn share_of_glass(row: &In, cos_view: f64) -> (f64, f64) {
    let weight = f64::from(row.lobes.transmission);
    let by = |cos: f64| {
        let (facets, matt) = brightness(row, cos_view);
        let glass = weight * albedo_of_glass(row, cos.clamp(0.0, 1.0));
        let all = glass + (1.0 - weight) * (facets + matt) / 3.0;
        if all > 0.0 { glass / all } else { weight }
    };
    (by(cos_view), (by(cos_view - 4.0 * U) - by(cos_view + 4.0 * U)).abs() + 64.0 * U)
}

/// The albedo of white sheen by the table of the kernels, and by how much the rounding of the cosine moves it.
fn sheen_albedo(cosine: f64, roughness: f64) -> (f64, f64) {
    let all = &albedo_table()[256..];
    let at = |row: usize, column: usize| f64::from(all[(row * 32 + column) / 4][column % 4]);
    let by = |cosine: f64| {
        let x = cosine.clamp(0.0, 1.0).sqrt().sqrt() * 31.0;
        let y = ((roughness.max(0.07) - 0.07) / 0.93).sqrt() * 31.0;
        let (column, row) = ((x as usize).min(30), (y as usize).min(30));
        let mix = |a: f64, b: f64, by: f64| a + by * (b - a);
        let along = |row: usize| mix(at(row, column), at(row, column + 1), x - column as f64);
        mix(along(row), along(row + 1), y - row as f64)
    };
    // The row is off by 31 roundings of its place, and so is the column; neighbours differ by at most 1.
    (by(cosine), (by(cosine - 4.0 * U) - by(cosine + 4.0 * U)).abs() + 512.0 * U)
}

fn charlie_fit(x: f64, alpha: f64) -> f64 {
    let m = (1.0 - alpha).powi(2);
    let mix = |a: f64, b: f64| (1.0 - m) * a + m * b;
    let (a, b, c) = (mix(21.5473, 25.3245), mix(3.82987, 3.32435), mix(0.19823, 0.16801));
    let (d, e) = (mix(-1.97760, -1.27393), mix(-4.32054, -4.85967));
    a / (1.0 + b * x.powf(c)) + d * x + e
}

fn charlie_lambda(cosine: f64, alpha: f64) -> f64 {
    match cosine < 0.5 {
        true => charlie_fit(cosine, alpha).exp(),
        false => (2.0 * charlie_fit(0.5, alpha) - charlie_fit(1.0 - cosine, alpha)).exp(),
    }
}

/// The BRDF of white sheen times the cosine of the light, by its words in KHR_materials_sheen.
fn white_sheen(view: DVec3, normal: DVec3, direction: DVec3, roughness: f64) -> f64 {
    let alpha = roughness.max(0.07).powi(2);
    let (cos_view, cos_light) = (view.dot(normal).min(1.0), direction.dot(normal).min(1.0));
    let sine2 = (view + direction).normalize().cross(normal).length_squared().min(1.0);
    let density = (2.0 + 1.0 / alpha) * sine2.powf(0.5 / alpha) / TAU;
    let hidden = charlie_lambda(cos_view, alpha) + charlie_lambda(cos_light, alpha);
    density / ((1.0 + hidden) * 4.0 * cos_view)
}

fn has_sheen(row: &In) -> bool {
    row.lobes.sheen != [0.0; 3]
}

/// About what comes back of base and glass, and with the sheen over them, as the shader has it.
fn albedos(row: &In, cos_view: f64) -> (f64, f64) {
    let (facets, matt) = brightness(row, cos_view);
    let weight = f64::from(row.lobes.transmission);
    let mixed = (1.0 - weight) * (facets + matt) / 3.0 + weight * albedo_of_glass(row, cos_view);
    if !has_sheen(row) {
        return (mixed, mixed);
    }
    let (own, most) = sheen_of(row, cos_view);
    (mixed, own + (1.0 - most) * mixed)
}

/// The mean over the channels of the sheen's albedo, and its largest channel.
fn sheen_of(row: &In, cos_view: f64) -> (f64, f64) {
    let (albedo, _) = sheen_albedo(cos_view, f64::from(row.lobes.sheen_roughness));
    let colour = row.lobes.sheen.map(f64::from);
    (albedo.min(1.0) * colour.iter().sum::<f64>() / 3.0, albedo.min(1.0) * colour.into_iter().fold(0.0, f64::max))
}

fn share_of_sheen(row: &In, cos_view: f64) -> f64 {
    let (mixed, sheened) = albedos(row, cos_view);
    if mixed == 0.0 { 1.0 } else { (sheen_of(row, cos_view).0 / sheened).clamp(0.05, 0.95) }
}

/// What lies below the sheen has this factor; and how much f32 may be off.
fn scaling(row: &In, cos_view: f64, cos_light: f64) -> (f64, f64) {
    let roughness = f64::from(row.lobes.sheen_roughness);
    let most = row.lobes.sheen.into_iter().map(f64::from).fold(0.0, f64::max);
    let both = [cos_view, cos_light].map(|cosine| sheen_albedo(cosine, roughness));
    (1.0 - most * both[0].0.max(both[1].0).min(1.0), both[0].1 + both[1].1)
}

fn with_sheen(row: &In, view: DVec3, normal: DVec3, direction: DVec3) -> Bsdf {
    let under = with_glass(row, view, normal, direction);
    if !has_sheen(row) {
        return under;
    }
    let (cos_view, cos_light) = (view.dot(normal), direction.dot(normal));
    let (factor, factor_off) = scaling(row, cos_view, cos_light.abs());
    let roughness = f64::from(row.lobes.sheen_roughness);
    let share = share_of_sheen(row, cos_view);
    let share_off = 4.0 * sheen_albedo(cos_view, roughness).1 + 64.0 * U;
    let (mut sheen, mut sheen_off, mut cosine) = (0.0, 0.0, 0.0);
    if cos_light > 0.0 {
        let most = [cos_view, cos_light].map(|cosine| sheen_albedo(cosine, roughness));
        let most_off = most[0].1 + most[1].1;
        let most = most[0].0.max(most[1].0).max(1.0);
        sheen = white_sheen(view, normal, direction, roughness) / most;
        // The exponent multiplies what the squared sine and the logarithm of WGSL are off by, which is 2^-21 absolute; the fit, of up to 21, has
        // another such power, and is moved by the cosines.
        let power = 0.5 / roughness.max(0.07).powi(2);
        let half_way = view + direction;
        let sine = half_way.normalize().cross(normal).length().max(1e-9);
        let turned = 4.0 * U / half_way.length();
        let alpha = roughness.max(0.07).powi(2);
        let moved = |cosine: f64| {
            let by = |x: f64| charlie_lambda(x.clamp(1e-9, 1.0), alpha);
            (by(cosine - 4.0 * U) / by(cosine + 4.0 * U) - 1.0).abs()
        };
        let limit = power * (2.0 * turned / sine + 16.0 * U + 0.5f64.powi(20))
            + moved(cos_view)
            + moved(cos_light)
            + 64.0 * 0.5f64.powi(20)
            + 4.0 * U / cos_view
            + most_off;
        sheen_off = sheen * limit;
        cosine = cos_light / PI;
    }
    let colour = row.lobes.sheen.map(f64::from);
    let pdf = (1.0 - share) * under.pdf + share * cosine;
    let all = 8.0 * U;
    let value = [0, 1, 2].map(|c| factor * under.value[c] + colour[c] * sheen);
    Bsdf {
        value,
        pdf,
        off: [0, 1, 2].map(|c| under.off[c] + factor_off * under.value[c] + colour[c] * sheen_off + all * value[c]),
        pdf_off: under.pdf_off + share_off * (under.pdf + cosine) + all * pdf + 4.0 * U,
        is_unknown: under.is_unknown,
        weight_off: None,
    }
}

fn coat_reflectance(row: &In, view: DVec3) -> f64 {
    let cosine = view.dot(exact(row.coat_normal).normalize());
    f64::from(row.lobes.coat) * schlick(cosine, f64::from(row.lobes.coat_f0))
}

fn share_of_coat(row: &In, view: DVec3, normal: DVec3) -> f64 {
    let coat = coat_reflectance(row, view);
    coat / (coat + (1.0 - coat) * albedos(row, view.dot(normal)).1)
}

/// All of the material. Of more than its base, f32 has no digits of a density that is off by a fifth.
pub fn bsdf(row: &In, direction: DVec3) -> Bsdf {
    let (view, normal) = view_and_normal(row);
    let found = with_coat(row, view, normal, direction);
    let has_lobes = row.lobes != Lobes::default();
    Bsdf { is_unknown: found.is_unknown || has_lobes && found.pdf_off > 0.2 * found.pdf, ..found }
}

fn with_coat(row: &In, view: DVec3, normal: DVec3, direction: DVec3) -> Bsdf {
    let under = with_sheen(row, view, normal, direction);
    if row.lobes.coat == 0.0 {
        return under;
    }
    let own = exact(row.coat_normal).normalize();
    let (cos_view, cos_light) = (view.dot(own), direction.dot(own));
    let mut coat = Bsdf { is_unknown: cos_light.abs() < 4.0 * U || cos_view < 1e-5, ..Bsdf::default() };
    if row.lobes.coat_roughness >= 1.0 / 1024.0 && cos_light > 0.0 && direction.dot(normal) > 0.0 {
        let alpha = f64::from(row.lobes.coat_roughness).powi(2);
        let facet = (view + direction).normalize();
        let turned = 4.0 * U / (view + direction).length();
        let limit =
            96.0 * U + 4.0 * turned / alpha + 4.0 * U / cos_light + 4.0 * U / (cos_view + alpha) + 16.0 * turned;
        let seen = density(facet.cross(own).length(), facet.dot(own), alpha) / (4.0 * cos_view);
        let value = seen * shadowing(cos_view, cos_light, alpha);
        coat.pdf = visible(facet, view, own, alpha) / (4.0 * view.dot(facet));
        (coat.value, coat.off) = ([value; 3], [limit * value; 3]);
        coat.pdf_off = limit * coat.pdf;
    }
    let coat_off = {
        let by =
            |cosine: f64| f64::from(row.lobes.coat) * schlick(cosine.clamp(0.0, 1.0), f64::from(row.lobes.coat_f0));
        (by(cos_view - 4.0 * U) - by(cos_view + 4.0 * U)).abs() + 8.0 * U
    };
    // A share s of r and (1 - r) a moves with r by s (1 - s) / (r (1 - r)).
    let (reflectance, share) = (coat_reflectance(row, view), share_of_coat(row, view, normal));
    let moved = coat_off * share * (1.0 - share) / (reflectance * (1.0 - reflectance)).max(1e-9);
    let share_off = moved
        + 64.0 * U
        + if has_sheen(row) {
            4.0 * sheen_albedo(view.dot(normal), f64::from(row.lobes.sheen_roughness)).1
        } else {
            0.0
        };
    let share_off =
        share_off + if row.lobes.transmission > 0.0 { share_of_glass(row, view.dot(normal)).1 } else { 0.0 };
    mixed(under, coat, (reflectance, coat_off), (share, share_off))
}

pub fn glassy_rows(random: &mut Random, count: usize, towards_light: bool) -> Vec<In> {
    let rows = rows(random, count, towards_light);
    let with_glass = |(i, row): (usize, In)| {
        let share = [0.0, 0.3, 1.0, 0.7, 1e-3][i / 5 % 5];
        In { front: i as u32 / 7 % 2, ..glassy(row, share, [1.5, 1.33, 2.4][i % 3], i / 2 % 2 == 0) }
    };
    rows.into_iter().enumerate().map(with_glass).collect()
}

fn coated_rows(random: &mut Random, count: usize, towards_light: bool) -> Vec<In> {
    let rows = rows(random, count, towards_light).into_iter().enumerate();
    rows.map(|(i, row)| coated(random, i, row)).collect()
}

/// With a coat, whose normal is that of the surface or another one that the view sees.
fn coated(random: &mut Random, i: usize, row: In) -> In {
    let (view, normal) = view_and_normal(&row);
    let other = (normal + 0.4 * unit(random)).normalize();
    let own = if i.is_multiple_of(2) && view.dot(other) > 0.01 { rounded(other) } else { row.normal };
    let coat = [1.0, 0.5, 0.0, 0.01][i / 2 % 4];
    let coat_roughness = [0.5, 0.0, 1.0, 0.1, 0.2][i / 3 % 5];
    let coat_f0 = [0.04, 0.0, 0.2, 1.0][i / 5 % 4];
    In { coat_normal: own, lobes: Lobes { coat, coat_roughness, coat_f0, ..row.lobes }, ..row }
}

pub fn sheened(i: usize, row: In) -> In {
    let sheen = [[0.9, 0.3, 0.0], [1.0; 3], [0.0; 3], [0.01, 0.0, 0.02]][i / 2 % 4];
    let sheen_roughness = [0.5, 0.0, 1.0, 0.1, 0.3][i / 3 % 5];
    In { coat_normal: row.normal, lobes: Lobes { sheen, sheen_roughness, ..row.lobes }, ..row }
}

pub fn filmed(i: usize, row: In) -> In {
    let film = [1.0, 0.4, 0.0][i % 3];
    let (film_ior, film_thickness) = ([1.3, 2.0, 1.1][i / 3 % 3], [400.0, 0.0, 150.0, 0.012, 1200.0][i / 2 % 5]);
    In { coat_normal: row.normal, lobes: Lobes { film, film_ior, film_thickness, ..row.lobes }, ..row }
}

pub fn translucent(i: usize, row: In) -> In {
    let through = [0.5, 1.0, 0.0, 0.01][i % 4];
    let colour_through = [[0.9, 0.3, 0.0], [1.0; 3], [0.0; 3], [0.2, 0.5, 0.1]][i / 3 % 4];
    In { coat_normal: row.normal, lobes: Lobes { through, colour_through, ..row.lobes }, ..row }
}

/// Of solid glass.
fn dispersed(i: usize, row: In) -> In {
    let spread = [0.05, 0.0, 0.2][i % 3] * (row.lobes.ior - 1.0).max(0.0);
    In { followed: [-1.0, 1.0, 0.0][i / 3 % 3], lobes: Lobes { dispersion: spread, ..row.lobes }, ..row }
}

/// Rows that are changed by their numbers.
fn changed(rows: Vec<In>, by: impl Fn(usize, In) -> In) -> Vec<In> {
    rows.into_iter().enumerate().map(|(i, row)| by(i, row)).collect()
}

/// With all lobes.
fn full_rows(random: &mut Random, count: usize, towards_light: bool) -> Vec<In> {
    let rows = glassy_rows(random, count, towards_light).into_iter().enumerate();
    let around = |(i, row)| coated(random, i / 3, sheened(i / 7, row));
    changed(rows.map(around).collect(), |i, row| {
        let own = dispersed(i / 17, translucent(i / 13, filmed(i / 11, row)));
        In { coat_normal: row.coat_normal, ..own }
    })
}

/// Layers of these rows. Each error is found in at least 100 of them.
const fn layers(name: &'static str, seed: u64, rows: Rows, planted: &'static [(Wrong, [usize; 3])]) -> Material {
    Material { with: &ALL, seed, compared: 5000, planted, ..material(name, "pbr", rows, bsdf) }
}

const fn plant(module: &'static str, right: &'static str, wrong: &'static str) -> (Wrong, [usize; 3]) {
    (Expression((module, right, wrong)), [0; 3])
}

const LAYERS: [Material; 7] = [
    layers(
        "a share of glass is mixed with the base",
        601,
        glassy_rows,
        &[
            plant("data/material", "(1.0 - weight) * inner.value", "(1.0 - 0.97 * weight) * inner.value"),
            plant("data/material", "share * outer.pdf", "1.02 * share * outer.pdf"),
            plant(
                "lobe/transmission",
                "select(vec3<f32>(1.0), hit.colour, dot(direction, hit.normal) < 0.0)",
                "hit.colour",
            ),
            plant("lobe/transmission", "(material), {{lobes.ior}}, lobes.contrasts", "1.01 * lobes.ior"),
        ],
    ),
    layers(
        "a coat reflects what lies below does not get",
        611,
        coated_rows,
        &[
            plant("lobe/coat", "schlick({{cos_view}}, vec3<f32>(hit.lobes.coat_f0))", "1.0"),
            plant("lobe/coat", "microfacet_density(half_way, {{hit.coat_normal}}, alpha)", "hit.normal"),
            plant(
                "lobe/coat",
                "dot(direction, hit.coat_normal) > 0.0 && dot(direction, hit.normal) > 0.0",
                "dot(direction, hit.coat_normal) > 0.0",
            ),
        ],
    ),
    layers(
        "a sheen takes from what lies below what it reflects",
        613,
        |random, count, lights| changed(rows(random, count, lights), sheened),
        &[
            plant("lobe/sheen", "min({{max(albedos.x, albedos.y)}}, 1.0)", "albedos.x"),
            plant("lib/charlie", "{{2.0 * charlie_fit(0.5, alpha)}} - fit", "1.99 * charlie_fit(0.5, alpha)"),
            plant("lib/charlie", "{{0.5 / alpha}})", "0.51 / alpha"),
            plant("lobe/sheen_albedo", "sqrt(sqrt(cosine))", "sqrt(cosine)"),
        ],
    ),
    layers(
        "a film reflects in place of the base and its glass",
        631,
        |random, count, lights| changed(glassy_rows(random, count, lights), |i, row| filmed(i / 11, row)),
        &[
            plant("lobe/iridescence", "+ {{share * film}};", "0.97 * share * film"),
            plant("lobe/iridescence", "{{smoothstep(0.0, 0.03, hit.lobes.film_thickness)}}", "1.0"),
            plant("lobe/iridescence", "max(max(film.x, film.y), film.z)", "film.x"),
            plant("lobe/iridescence", "colour / chance", "under.colour"),
            plant(
                "material/pbr_base",
                "with_film({{schlick(cos_facet, hit.colour)}}",
                "0.9 * schlick(cos_facet, hit.colour)",
            ),
            plant(
                "material/glass",
                "select(refraction.cos_transmitted, min(cos_facet, 1.0), hit.front)",
                "min(cos_facet, 1.0)",
            ),
        ],
    ),
    layers(
        "light passes a translucent body",
        633,
        |random, count, lights| changed(rows(random, count, lights), |i, row| translucent(i / 11, row)),
        &[
            plant(
                "lobe/diffuse_transmission",
                "return hit.lobes.through * {{hit.lobes.colour_through}};",
                "hit.colour",
            ),
            plant("lobe/diffuse_transmission", "select({{far}}, 1.0 - far,", "0.98 * far"),
            plant("lobe/diffuse_transmission", "direction - {{2.0}} *", "1.9"),
            plant("lobe/diffuse_transmission", "return {{(1.0 - hit.lobes.through)}} * hit.colour;", "1.0"),
        ],
    ),
    layers(
        "glass with dispersion has an index for each channel",
        635,
        |random, count, lights| changed(glassy_rows(random, count, lights), |i, row| dispersed(i / 11, row)),
        &[
            plant("lobe/dispersion", "let own = {{glass.ior + shift}};", "glass.ior - shift"),
            plant("lobe/dispersion", "shift * ({{2.0 * glass.ior + shift}})", "2.0 * glass.ior"),
            plant("lobe/dispersion", "{{all / reflectance}}, reflectance", "vec3<f32>(1.0)"),
        ],
    ),
    layers(
        "all lobes lie in their order",
        615,
        full_rows,
        &[
            (Text(&[("lobe/layers", "//@ each inner_layer\n    response", "//@ each layer\n    response")]), [0; 3]),
            plant("lobe/layers", "under_${name} = {{under}};", "base"),
        ],
    ),
];

#[test]
fn layers_respond_by_their_formulas() {
    respond_by_their_formulas(&LAYERS);
}

/// The table is nowhere less than the light that sheen returns, so that no light is added, and at most 3 % of all light more.
#[test]
fn the_table_of_sheen_is_no_less_than_what_comes_back() {
    let mut random = Random(619);
    let (mut least, mut most) = (f64::INFINITY, f64::NEG_INFINITY);
    for _ in 0..400 {
        let (cosine, roughness) = (random.uniform().powi(2).max(1e-5), 0.07 + 0.93 * random.uniform().powi(2));
        let view = DVec3::new((1.0 - cosine * cosine).sqrt(), 0.0, cosine);
        let (rings, sectors) = (400, 100);
        let mut sum = 0.0;
        for ring in 0..rings {
            let root = (f64::from(ring) + 0.5) / f64::from(rings);
            let light = root * root;
            for sector in 0..sectors {
                let azimuth = PI * (f64::from(sector) + 0.5) / f64::from(sectors);
                let sine = (1.0 - light * light).sqrt();
                let direction = DVec3::new(sine * azimuth.cos(), sine * azimuth.sin(), light);
                sum += root * white_sheen(view, DVec3::Z, direction, roughness);
            }
        }
        let kept = sum * 2.0 * TAU / f64::from(rings * sectors);
        let table = sheen_albedo(cosine, roughness).0;
        least = least.min(table - kept);
        // Where it is more than 1 it is not more light, but only a smaller sheen.
        most = most.max(table.min(1.0) - kept.min(1.0));
    }
    assert!(least > -1e-4, "{least}");
    assert!(most < 0.03, "{most}");
}

/// Smooth glass and a smooth base are lobes of one direction each, drawn by their shares, with the weight of a share over its probability.
#[test]
fn smooth_glass_over_a_base_is_drawn_by_its_share() {
    let mut random = Random(607);
    let rows: Vec<In> = glassy_rows(&mut random, 20_000, false)
        .into_iter()
        .map(|mut row| {
            row.material.numbers[0] = 0.0;
            row.coat_normal = row.normal;
            row
        })
        .filter(|row| row.lobes.transmission > 0.0)
        .collect();
    let (mut reflected, mut passed, mut others, mut planted) = (0, 0, 0, 0);
    for (row, out) in rows.iter().zip(answers(&kernel("pbr", &ALL), &rows, rows.len())) {
        let (view, normal) = view_and_normal(row);
        let cos_view = view.dot(normal);
        let ((share, off), weight) = (share_of_glass(row, cos_view), f64::from(row.lobes.transmission));
        let u = f64::from(row.u[0]);
        if (u - share).abs() < 1e-5 + off || out.event == ABSORBED {
            continue;
        }
        let near = |found: f32, expected: f64| {
            (f64::from(found) - expected).abs()
                <= (1e-4 + 4.0 * off / share.min(1.0 - share).max(1e-6)) * expected.max(0.1)
        };
        if u < share {
            let direction = exact(out.direction);
            let expected = tint(row, normal, direction).map(|tint| tint * weight / share);
            assert!(out.lobe == SPECULAR && (0..3).all(|c| near(out.weight[c], expected[c])), "{row:?} {out:?}");
            planted += usize::from((0..3).any(|c| !near(out.weight[c], 1.02 * expected[c])));
            let eta = match row.lobes.ior > 0.0 {
                true if row.front == 1 => f64::from(row.lobes.ior),
                true => 1.0 / f64::from(row.lobes.ior),
                false => (1.0 + f64::from(row.lobes.contrasts[0])).sqrt(),
            };
            let is_reflected = u / share < fresnel(cos_view, eta).0;
            let blur = (u / share - fresnel(cos_view, eta).0).abs() < 1e-4 + 2.0 * off / share;
            assert!(blur || (direction.dot(normal) > 0.0) == is_reflected, "{row:?} {out:?}");
            reflected += usize::from(is_reflected);
            passed += usize::from(!is_reflected);
        } else {
            others += 1;
        }
    }
    assert!(
        reflected > 500 && passed > 2000 && others > 2000 && planted > 2000,
        "{reflected} {passed} {others} {planted}"
    );
}

/// A smooth coat is a lobe of one direction, drawn by its share, and what lies below has the rest of the weight: of a smooth base, that
/// of its mirror under coat and sheen.
#[test]
fn a_smooth_coat_leaves_the_rest_to_what_lies_below() {
    let mut random = Random(621);
    let rows: Vec<In> = rows(&mut random, 20_000, false)
        .into_iter()
        .enumerate()
        .map(|(i, row)| {
            let mut row = coated(&mut random, i, sheened(i / 7, row));
            (row.material.numbers[0], row.lobes.coat_roughness) = (0.0, 0.0);
            row
        })
        .filter(|row| row.lobes.coat > 0.0)
        .collect();
    let (mut coats, mut bases, mut planted) = (0, 0, 0);
    for (row, out) in rows.iter().zip(answers(&kernel("pbr", &ALL), &rows, rows.len())) {
        let (view, normal) = view_and_normal(row);
        let (cos_view, u) = (view.dot(normal), f64::from(row.u[0]));
        let (coat, share) = (coat_reflectance(row, view), share_of_coat(row, view, normal));
        if coat == 0.0 || out.event == ABSORBED || cos_view < 1e-3 {
            continue;
        }
        let near = |found: f32, expected: f64| (f64::from(found) - expected).abs() <= 1e-3 * expected.max(0.01);
        let below = (u - share) / (1.0 - share);
        let of_sheen = if has_sheen(row) { share_of_sheen(row, cos_view) } else { 0.0 };
        let of_base = (below - of_sheen) / (1.0 - of_sheen);
        let of_facets = share_of_facets(row, cos_view);
        let edges = [u - share, below - of_sheen, of_base - of_facets];
        if edges.iter().any(|edge| edge.abs() < 1e-3) {
            continue;
        }
        let is_mirror = u < share || below > of_sheen && of_base < of_facets;
        assert_eq!(out.lobe == SPECULAR, is_mirror, "{row:?} {out:?}");
        if u < share {
            assert!(out.weight.iter().all(|weight| near(*weight, coat / share)), "{row:?} {out:?}");
            planted += usize::from(!near(out.weight[0], 1.02 * coat / share));
            let own = exact(row.coat_normal).normalize();
            let mirrored = 2.0 * view.dot(own) * own - view;
            assert!((exact(out.direction) - mirrored).length() < 16.0 * U, "{row:?} {out:?}");
            coats += 1;
        } else if is_mirror {
            let metallic = f64::from(row.material.numbers[2]);
            let factor = if has_sheen(row) { scaling(row, cos_view, cos_view).0 / (1.0 - of_sheen) } else { 1.0 };
            let around = (1.0 - coat) / (1.0 - share) * factor / of_facets;
            let expected = |c: usize| {
                let base = f64::from(row.colour[c]);
                around * ((1.0 - metallic) * layer_with_film(row, cos_view)[c] + metallic * schlick(cos_view, base))
            };
            assert!((0..3).all(|c| near(out.weight[c], expected(c))), "{row:?} {out:?} {:?}", [0, 1, 2].map(expected));
            bases += 1;
        }
    }
    assert!(coats > 1000 && bases > 1000 && planted > 1000, "{coats} {bases} {planted}");
}
