//@ use data/ray
//@ use data/hit
//@ use data/medium
//@ use data/primitive
//@ use bind/media
//@ each boundary
//@ use scene/medium_in_${name}
//@ end
// Where media scatter rays.

// Distance at which the medium scatters a ray that is to cross `depth` of its optical depth, if that is nearer than
// `limit`; else NO_HIT, or WALK_CUT where that took too many steps to find out. Just the kinds of boundary that the scene has.
fn collision(medium: Medium, ray: Ray, depth: f32, limit: f32, steps: ptr<function, u32>) -> f32 {
    let way = depth / medium.density;
    let index = primitive_index(medium.boundary);
    switch primitive_kind(medium.boundary) {
        //@ each boundary
        ${case}: {
            return collision_in_${name}(ray, index, way, limit, steps);
        }
        //@ end
    }
}
