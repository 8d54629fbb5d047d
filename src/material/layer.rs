//! The light that a clear layer on a body lets pass and reflects, smooth or of microfacets: integrals that kernels have as numbers and as a table.

use std::f64::consts::PI;

use super::declared::Distribution;

/// The elements of a table, for equal steps of the cosine's square root, as LAYER_COLUMNS of shaders/lobe/rough_layer.
const COLUMNS: usize = 64;
/// Midpoints of the integral over slopes each way, and of that over cosines.
const RINGS: u32 = 64;
const SECTORS: u32 = 32;
const COSINES: u32 = 128;

/// A boundary, with the index of its far side over that of its near side.
#[derive(Clone, Copy)]
pub struct Layer {
    pub eta: f64,
    /// 0 where it is smooth.
    pub alpha: f64,
    pub distribution: Distribution,
}

impl Layer {
    /// The share of light at a cosine that it reflects, and that it lets pass. Rough ones lose the light that microfacets would scatter more than once.
    fn shares(&self, cosine: f64) -> [f64; 2] {
        if self.alpha == 0.0 {
            let reflected = self.fresnel(cosine).0;
            return [reflected, 1.0 - reflected];
        }
        let sine = (1.0 - cosine * cosine).sqrt();
        let of_view = self.smith_root(cosine);
        // G2 / G1.
        let kept = |cos_light: f64| match cos_light > 0.0 {
            true => {
                cos_light * (cosine + of_view) / (cos_light * of_view + cosine * self.smith_root(cos_light.min(1.0)))
            }
            false => 0.0,
        };
        let (mut shares, mut area) = ([0.0; 2], 0.0);
        for (ring, sector) in (0..RINGS).flat_map(|ring| (0..SECTORS).map(move |sector| (ring, sector))) {
            // The square root of the share of the steeper slopes.
            let steeper = (f64::from(ring) + 0.5) / f64::from(RINGS);
            let slope = match self.distribution {
                Distribution::Ggx => (steeper.powi(-2) - 1.0).sqrt(),
                Distribution::Beckmann => (-2.0 * steeper.ln()).sqrt(),
            };
            let azimuth = PI * (f64::from(sector) + 0.5) / f64::from(SECTORS);
            // The area of these microfacets towards the view.
            let seen = cosine + self.alpha * slope * azimuth.cos() * sine;
            if seen <= 0.0 {
                continue;
            }
            let cos_normal = (1.0 + (self.alpha * slope).powi(2)).sqrt().recip();
            let cos_facet = (seen * cos_normal).min(1.0);
            let (reflectance, cos_passed) = self.fresnel(cos_facet);
            area += steeper * seen;
            shares[0] += steeper * seen * reflectance * kept(2.0 * cos_facet * cos_normal - cosine);
            let below = (cosine - cos_facet * cos_normal) / self.eta + cos_passed * cos_normal;
            shares[1] += steeper * seen * (1.0 - reflectance) * kept(below);
        }
        shares.map(|share| share / area)
    }

    /// Fresnel's reflectance, and the cosine on the far side.
    fn fresnel(&self, cosine: f64) -> (f64, f64) {
        let cos_passed = (1.0 - (1.0 - cosine * cosine) / (self.eta * self.eta)).max(0.0).sqrt();
        let ratio = |near: f64, far: f64| (near - far) / (near + far).max(f64::MIN_POSITIVE);
        let (across, along) = (ratio(cosine, self.eta * cos_passed), ratio(self.eta * cosine, cos_passed));
        let reflectance = 0.5 * (across * across + along * along);
        if cos_passed == 0.0 { (1.0, 0.0) } else { (reflectance, cos_passed) }
    }

    /// The cosine times 1 + 2 Lambda, as smith_root and beckmann_root of shaders/lib.
    fn smith_root(&self, cosine: f64) -> f64 {
        let spread = self.alpha * (1.0 - cosine * cosine).sqrt();
        let steepness = cosine / spread.max(f64::MIN_POSITIVE);
        match self.distribution {
            Distribution::Ggx => cosine.hypot(spread),
            Distribution::Beckmann => {
                cosine * libm::erf(steepness) + spread * (-steepness * steepness).exp() / PI.sqrt()
            }
        }
    }

    /// The share that passes, at each cosine of the table.
    pub fn table(&self) -> Vec<f64> {
        let cosine = |column: usize| (column as f64 / (COLUMNS - 1) as f64).powi(2);
        (0..COLUMNS).map(|column| self.shares(cosine(column))[1]).collect()
    }

    /// The share of light from all directions, by their cosines, that it reflects.
    pub fn mean_reflectance(&self) -> f64 {
        let roots = (0..COSINES).map(|i| (f64::from(i) + 0.5) / f64::from(COSINES));
        roots.map(|root| 4.0 * root.powi(3) * self.shares(root * root)[0]).sum::<f64>() / f64::from(COSINES)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// As much light enters a layer on all ways as leaves it, but for the index squared: Stokes' reciprocity, which no part of the integral has
    /// built in. Midpoints are off by less than a thousandth.
    #[test]
    fn as_much_enters_as_leaves() {
        for (ior, alpha) in [(1.5, 0.1), (1.5, 0.5), (2.4, 0.25), (1.1, 1.0)] {
            for distribution in [Distribution::Ggx, Distribution::Beckmann] {
                let mean = |eta: f64, alpha: f64| {
                    let layer = Layer { eta, alpha, distribution };
                    let roots = (0..256).map(|i| (f64::from(i) + 0.5) / 256.0);
                    roots.map(|root| 4.0 * root.powi(3) * layer.shares(root * root)[1]).sum::<f64>() / 256.0
                };
                let (enters, leaves) = (mean(ior, alpha), ior * ior * mean(1.0 / ior, alpha));
                assert!(
                    (enters - leaves).abs() < 1e-3 * enters,
                    "{ior}, {alpha}, {distribution:?}: {enters}, {leaves}"
                );
                let once = ior * mean(1.0 / ior, alpha);
                assert!((enters - once).abs() > 1e-3 * enters, "{ior}, {alpha}, {distribution:?}: {enters}, {once}");
            }
        }
    }

    /// Walsh's formula gives 0.09178 from outside at an index of 1.5, so 0.59635 from inside; and nothing passes but what is not reflected.
    #[test]
    fn smooth_layers_reflect_as_is_known() {
        let layer = |eta| Layer { eta, alpha: 0.0, distribution: Distribution::Ggx };
        assert!((layer(1.5).mean_reflectance() - 0.09178).abs() < 2e-5, "{}", layer(1.5).mean_reflectance());
        assert_eq!(layer(1.0 / 1.5).shares(0.5), [1.0, 0.0]);
        assert!((layer(1.5).shares(1.0)[1] - 0.96).abs() < 1e-12);
    }
}
