//@ use data/material
//@ use material/pbr_base
//@ use material/pbr_eval
//@ use choice/transmission
//@ use choice/sheen
//@ use choice/coat
// The material of glTF 2.0: matt and glossy, or a metal, and what its extensions add. One of its lobes is drawn, and the weight is that of all
// of them, so that no direction is noisier for the choice. Smooth microfacets are a lobe of one direction, whose weight is its own.
fn pbr_scatter(material: Material, hit: Interaction, u: vec4<f32>) -> Scatter {
    let albedos = pbr_albedos(material, hit);
    let coat = draw_coat(begin_draw(u.x), hit, u.zw, albedos.sheened);
    let outer = draw_sheen(coat, hit, u.zw, albedos.mixed);
    let mixed = draw_transmission(outer, material, hit, u.zw, albedos.base);
    let found = below_sheen(draw_base(mixed, material, hit, u.zw).scatter, hit, outer);
    if found.event != SCATTERED || found.lobe == LOBE_SPECULAR {
        return found;
    }
    let response = pbr_eval(material, hit, found.direction);
    if !(response.pdf > 0.0) {
        return absorbed();
    }
    return scatter_towards(found.direction, response.value / response.pdf, found.lobe);
}
