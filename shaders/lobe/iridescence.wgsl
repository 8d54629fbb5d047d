//@ implements film when iridescence
// KHR_materials_iridescence: a thin film on the base of glTF's material, whose reflectance stands in the place of the base's own.

// The film's share of the surface. A film that is much thinner than light fades, as its index does (lib/thin_film): Schlick's approximation at its
// lower boundary would not be that of the bare base.
fn film_share(hit: Interaction) -> f32 {
    return hit.lobes.film * smoothstep(0.0, 0.03, hit.lobes.film_thickness);
}

// A reflectance with the film's share of the surface. `f0` is that of what lies below at normal incidence, and `f90` at grazing incidence.
fn with_film(reflectance: vec3<f32>, f0: vec3<f32>, f90: f32, hit: Interaction, cosine: f32) -> vec3<f32> {
    let share = film_share(hit);
    if share == 0.0 || f90 == 0.0 {
        return reflectance;
    }
    let film = f90 * thin_film(cosine, hit.lobes.film_ior, hit.lobes.film_thickness, f0 / f90);
    return (1.0 - share) * reflectance + share * film;
}

// What a boundary of glass reflects. What it does not reflect passes, by the largest channel. `cosine` is that of the outside.
fn film_on_glass(under: Reflected, hit: Interaction, cosine: f32) -> Reflected {
    let share = film_share(hit);
    if share == 0.0 || hit.f90 == 0.0 || under.chance == 1.0 {
        return under;
    }
    let film = with_film(vec3<f32>(under.chance), hit.f0, hit.f90, hit, cosine);
    let chance = max(max(film.x, film.y), film.z);
    if chance == 0.0 {
        return under;
    }
    let colour = film + (1.0 - share) * under.chance * (under.colour - 1.0);
    return Reflected(colour / chance, chance);
}

//@ without
// No material of glTF has a thin film.
fn with_film(reflectance: vec3<f32>, f0: vec3<f32>, f90: f32, hit: Interaction, cosine: f32) -> vec3<f32> {
    return reflectance;
}

fn film_on_glass(under: Reflected, hit: Interaction, cosine: f32) -> Reflected {
    return under;
}
