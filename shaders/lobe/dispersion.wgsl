//@ implements boundary when dispersion
//@ use choice/fresnel
// KHR_materials_dispersion: the index of refraction is that of one channel, which the path follows (step/followed_channel). Red, green and blue
// have ior - s, ior and ior + s.

// The index that differs by this from that of green.
fn shifted_boundary(glass: Glass, front: bool, shift: f32) -> Boundary {
    let own = glass.ior + shift;
    let outside = glass.contrasts.x + shift * (2.0 * glass.ior + shift);
    return Boundary(select(1.0 / own, own, front), select(-outside / (own * own), outside, front));
}

fn followed_index(ior: f32, hit: Interaction) -> f32 {
    return ior + hit.followed * hit.lobes.dispersion;
}

fn boundary_at(glass: Glass, hit: Interaction) -> Boundary {
    if hit.lobes.dispersion == 0.0 {
        return Boundary(
            select(1.0 / glass.ior, glass.ior, hit.front),
            select(glass.contrasts.y, glass.contrasts.x, hit.front),
        );
    }
    return shifted_boundary(glass, hit.front, hit.followed * hit.lobes.dispersion);
}

// What the boundary reflects. `reflectance` is that of the followed channel, by which it is drawn. Light that is reflected keeps all channels.
fn reflected_at(glass: Glass, hit: Interaction, cosine: f32, reflectance: f32) -> Reflected {
    if hit.lobes.dispersion == 0.0 || reflectance == 0.0 {
        return Reflected(vec3<f32>(1.0), reflectance);
    }
    let red = shifted_boundary(glass, hit.front, -hit.lobes.dispersion);
    let green = shifted_boundary(glass, hit.front, 0.0);
    let blue = shifted_boundary(glass, hit.front, hit.lobes.dispersion);
    let all = vec3<f32>(
        fresnel(cosine, red.eta, red.contrast).reflectance,
        fresnel(cosine, green.eta, green.contrast).reflectance,
        fresnel(cosine, blue.eta, blue.contrast).reflectance,
    );
    return Reflected(all / reflectance, reflectance);
}
