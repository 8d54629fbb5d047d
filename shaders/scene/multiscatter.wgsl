//@ use data/material
//@ use data/surface
//@ use bind/extensions
//@ use scene/kept_share
// Light that microfacets scatter more than once. Single scattering loses it; with this times the reflectance for light straight on the
// surface, a material makes up for it (Turquin, "Practical Multiple Scattering Compensation for Microfacet Models", 2019). It depends on
// the view alone, so directions are drawn as before.
fn lost_over_kept(material: Material, surface: Surface, hit: Interaction) -> f32 {
    if extensions[surface.material].multiscatter == NO_EXTENSION {
        return 0.0;
    }
    let kept = kept_share(clamp(-dot(hit.incoming, hit.normal), 0.0, 1.0), material.parameter);
    return (1.0 - kept) / kept;
}

// A reflectance with the light that single scattering loses. `straight` is that of light straight on the surface.
fn with_lost_light(reflectance: vec3<f32>, straight: vec3<f32>, hit: Interaction) -> vec3<f32> {
    return reflectance * (1.0 + straight * hit.lost_over_kept);
}
