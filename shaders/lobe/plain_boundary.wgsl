//@ implements boundary when !dispersion
//@ use data/material
// Glass that refracts all channels alike.
fn followed_index(ior: f32, hit: Interaction) -> f32 {
    return ior;
}

// The index of the far side over that of the near one, and its contrast (lib/fresnel).
fn boundary_at(material: Material, ior: f32, hit: Interaction) -> Boundary {
    return Boundary(
        select(1.0 / ior, ior, hit.front),
        select(material.contrast_inside, material.contrast_outside, hit.front),
    );
}

// What the boundary reflects.
fn reflected_at(material: Material, ior: f32, hit: Interaction, cosine: f32, reflectance: f32) -> Reflected {
    return Reflected(vec3<f32>(1.0), reflectance);
}
