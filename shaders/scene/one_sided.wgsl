//@ implements one_sided when one_sided
//@ use bind/extensions
// Surfaces with a black back. Emission leaves the front alone (extension/emission).

// Whether a path that comes from this side meets a black back.
fn is_behind(surface: Surface, front: bool) -> bool {
    return !front && extensions[surface.material].one_sided != NO_EXTENSION;
}

// A path that meets it has no throughput from then on, and ends.
fn absorb_behind(throughput: vec3<f32>, surface: Surface, front: bool) -> vec3<f32> {
    return select(throughput, vec3<f32>(0.0), is_behind(surface, front));
}

//@ without
// The backs of surfaces are as their fronts.
fn is_behind(surface: Surface, front: bool) -> bool {
    return false;
}

fn absorb_behind(throughput: vec3<f32>, surface: Surface, front: bool) -> vec3<f32> {
    return throughput;
}
