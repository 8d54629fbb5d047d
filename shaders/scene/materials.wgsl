//@ use data/material
//@ each material
//@ use material/${name}
//@ end
// What the hit surface's material makes of the ray, among just the kinds that this kernel serves.
fn scatter_by_material(material: Material, hit: Interaction, u: vec4<f32>) -> Scatter {
    switch material.kind {
        //@ each material
        ${case}: {
            return ${name}_scatter(material, hit, u);
        }
        //@ end
    }
}
