//@ implements mix when mix
//@ use bind/extensions
//@ use bind/materials
//@ use bind/settings
//@ use choice/sampler
//@ use material/mix
//@ use scene/extensions
//@ use scene/surfaces
// Mixes of two materials. Each event has one of them, by a random number of its own. All strategies that can make a path meet a part with the
// same probability, so that it cancels in their MIS weights.

// Tells its random numbers from those of other decisions in the same block.
const PART_OF_MIX: u32 = 0x6d6978u;

// The surface at the path's event, with the part of a mix that the event has.
fn surface_of_event(path: ptr<function, Path>, hit: Hit) -> Surface {
    let surface = surface_at(hit, (*path).ray);
    let number = extensions[surface.material].mix;
    if number == NO_EXTENSION {
        return surface;
    }
    let dimension = bounce_dimension((*path).depth, DIMENSION_SCATTER);
    let u = random4((*path).pixel, (*path).sample, dimension, settings.seed ^ PART_OF_MIX).x;
    return part_of_mix(materials[number], surface, u < extension_colour(number, hit, surface).x);
}

// The kind of material of the event.
fn kind_of_event(path: ptr<function, Path>, hit: Hit) -> u32 {
    return materials[surface_of_event(path, hit).material].kind;
}

//@ without
//@ use bind/materials
//@ use scene/surfaces
// No material is a mix.
fn surface_of_event(path: ptr<function, Path>, hit: Hit) -> Surface {
    return surface_at(hit, (*path).ray);
}

fn kind_of_event(path: ptr<function, Path>, hit: Hit) -> u32 {
    return materials[material_index(hit)].kind;
}
