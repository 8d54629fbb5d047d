//@ implements panes when pane
//@ use bind/settings
//@ use choice/crossings
//@ use choice/flight_end
//@ use choice/passed_panes
//@ use choice/walk
//@ use scene/panes
//@ use scene/surface_random
// Smooth panes let light pass straight on, which is no event: a path keeps its ray, the density of its direction and its depth. A path is
// reflected with the probability of the reflectance, or else passes. A shadow ray passes with the transmittance as a factor. A ray keeps
// the origin at its event, so both strategies of MIS have the densities that they have in air.

// What passing a pane takes of the steps of a walk.
const STEPS_OF_PANE: u32 = ${pane_steps}u;

// The nearest hit of the path's ray on a surface that does not let it pass. The path takes the colours of the panes before it.
fn hit_of_path(path: ptr<function, Path>) -> Hit {
    let ray = (*path).ray;
    // A pane behind an event in a medium does not count.
    var steps = 0u;
    let end = end_of_flight(path, VERY_FAR, &steps);
    var limit = hit_at(HIT_NOTHING, VERY_FAR);
    limit.steps = steps;
    var hit: Hit;
    pass_no_pane();
    loop {
        hit = sided_hit(first_hit(ray, settings.root, limit, false), ray);
        let pane = pane_at(hit, ray);
        if !pane.is_smooth || is_reflected(path, hit, pane.reflectance) {
            break;
        }
        (*path).throughput *= select(vec3<f32>(1.0), pane.colour, hit.t < end);
        pass_pane(hit);
        limit.steps = hit.steps + STEPS_OF_PANE;
    }
    return hit;
}

// Each crossing has random numbers of its own, whatever the order of the walk.
fn is_reflected(path: ptr<function, Path>, hit: Hit, reflectance: f32) -> bool {
    let dimension = bounce_dimension((*path).depth, DIMENSION_SCATTER);
    let side = select(NEAR_SIDE_OF_PANE, FAR_SIDE_OF_PANE, hit.instance == FAR_SIDE);
    return random_of_surface((*path).pixel, (*path).sample, dimension, hit, side) < reflectance;
}

// The first hit of the shadow ray up to the one on its light. It takes the transmittance of the panes before it.
fn hit_of_shadow(path: ptr<function, Path>, limit: Hit) -> Hit {
    let ray = (*path).shadow;
    var rest = limit;
    (*path).transmittance = vec3<f32>(1.0);
    var hit: Hit;
    pass_no_pane();
    loop {
        hit = sided_hit(first_hit(ray, settings.root, rest, true), ray);
        let pane = pane_at(hit, ray);
        if !pane.is_smooth {
            break;
        }
        (*path).transmittance *= (1.0 - pane.reflectance) * pane.colour;
        pass_pane(hit);
        rest.steps = hit.steps + STEPS_OF_PANE;
    }
    return hit;
}

// Returns the light that a shadow ray brings through panes.
fn pass_panes(path: ptr<function, Path>, light: vec3<f32>) -> vec3<f32> {
    return (*path).transmittance * light;
}
