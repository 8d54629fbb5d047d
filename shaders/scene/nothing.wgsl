//@ alternative walk when !surface & !brute_force
// A scene without surfaces: every ray leaves it, and nothing blocks a shadow ray.
fn first_hit(ray: Ray, root: u32, limit: Hit, any_will_do: bool) -> Hit {
    return limit;
}

fn nearest_hit(ray: Ray, root: u32) -> Hit {
    return hit_at(HIT_NOTHING, VERY_FAR);
}
