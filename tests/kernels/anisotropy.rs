//! lobe/anisotropy: rows of microfacets that are rougher along a direction, for each material that has them (bsdf.rs compares them).

use glam::DVec3;

use crate::common::kernel::Kernel;
use crate::common::microfacets::{In, Lobes, NO_LAYER, Out, conductor, frosted, kernel};
use crate::common::stats::Random;
use crate::common::vectors::{exact, rounded, unit};
use crate::pbr::pbr;
use crate::rough::rows_from;

pub const FACETS: &str = "lobe/anisotropy";
pub const ANISOTROPY: &[&str] = &[FACETS];

/// The row with this strength along a random direction.
pub fn along(random: &mut Random, row: In, strength: f64) -> In {
    let tangent: DVec3 = exact(row.normal).cross(unit(random)).normalize();
    let lobes = Lobes { anisotropy: (strength * strength) as f32, ..row.lobes };
    In { tangent: rounded(tangent), lobes, ..row }
}

/// Makes a row of a material with this roughness, by its number.
type Make = fn(In, f64, usize) -> In;

/// From the smallest roughness that microfacets have on.
pub fn stretched_rows(random: &mut Random, count: usize, towards_light: bool, make: Make) -> Vec<In> {
    let rows = rows_from((random, count, towards_light), -2.0, |i, row, roughness| {
        make(row, if i % 4 == 3 { 1.0 / 1024.0 } else { roughness }, i)
    });
    let strength = |i: usize| [1.0, 0.3, 0.8, 0.01][i / 4 % 4];
    rows.into_iter().enumerate().map(|(i, row)| along(random, row, strength(i))).collect()
}

pub fn metal_row(row: In, roughness: f64, _: usize) -> In {
    In { colour: [0.9, 0.5, 0.0], ..conductor(row, roughness, None) }
}

pub fn pbr_row(row: In, roughness: f64, _: usize) -> In {
    In { f90: NO_LAYER, ..pbr(row, [0.9, 0.5, 0.0], 1.0, roughness, 1.5) }
}

pub fn glass_row(row: In, roughness: f64, i: usize) -> In {
    In { front: i as u32 / 3 % 2, ..frosted(row, [1.5, 1.33, 2.4][i % 3], roughness) }
}

/// A material without anisotropy has the bytes of isotropic microfacets.
#[test]
fn without_a_strength_microfacets_are_isotropic() {
    let mut random = Random(703);
    for (material, make) in [("conductor", metal_row as Make), ("pbr", pbr_row), ("rough_dielectric", glass_row)] {
        for towards_light in [false, true] {
            let rows = stretched_rows(&mut random, 10_000, towards_light, make).into_iter();
            let rows: Vec<In> = rows.map(|row| In { lobes: Lobes::default(), ..row }).collect();
            let bytes = |kernel: &Kernel| bytemuck::cast_slice::<Out, u32>(&kernel.run::<_, Out>(&rows)).to_vec();
            assert!(bytes(&kernel(material, &[])) == bytes(&kernel(material, ANISOTROPY)), "{material}");
        }
    }
}
