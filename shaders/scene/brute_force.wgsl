//@ alternative walk when brute_force
//@ use bind/settings
//@ use choice/passed_panes
//@ use scene/primitives
//@ use scene/at_run_time
// Finds the nearest primitive along a ray in a scene of few primitives. There is no hierarchy: every ray tests all primitives,
// and all lanes test the same one at a time.

// The nearest hit with t > 0 that is not beyond `limit`; with `any_will_do`, the first such hit found. Of two hits at the same
// distance, the primitive that comes first in the scene wins.
fn first_hit(ray: Ray, root: u32, limit: Hit, any_will_do: bool) -> Hit {
    var hit = limit;
    //@ each single
    for (var index = at_run_time(0u); index < settings.brute_force[${rank}u]; index += 1u) {
        let code = PRIMITIVE_BIT | (${number}u << PRIMITIVE_KIND_SHIFT) | index;
        let pose = pose_at(code, NO_INSTANCE);
        var candidate = hit_at(code, ${name}_distance(ray, moved_${name}(${name}s[index], pose)));
        candidate.t = distance_ahead(candidate, pose, ray);
        if candidate.t != NO_HIT && candidate.t <= hit.t {
            if candidate.t < hit.t || comes_before(candidate, hit) {
                hit = candidate;
                if any_will_do && ANY_HIT_ENDS_WALK {
                    return hit;
                }
            }
        }
    }
    //@ end
    return hit;
}

fn nearest_hit(ray: Ray, root: u32) -> Hit {
    return first_hit(ray, root, hit_at(HIT_NOTHING, VERY_FAR), false);
}
