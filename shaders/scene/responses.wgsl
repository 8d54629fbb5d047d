//@ use lobe/layers
//@ each non_specular
//@ use material/${name}_eval
//@ end
// The response of materials to light from a given direction. Specular materials have none.

// Whether the material scatters to more than one direction.
fn is_non_specular(evaluated: EvaluatedMaterial) -> bool {
    return layers_spread(evaluated.material, evaluated.lobes, kind_is_non_specular(evaluated.material));
}

fn kind_is_non_specular(material: Material) -> bool {
    switch material.kind {
        //@ each non_specular
        case ${number}u: {
            return ${name}_is_non_specular(material);
        }
        //@ end
        default: {
            return false;
        }
    }
}

// Whether the material responds to light from the far side of the surface too.
fn responds_on_both_sides(evaluated: EvaluatedMaterial) -> bool {
    switch evaluated.material.kind {
        //@ each both_sided
        case ${number}u: {
            return true;
        }
        //@ end
        default: {
            return evaluated.lobes.transmission > 0.0 || evaluated.lobes.through > 0.0;
        }
    }
}

fn response_of_material(material: Material, hit: Interaction, direction: vec3<f32>) -> Response {
    switch material.kind {
        //@ each non_specular
        case ${number}u: {
            return ${name}_eval(material, hit, direction);
        }
        //@ end
        default: {
            return no_response();
        }
    }
}
