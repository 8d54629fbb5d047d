//@ use data/path
//@ use data/window
//@ use bind/counters
//@ use data/material
//@ use lib/rng
// Light through clear solids. No ray is sent to a light through glass, since glass bends it: such light is met by chance alone, of small lights so
// seldom that an image may seem free of noise and lack it. So what glass kept from rays to lights is counted, and what paths have met
// behind glass in its place: about as much light leaves a clear solid as enters it, if elsewhere.

// Of a path's counts, while its sample lasts: an event of it sampled lights, and since then a clear solid has bent it.
const HAS_SAMPLED_LIGHTS: u32 = 0x20000000u;
const BEHIND_GLASS: u32 = 0x40000000u;

fn is_clear(material: Material) -> bool {
    switch material.kind {
        //@ each clear
        case ${number}u: {
            return true;
        }
        //@ end
        default: {
            return false;
        }
    }
}

// A clear solid stopped a ray to a light, which would have brought so much.
fn note_stopped_light(path: ptr<function, Path>, radiance: vec3<f32>) {
    let added = units_of_light(path, radiance);
    let before = atomicAdd(&counters.stopped_low, added);
    if before + added < before {
        atomicAdd(&counters.stopped_high, 1u);
    }
}

// The path met a light, which brings so much.
fn note_met_light(path: ptr<function, Path>, radiance: vec3<f32>) {
    if ((*path).counts & BEHIND_GLASS) != 0u {
        let added = units_of_light(path, radiance);
        let before = atomicAdd(&counters.met_low, added);
        if before + added < before {
            atomicAdd(&counters.met_high, 1u);
        }
    }
}

// An event has sampled lights.
fn note_sampling(path: ptr<function, Path>) {
    (*path).counts = ((*path).counts & ~BEHIND_GLASS) | HAS_SAMPLED_LIGHTS;
}

// The path was scattered by a material.
fn note_glass(path: ptr<function, Path>, material: Material) {
    if ((*path).counts & HAS_SAMPLED_LIGHTS) != 0u && is_clear(material) {
        (*path).counts |= BEHIND_GLASS;
    }
}

fn forget_glass(path: ptr<function, Path>) {
    (*path).counts &= ~(HAS_SAMPLED_LIGHTS | BEHIND_GLASS);
}

// The largest component in units of 2^-24, of the device's unit of radiance; what is less than one is rounded up as often as it is worth.
fn units_of_light(path: ptr<function, Path>, radiance: vec3<f32>) -> u32 {
    let most = min(max(max(abs(radiance.x), abs(radiance.y)), abs(radiance.z)), 100.0);
    let chance = pcg4d(vec4<u32>((*path).pixel, (*path).sample, (*path).events, (*path).rays)).x;
    return u32(most * 16777216.0 + f32(chance >> 8u) * 5.9604645e-8);
}
