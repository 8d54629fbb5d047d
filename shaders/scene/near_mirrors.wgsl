//@ use data/material
//@ each non_specular
//@ use material/${name}_eval
//@ end
// Near mirrors: materials that scatter into narrow lobes alone. Light sampling rarely finds a light in one, so that beside light paths they
// count as specular.

// Whether light paths start at every light, and are aimed at all that can be specular.
const FIND_ALL: bool = ${light_paths_find_all}u == 1u;

// Whether light paths find the light of this material in place of light sampling.
fn counts_as_specular(evaluated: EvaluatedMaterial) -> bool {
    if !FIND_ALL || has_lobes(evaluated.lobes) {
        return false;
    }
    switch evaluated.material.kind {
        //@ each non_specular
        case ${number}u: {
            return ${name}_is_near_mirror(evaluated.material);
        }
        //@ end
        default: {
            return false;
        }
    }
}
