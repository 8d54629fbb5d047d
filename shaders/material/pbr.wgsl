//@ use lobe/layers
//@ use material/pbr_base
//@ use material/pbr_eval
// The material of glTF 2.0: matt and glossy, or a metal, and what its extensions add. One of its lobes is drawn, and the weight is that of all
// of them, so that no direction is noisier for the choice. Smooth microfacets are a lobe of one direction, whose weight is its own.
fn pbr_scatter(material: Material, hit: Interaction, u: vec4<f32>) -> Scatter {
    let albedos = pbr_albedos(material, hit);
    var draw = begin_draw(u.x);
    //@ each layer
    draw = draw_${name}(draw, material, hit, u.zw, albedos.under_${name});
    let is_below_${name} = !draw.is_drawn;
    //@ end
    var found = draw_base(draw, material, hit, u.zw).scatter;
    //@ each inner_layer
    if is_below_${name} {
        found = below_${name}(found, hit);
    }
    //@ end
    if found.event != SCATTERED || found.lobe == LOBE_SPECULAR {
        return found;
    }
    let response = pbr_eval(material, hit, found.direction);
    if !(response.pdf > 0.0) {
        return absorbed();
    }
    return scatter_towards(found.direction, response.value / response.pdf, found.lobe);
}
