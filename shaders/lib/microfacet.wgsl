// Rough surfaces of microfacets: the distribution of Trowbridge and Reitz, also called GGX, and Smith's masking and shadowing
// with correlated heights (Walter, Marschner, Li, Torrance, "Microfacet Models for Refraction through Rough Surfaces", EGSR
// 2007; Heitz, "Understanding the Masking-Shadowing Function in Microfacet-Based BRDFs", JCGT 3(2), 2014). alpha is the
// square of the perceptual roughness, as glTF has it. The view is the side from which the ray comes. All cosines are not negative.

// A roughness below this makes a smooth surface. Its alpha is 2^-20, and the f32 components of directions are rounded by up to
// 2^-25: they cannot represent narrower lobes.
const LEAST_ROUGHNESS: f32 = 0x1p-10f;

// The direction in which a smooth surface mirrors a ray. It is made a unit vector twice, so that it has the bytes of a metal without fuzz.
fn mirror_direction(incoming: vec3<f32>, normal: vec3<f32>) -> vec3<f32> {
    return normalize(normalize(incoming - 2.0 * dot(incoming, normal) * normal));
}

// Whether a boundary of a transmissive solid is rough: `contrast` is (ior - 1)(ior + 1). Where the index is close to 1, the refracted lobe
// is narrow by as much.
fn is_rough_boundary(alpha: f32, contrast: f32) -> bool {
    return alpha * min(abs(contrast), 1.0) >= LEAST_ROUGHNESS * LEAST_ROUGHNESS;
}

// The width of the lobe that microfacets reflect, in radians: half of the normals have a tangent of at most alpha to the surface's normal,
// and a mirrored direction turns twice as far as its mirror.
fn width_of_reflection(alpha: f32) -> f32 {
    return 2.0 * alpha;
}

// The width of the lobe that they refract: by Snell's law, a microfacet that turns by an angle turns a ray at normal incidence by
// 1 - 1/eta of it, with eta the index of the far side over that of the near side.
fn width_of_refraction(alpha: f32, eta: f32) -> f32 {
    return alpha * abs(1.0 - 1.0 / eta);
}

// The density of microfacet normals at the direction of `along`, a vector of any length on the side of the unit normal:
// alpha^2 / (pi (alpha^2 cos^2 + sin^2)^2). The sine is computed from the part across the normal, since 1 - cos^2 has no correct
// digits in narrow lobes. The ratio is squared last, so that nothing underflows.
fn microfacet_density(along: vec3<f32>, normal: vec3<f32>, alpha: f32) -> f32 {
    let height = dot(along, normal);
    let across = along - height * normal;
    let sine2 = dot(across, across);
    let length2 = height * height + sine2;
    if !(length2 > 0.0) {
        return 0.0;
    }
    let ratio = length2 / (alpha * alpha * height * height + sine2);
    return alpha * alpha * ratio * ratio / PI;
}

// sqrt(cos^2 + alpha^2 sin^2): the cosine times 1 + 2 Lambda, with Smith's Lambda of a direction.
fn smith_root(cosine: f32, alpha: f32) -> f32 {
    return sqrt(cosine * cosine + alpha * alpha * (1.0 - cosine) * (1.0 + cosine));
}

// The share of the microfacets visible from the view that light from another direction reaches: G2 / G1.
fn smith_shadowing(cos_view: f32, cos_light: f32, alpha: f32) -> f32 {
    let root_view = smith_root(cos_view, alpha);
    return cos_light * (cos_view + root_view) / (cos_light * root_view + cos_view * smith_root(cos_light, alpha));
}

// The density of the visible microfacet normals over their cosine with the view: G1 D / cos_view. A reflection makes a quarter
// of it the density of directions. This form has no cosine below the line, so that grazing views keep their digits.
fn visible_density(density: f32, cos_view: f32, alpha: f32) -> f32 {
    return 2.0 * density / (cos_view + smith_root(cos_view, alpha));
}

// A microfacet normal, by the density with which the view sees them. Both are around +z. The view is stretched to the surface of
// alpha 1, where the visible normals are the sum of the view and a point of a spherical cap: (Dupuy and Benyoub, "Sampling Visible
// GGX Normals with Spherical Caps", CGF 42(8), 2023). The z of the sum is (1 - u)(1 + view.z), which is always positive.
fn sample_visible_normal(view: vec3<f32>, alpha: f32, u: vec2<f32>) -> vec3<f32> {
    let stretched = normalize(vec3<f32>(alpha * view.xy, view.z));
    let from_top = u.x * (1.0 + stretched.z);
    let across = sqrt(from_top * (2.0 - from_top)) * sample_circle(u.y) + stretched.xy;
    return normalize(vec3<f32>(alpha * across, (1.0 - u.x) * (1.0 + stretched.z)));
}
