//@ use data/primitive
//@ use data/ray
//@ use bind/aims
//@ use bind/settings
//@ use geometry/cuboid
//@ use light/cuboid
//@ use light/sample
//@ use scene/at_run_time
// The directions of light paths: to one of the boxes around what can be specular. A box is chosen by its solid angle times its weight, so the
// density of a direction is the weight of the boxes that hold it, over the sum of all solid angles times weights.

const AIMS: u32 = ${aims}u;

// A box keeps its weight in the word of a material.
fn weight_of_aim(index: u32) -> f32 {
    return bitcast<f32>(aims[index].material);
}

fn weight_on_ray(ray: Ray) -> f32 {
    var weight = 0.0;
    for (var i = at_run_time(0u); i < AIMS; i++) {
        let t = cuboid_crossings(cuboid_slab(ray, aims[i]));
        weight += select(0.0, weight_of_aim(i), t.x <= t.y && t.y > 0.0);
    }
    return weight;
}

// A box that is chosen by its size times weight, the sum of all of these, and what is left of the uniform number.
struct AimChoice {
    index: u32,
    sum: f32,
    rest: f32,
}

// Offers another box of this size to a choice. It is taken with the probability of its share of what was offered so far.
fn offer_box(choice: AimChoice, index: u32, own_size: f32) -> AimChoice {
    let size = own_size * weight_of_aim(index);
    let sum = choice.sum + size;
    let share = select(0.0, size / sum, size > 0.0);
    if choice.rest < share {
        return AimChoice(index, sum, choice.rest / share);
    }
    return AimChoice(choice.index, sum, min((choice.rest - share) / (1.0 - share), 1.0 - 0x1p-24f));
}

fn choose_aim(from_point: vec3<f32>, u: f32) -> AimChoice {
    var choice = AimChoice(0u, 0.0, u);
    for (var i = at_run_time(0u); i < AIMS; i++) {
        choice = offer_box(choice, i, cuboid_solid_angle(from_point, aims[i]));
    }
    return choice;
}

// A direction from a point, with its density in solid angle.
fn aim_from(from_point: vec3<f32>, u: f32, v: vec2<f32>) -> DirectionSample {
    let choice = choose_aim(from_point, u);
    if !(choice.sum > 0.0) {
        return NO_DIRECTION_SAMPLE;
    }
    let direction = cuboid_light_sample(from_point, aims[choice.index], v).direction;
    // Rounding may move a direction out of its own box.
    return DirectionSample(direction, max(weight_on_ray(Ray(from_point, direction)), weight_of_aim(choice.index)) / choice.sum);
}

// The density of a direction by aim_from.
fn density_of_aim(ray: Ray) -> f32 {
    let sum = choose_aim(ray.origin, 0.0).sum;
    return select(0.0, weight_on_ray(ray) / sum, sum > 0.0);
}
