//@ implements boundary when dispersion
//@ use data/material
//@ use choice/fresnel
// KHR_materials_dispersion: the index of refraction is that of one channel, which the path follows (step/followed_channel). Red, green and blue
// have ior - s, ior and ior + s.

// The index that differs by this from that of green.
fn shifted_boundary(material: Material, ior: f32, front: bool, shift: f32) -> Boundary {
    let own = ior + shift;
    let outside = material.contrast_outside + shift * (2.0 * ior + shift);
    return Boundary(select(1.0 / own, own, front), select(-outside / (own * own), outside, front));
}

fn followed_index(ior: f32, hit: Interaction) -> f32 {
    return ior + hit.followed * hit.lobes.dispersion;
}

fn boundary_at(material: Material, ior: f32, hit: Interaction) -> Boundary {
    if hit.lobes.dispersion == 0.0 {
        return Boundary(
            select(1.0 / ior, ior, hit.front),
            select(material.contrast_inside, material.contrast_outside, hit.front),
        );
    }
    return shifted_boundary(material, ior, hit.front, hit.followed * hit.lobes.dispersion);
}

// What the boundary reflects. `reflectance` is that of the followed channel, by which it is drawn. Light that is reflected keeps all channels.
fn reflected_at(material: Material, ior: f32, hit: Interaction, cosine: f32, reflectance: f32) -> Reflected {
    if hit.lobes.dispersion == 0.0 || reflectance == 0.0 {
        return Reflected(vec3<f32>(1.0), reflectance);
    }
    let red = shifted_boundary(material, ior, hit.front, -hit.lobes.dispersion);
    let green = shifted_boundary(material, ior, hit.front, 0.0);
    let blue = shifted_boundary(material, ior, hit.front, hit.lobes.dispersion);
    let all = vec3<f32>(
        fresnel(cosine, red.eta, red.contrast).reflectance,
        fresnel(cosine, green.eta, green.contrast).reflectance,
        fresnel(cosine, blue.eta, blue.contrast).reflectance,
    );
    return Reflected(all / reflectance, reflectance);
}
