//@ use bind/materials
//@ use choice/normal_map
//@ use choice/pane_evaluation
//@ use choice/shading
//@ use scene/interaction
//@ use scene/primitives
//@ use scene/surfaces
//@ each pane
//@ use material/${name}
//@ use material/${name}_eval
//@ end
// Smooth panes, which light passes straight on.

// What a smooth pane does to light from one direction.
struct Pane {
    // The share that it reflects.
    reflectance: f32,
    // The colour of what passes.
    colour: vec3<f32>,
    // False of all other surfaces.
    is_smooth: bool,
}

// Whether the material of a hit may be a smooth pane. The pane's texture of roughness decides.
fn may_be_pane(hit: Hit) -> bool {
    // The sky and lights without size have no surface.
    if primitive_kind(hit.code) >= KIND_DELTA_LIGHT {
        return false;
    }
    switch materials[material_index(hit)].kind {
        //@ each pane
        case ${number}u: {
            return true;
        }
        //@ end
        default: {
            return false;
        }
    }
}

fn pane_at(hit: Hit, ray: Ray) -> Pane {
    var pane: Pane;
    if !may_be_pane(hit) {
        return pane;
    }
    let surface = surface_at(hit, ray);
    let frame = shading_frame(hit, surface, ray.direction);
    let evaluated = evaluate_pane(hit, surface, frame.front);
    let normal = mapped_normal(hit, surface, ray.direction, frame.shading, frame.front, evaluated.normal);
    let cos_view = clamp(-dot(ray.direction, normal), 0.0, 1.0);
    switch evaluated.material.kind {
        //@ each pane
        ${case}: {
            pane.is_smooth = !${name}_is_non_specular(evaluated.material);
            pane.reflectance = ${name}_reflectance(evaluated.material, cos_view);
        }
        //@ end
    }
    pane.colour = evaluated.colour;
    return pane;
}
