//@ use light/cuboid
//@ use scene/aims
// Light paths of directional lights: parallel rays to the boxes. A box is chosen by the area of its shadow times its weight, and a point is uniform in that.

// The distance from which such rays come: beyond everything but large spheres. (Render space has an extent near 1.)
const BEYOND_SCENE: f32 = 4.0;

// The origin of a ray in this direction, with its density over the area across.
struct ParallelAim {
    origin: vec3<f32>,
    density: f32,
}

fn aim_parallel(direction: vec3<f32>, u: f32, v: vec2<f32>) -> ParallelAim {
    var choice = AimChoice(0u, 0.0, u);
    for (var i = at_run_time(0u); i < AIMS; i++) {
        let shadow = cuboid_shadow(direction, aims[i]);
        choice = offer_box(choice, i, shadow.x + shadow.y + shadow.z);
    }
    if !(choice.sum > 0.0) {
        return ParallelAim(vec3<f32>(0.0), 0.0);
    }
    let box_ahead = aims[choice.index];
    let face = choose_axis(cuboid_shadow(direction, box_ahead), v.x);
    let along = to_cuboid(box_ahead, direction);
    let side = select(1.0, -1.0, along[face.axis] > 0.0);
    let point = box_ahead.center + cuboid_face_point(box_ahead, face.axis, side, vec2<f32>(face.rest, v.y));
    let origin = point - BEYOND_SCENE * direction;
    return ParallelAim(origin, max(weight_on_ray(Ray(origin, direction)), weight_of_aim(choice.index)) / choice.sum);
}
