//@ use light/cuboid
//@ use light_path/aims
// Light paths of directional lights: parallel rays to the boxes, each uniform in the area of a box's shadow.

// The distance from which such rays come: beyond everything but large spheres. (Render space has an extent near 1.)
const BEYOND_SCENE: f32 = 4.0;

// The origin of a ray in this direction, with its density over the area across.
struct ParallelAim {
    origin: vec3<f32>,
    density: f32,
}

// A box is chosen by the area of its shadow times its weight.
fn choose_parallel_aim(direction: vec3<f32>, u: f32) -> AimChoice {
    var choice = AimChoice(0u, 0.0, u);
    for (var i = at_run_time(0u); i < AIMS; i++) {
        let shadow = cuboid_shadow(direction, aims[i]);
        choice = offer_box(choice, i, shadow.x + shadow.y + shadow.z);
    }
    return choice;
}

// A ray of the light with this code.
fn aim_parallel(direction: vec3<f32>, light: u32, u: f32, v: vec2<f32>) -> ParallelAim {
    let choice = choose_parallel_aim(direction, u);
    if !(choice.sum > 0.0) {
        return ParallelAim(vec3<f32>(0.0), 0.0);
    }
    let box_ahead = aims[choice.index];
    let face = choose_axis(cuboid_shadow(direction, box_ahead), v.x);
    let along = to_cuboid(box_ahead, direction);
    let side = select(1.0, -1.0, along[face.axis] > 0.0);
    let point = box_ahead.center + cuboid_face_point(box_ahead, face.axis, side, vec2<f32>(face.rest, v.y));
    let weight = max(weight_on_ray(Ray(point, direction), light, -VERY_FAR), weight_of_aim(choice.index));
    return ParallelAim(point - BEYOND_SCENE * direction, weight / choice.sum);
}

// The density of a ray by aim_parallel, over the area across.
fn density_of_parallel_aim(ray: Ray, light: u32) -> f32 {
    let sum = choose_parallel_aim(ray.direction, 0.0).sum;
    return select(0.0, weight_on_ray(ray, light, -VERY_FAR) / sum, sum > 0.0);
}
