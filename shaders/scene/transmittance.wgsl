//@ use data/ray
//@ use data/medium
//@ use data/primitive
//@ use bind/media
//@ each boundary
//@ use scene/medium_in_${name}
//@ end
// The share of light that gets through all media on the way to distance t; WALK_CUT where that took too many steps to find out.
fn transmittance(ray: Ray, t: f32, steps: ptr<function, u32>) -> f32 {
    var depth = 0.0;
    for (var i = 0u; i < ${media}u; i++) {
        let medium = media[i];
        let index = primitive_index(medium.boundary);
        var way = 0.0;
        switch primitive_kind(medium.boundary) {
            //@ each boundary
            ${case}: {
                way = way_in_${name}(ray, index, t, steps);
            }
            //@ end
        }
        if way == WALK_CUT {
            return WALK_CUT;
        }
        depth += medium.density * way;
    }
    return exp(-depth);
}
