//@ use data/ray
//@ use data/hit
//@ use data/primitive
//@ use lib/float
// A scene without objects: every ray leaves it.
fn first_hit(ray: Ray, root: u32, limit: Hit, any_will_do: bool) -> Hit {
    return limit;
}

fn nearest_hit(ray: Ray, root: u32) -> Hit {
    return Hit(HIT_NOTHING, NO_INSTANCE, VERY_FAR, 1u);
}
