//@ each material
//@ use material/${name}
//@ end
// Samples the material at a hit. It has only the kinds of material that this kernel serves.
fn scatter_by_material(material: Material, hit: Interaction, u: vec4<f32>) -> Scatter {
    switch material.kind {
        //@ each material
        ${case}: {
            return ${name}_scatter(material, hit, u);
        }
        //@ end
    }
}
