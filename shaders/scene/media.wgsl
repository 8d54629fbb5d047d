//@ use data/ray
//@ use data/surface
//@ use data/medium
//@ use data/primitive
//@ use bind/media
//@ each convex_boundary
//@ use medium/${name}
//@ use bind/${name}s
//@ end
//@ if mesh_boundary
//@ use scene/medium_in_mesh
//@ end
// Where media scatter rays.

// Distance at which the medium scatters a ray that is to cross `depth` of its optical depth, if that is nearer than
// `limit`; else NO_HIT, or WALK_CUT where that took too many steps to find out. Just the kinds of boundary that the scene has.
fn collision(medium: Medium, ray: Ray, depth: f32, limit: f32, steps: ptr<function, u32>) -> f32 {
    let way = depth / medium.density;
    let index = primitive_index(medium.boundary);
    switch primitive_kind(medium.boundary) {
        //@ each convex_boundary
        ${case}: {
            return collision_within(${name}_interval(ray, ${name}s[index]), way, limit);
        }
        //@ end
        //@ if mesh_boundary
        default: {
            return collision_in_mesh(ray, index, way, limit, steps);
        }
        //@ end
    }
}
