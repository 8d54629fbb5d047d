//@ implements light_parts when parted
//@ use bind/lights
//@ use light/parts
//@ each parted_emitter
//@ use light/${name}_parts
//@ end
// Lights that are parts of their shapes.

// The index of the light that a ray hit, by the entry of its shape. `local` is that of the surface.
fn part_at_hit(index: u32, hit: Hit, local: vec3<f32>) -> u32 {
    if index >= NOT_SAMPLED || lights[index].part != PARTS {
        return index;
    }
    var coordinates = vec2<f32>(0.0);
    switch primitive_kind(hit.code) {
        //@ each parted_emitter
        case ${number}u: {
            coordinates = ${name}_part_coordinates(local);
        }
        //@ end
        default: {}
    }
    // A point on the last edge belongs to the cell before it.
    let at = coordinates * (1.0 - 0x1p-20f);
    let last = lights[index].trail + lights[index].instance - 1u;
    var part = lights[index].trail;
    while part < last && !part_holds(lights[part].part, at, primitive_kind(hit.code) == KIND_TRIANGLE) {
        part += 1u;
    }
    return part;
}

// The part of its shape that a light is.
fn part_of_light(index: u32) -> u32 {
    if index >= NOT_SAMPLED {
        return 0u;
    }
    return lights[index].part;
}

//@ without
// Each shape that is a light is one.
fn part_at_hit(index: u32, hit: Hit, local: vec3<f32>) -> u32 {
    return index;
}

fn part_of_light(index: u32) -> u32 {
    return 0u;
}
