//@ use data/ray
//@ use data/found
//@ use data/primitive
//@ use lib/float
// A scene without objects: every ray leaves it.
fn nearest_hit(ray: Ray, root: u32) -> Hit {
    return hit_at(HIT_NOTHING, VERY_FAR);
}
