//@ use data/material
//@ use lib/microfacet
//@ use material/pbr_base
//@ use choice/transmission
//@ use choice/sheen
//@ use choice/coat
// The material of glTF 2.0 with its lobes: its base, and what its extensions add, from inside.

// A smooth metal is a mirror and nothing else.
fn pbr_is_non_specular(material: Material) -> bool {
    return !pbr_is_smooth(material) || pbr_metallic(material) < 1.0;
}

// About what comes back of the light from the view, the mean of the channels: of the base, with glass beside it, and with sheen over that.
struct PbrAlbedos {
    base: f32,
    mixed: f32,
    sheened: f32,
}

fn pbr_albedos(material: Material, hit: Interaction) -> PbrAlbedos {
    let bright = pbr_brightness(material, hit, clamp(-dot(hit.incoming, hit.normal), 0.0, 1.0));
    let base = (bright.x + bright.y) / 3.0;
    let mixed = transmission_albedo(material, hit, base);
    return PbrAlbedos(base, mixed, sheened_albedo(hit, mixed));
}

fn pbr_eval(material: Material, hit: Interaction, direction: vec3<f32>) -> Response {
    let albedos = pbr_albedos(material, hit);
    let base = base_response(material, hit, direction);
    let mixed = with_transmission(base, material, hit, direction, albedos.base);
    let sheened = with_sheen(mixed, hit, direction, albedos.mixed);
    return with_coat(sheened, hit, direction, albedos.sheened);
}
