//@ implements multiscatter when multiscatter
//@ use bind/extensions
//@ use scene/directional_albedo
// Single scattering loses the light that microfacets scatter more than once. A material makes up for it by the factor 1 + F0 (1 - E) / E,
// with E the directional albedo of a white metal (Turquin, "Practical Multiple Scattering Compensation for Microfacet Models", 2019). The
// factor depends on the view alone, so directions are sampled as before.

// Returns (1 - E) / E; 0 for a material that does not make up for the loss.
fn energy_compensation(material: Material, surface: Surface, hit: Interaction) -> f32 {
    if extensions[surface.material].multiscatter == NO_EXTENSION {
        return 0.0;
    }
    let albedo = directional_albedo(clamp(-dot(hit.incoming, hit.normal), 0.0, 1.0), material.${pbr.roughness});
    return (1.0 - albedo) / albedo;
}

// Returns a reflectance with the light that single scattering loses. `f0` is the reflectance at normal incidence.
fn compensated(reflectance: vec3<f32>, f0: vec3<f32>, hit: Interaction) -> vec3<f32> {
    return reflectance * (1.0 + f0 * hit.compensation);
}

//@ without
// No material has energy compensation.
fn energy_compensation(material: Material, surface: Surface, hit: Interaction) -> f32 {
    return hit.compensation;
}

fn compensated(reflectance: vec3<f32>, f0: vec3<f32>, hit: Interaction) -> vec3<f32> {
    return reflectance;
}
