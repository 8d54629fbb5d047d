//@ use lobe/layers
//@ use material/pbr_base
// The material of glTF 2.0 with its lobes: its base, and what its extensions add, from inside.

// A smooth metal is a mirror and nothing else.
fn pbr_is_non_specular(material: Material) -> bool {
    return !pbr_is_smooth(material) || pbr_metallic(material) < 1.0;
}

fn pbr_albedos(material: Material, hit: Interaction) -> Albedos {
    let bright = pbr_brightness(material, hit, clamp(-dot(hit.incoming, hit.normal), 0.0, 1.0));
    return layer_albedos(material, hit, (bright.x + bright.y) / 3.0);
}

fn pbr_eval(material: Material, hit: Interaction, direction: vec3<f32>) -> Response {
    return with_layers(base_response(material, hit, direction), material, hit, direction, pbr_albedos(material, hit));
}
