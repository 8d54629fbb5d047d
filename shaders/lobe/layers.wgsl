//@ each layer
//@ use lobe/${name}
//@ end
// The layers of glTF's material around its base, the outer ones first (src/lobe).

// Whether a material has a lobe that is not specular: `base` says it of its base.
fn layers_spread(material: Material, lobes: Lobes, base: bool) -> bool {
    var spreads = base;
    //@ each inner_layer
    spreads = ${name}_spreads(material, lobes, spreads);
    //@ end
    return spreads;
}

// About what comes back of the light from the view, the mean of the channels: of all that lies below each layer.
struct Albedos {
    base: f32,
    //@ each layer
    under_${name}: f32,
    //@ end
}

fn layer_albedos(material: Material, hit: Interaction, base: f32) -> Albedos {
    var albedos: Albedos;
    albedos.base = base;
    var under = base;
    //@ each inner_layer
    albedos.under_${name} = under;
    under = ${name}_albedo(material, hit, under);
    //@ end
    return albedos;
}

// The response with those of the layers around it.
fn with_layers(base: Response, material: Material, hit: Interaction, direction: vec3<f32>, albedos: Albedos) -> Response {
    var response = base;
    //@ each inner_layer
    response = with_${name}(response, material, hit, direction, albedos.under_${name});
    //@ end
    return response;
}
