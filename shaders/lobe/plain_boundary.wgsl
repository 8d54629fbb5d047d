//@ implements boundary when !dispersion
// Glass that refracts all channels alike.
fn followed_index(ior: f32, hit: Interaction) -> f32 {
    return ior;
}

// The index of the far side over that of the near one, and its contrast (lib/fresnel).
fn boundary_at(glass: Glass, hit: Interaction) -> Boundary {
    return Boundary(
        select(1.0 / glass.ior, glass.ior, hit.front),
        select(glass.contrasts.y, glass.contrasts.x, hit.front),
    );
}

// What the boundary reflects.
fn reflected_at(glass: Glass, hit: Interaction, cosine: f32, reflectance: f32) -> Reflected {
    return Reflected(vec3<f32>(1.0), reflectance);
}
