//@ use data/path
//@ use data/primitive
//@ use bind/settings
//@ use scene/background
//@ use choice/clamp
//@ use lib/float
//@ use lib/compensated
//@ use lib/spread
//@ use step/start
//@ use step/count
//@ use bind/records
//@ if emitting_sky
//@ use step/sky_mis_weight
//@ use choice/probe
//@ end
//@ if aov_direct
//@ use step/aov_direct
//@ end
//@ relies on bits
// Whether the path has left the scene, ended on a surface, or cannot go on.
fn has_ended(status: u32) -> bool {
    return status == HIT_NOTHING || status == PATH_ENDED || status == PATH_TOO_DEEP || status == PATH_CUT;
}

// Counts a path that max_depth ended, with its throughput: the most that it could still have added per radiance. Rounded up, since the
// sum is a bound.
// (Few throughputs exceed 1: those of a material that draws one of its lobes more rarely than that lobe reflects.)
fn count_too_deep(throughput: vec3<f32>) {
    let most = clamp(max(max(throughput.x, throughput.y), throughput.z), 0.0, 32768.0);
    let added = u32(ceil(most * 65536.0));
    count(TOO_DEEP_THROUGHPUT, added);
    count(TOO_DEEP, 1u);
}

// Adds the radiance of an ended path to its run, and starts the next sample or run.
fn refill_path(path: ptr<function, Path>) {
    var radiance = (*path).throughput;
    if (*path).status == HIT_NOTHING {
        //@ if emitting_sky
        radiance *= mis_weight_of_sky(path);
        //@ end
        let behind = background_radiance((*path).ray.direction);
        radiance *= behind;
        //@ if emitting_sky
        note_found_sky(path, behind, radiance);
        //@ end
    }
    if (*path).status == PATH_TOO_DEEP {
        count_too_deep(radiance);
        radiance = vec3<f32>(0.0);
    }
    //@ if aov_direct
    note_direct(path, radiance, (*path).depth);
    //@ end
    radiance = limited_indirect(radiance, (*path).depth);
    //@ if gathers
    radiance += (*path).radiance;
    //@ end
    //@ if signed
    radiance *= weight_of_sample(path);
    //@ end
    // A sample that is not finite is dropped, and counted by its reason. Tested by bits: a compiler may assume that x != x is false.
    if (*path).status == PATH_CUT {
        (*path).counts += 0x1000000u;
    } else if is_nan(radiance.x) || is_nan(radiance.y) || is_nan(radiance.z) {
        (*path).counts += 0x100u;
    } else if is_infinite(radiance.x) || is_infinite(radiance.y) || is_infinite(radiance.z) {
        (*path).counts += 0x10000u;
    } else {
        //@ if aov_direct
        add_direct(path);
        //@ end
        (*path).spread += spread_by((*path).counts & 0xffu, (*path).sum.sum, radiance);
        (*path).counts += 1u;
        (*path).sum = compensated_sum((*path).sum, radiance, settings.zero);
    }
    (*path).rays += (*path).depth + 1u;
    let end = end_of_run((*path).sample, settings.end_sample);
    (*path).sample += 1u;
    if (*path).sample < end {
        start_sample(path);
    } else {
        let at = atomicAdd(&counters.records, 1u);
        let sum = (*path).sum.sum - (*path).sum.excess;
        var run = RunRecord();
        run.sum_r = sum.x;
        run.sum_g = sum.y;
        run.sum_b = sum.z;
        run.pixel = (*path).pixel;
        run.counts = (*path).counts;
        run.rays = (*path).rays;
        run.spread_r = (*path).spread.x;
        run.spread_g = (*path).spread.y;
        run.spread_b = (*path).spread.z;
        //@ if aov_albedo
        run.aov[${sum_of_albedo}u] = (*path).albedo_sum.x;
        run.aov[${sum_of_albedo}u + 1u] = (*path).albedo_sum.y;
        run.aov[${sum_of_albedo}u + 2u] = (*path).albedo_sum.z;
        //@ end
        //@ if aov_normal
        run.aov[${sum_of_normal}u] = (*path).normal_sum.x;
        run.aov[${sum_of_normal}u + 1u] = (*path).normal_sum.y;
        run.aov[${sum_of_normal}u + 2u] = (*path).normal_sum.z;
        //@ end
        //@ if aov_hits
        run.aov[${sum_of_hits}u] = (*path).hits;
        //@ end
        //@ if aov_depth
        run.aov[${sum_of_depth}u] = (*path).depth_sum;
        //@ end
        //@ if aov_position
        run.aov[${sum_of_position}u] = (*path).position_sum.x;
        run.aov[${sum_of_position}u + 1u] = (*path).position_sum.y;
        run.aov[${sum_of_position}u + 2u] = (*path).position_sum.z;
        //@ end
        //@ if aov_object
        run.aov[${sum_of_object}u] = (*path).object;
        //@ end
        //@ if aov_material
        run.aov[${sum_of_material}u] = (*path).material;
        //@ end
        //@ if aov_direct
        run.aov[${sum_of_direct}u] = (*path).direct_sum.x;
        run.aov[${sum_of_direct}u + 1u] = (*path).direct_sum.y;
        run.aov[${sum_of_direct}u + 2u] = (*path).direct_sum.z;
        //@ end
        records[at] = run;
        start_run(path);
    }
}
