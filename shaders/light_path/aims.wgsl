//@ use bind/aims
//@ use bind/settings
//@ use geometry/cuboid
//@ use light/cuboid
//@ use light/sample
//@ use scene/at_run_time
// The directions of light paths: to one of the boxes around what can be specular. A box is chosen by its solid angle times its weight, so the
// density of a direction is the weight of the boxes that hold it, over the sum of all solid angles times weights. A box around a start holds
// all directions. A light does not aim at the box around itself alone: it is flat or convex, and its paths leave it.

const AIMS: u32 = ${aims}u;

// A box keeps its weight in the word of a material.
fn weight_of_aim(index: u32) -> f32 {
    return bitcast<f32>(aims[index].material);
}

// Whether light paths of the light with this code are aimed at a box. A box keeps the code of a primitive that is alone in it in the word of a light.
fn is_aimed_at(index: u32, light: u32) -> bool {
    return aims[index].light != light;
}

// The weight of the boxes that a light's ray meets beyond a distance. One around its origin is one of them: where the origin is strictly inside, each
// of the ray's differences to the faces ahead is above 0.
fn weight_on_ray(ray: Ray, light: u32, beyond: f32) -> f32 {
    var weight = 0.0;
    for (var i = at_run_time(0u); i < AIMS; i++) {
        let t = cuboid_crossings(cuboid_slab(ray, aims[i]));
        weight += select(0.0, weight_of_aim(i), t.x <= t.y && t.y > beyond && is_aimed_at(i, light));
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

fn choose_aim(from_point: vec3<f32>, light: u32, u: f32) -> AimChoice {
    var choice = AimChoice(0u, 0.0, u);
    for (var i = at_run_time(0u); i < AIMS; i++) {
        if is_aimed_at(i, light) {
            choice = offer_box(choice, i, cuboid_solid_angle(from_point, aims[i]));
        }
    }
    return choice;
}

// A direction from a point of the light with this code, with its density in solid angle.
fn aim_from(from_point: vec3<f32>, light: u32, u: f32, v: vec2<f32>) -> DirectionSample {
    let choice = choose_aim(from_point, light, u);
    if !(choice.sum > 0.0) {
        return NO_DIRECTION_SAMPLE;
    }
    let direction = cuboid_light_sample(from_point, aims[choice.index], v).direction;
    // Rounding may move a direction out of its own box.
    let weight = max(weight_on_ray(Ray(from_point, direction), light, 0.0), weight_of_aim(choice.index));
    return DirectionSample(direction, weight / choice.sum);
}

// The density of a direction by aim_from.
fn density_of_aim(ray: Ray, light: u32) -> f32 {
    let sum = choose_aim(ray.origin, light, 0.0).sum;
    return select(0.0, weight_on_ray(ray, light, 0.0) / sum, sum > 0.0);
}
