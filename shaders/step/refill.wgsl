//@ use bind/settings
//@ use scene/background
//@ use choice/clamp
//@ use step/start
//@ use step/count
//@ use bind/records
//@ use choice/found_sky
//@ use choice/aov_direct
//@ use choice/aov_record
//@ use choice/light_groups
//@ use choice/filter_weight
//@ use choice/sampled_light
//@ relies on bits
// Whether the path has left the scene, ended on a surface, or cannot go on.
fn has_ended(status: u32) -> bool {
    return status == HIT_NOTHING || status == PATH_ENDED || status == PATH_TOO_DEEP || status == PATH_CUT;
}

// Counts a path that max_depth ended, and adds its throughput in units of 2^-16: the most light that it could still have added per
// unit of radiance. It is rounded up, because the sum is a bound. (A throughput exceeds 1 only where a material samples one of its lobes
// more rarely than that lobe reflects.)
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
        let background = background_radiance((*path).ray.direction);
        radiance = weigh_sky(path, radiance) * background;
        record_sky(path, background, radiance);
        record_light(path, hit_at(HIT_NOTHING, VERY_FAR), limited_indirect(radiance, (*path).depth));
    }
    if (*path).status == PATH_TOO_DEEP {
        count_too_deep(radiance);
        radiance = vec3<f32>(0.0);
    }
    record_direct(path, radiance, (*path).depth);
    radiance = with_sampled_light(path, limited_indirect(radiance, (*path).depth));
    radiance = weigh_by_filter(path, radiance);
    // A sample that is not finite is dropped, and counted by its reason. Tested by bits: a compiler may assume that x != x is false.
    if (*path).status == PATH_CUT {
        (*path).counts += 0x1000000u;
    } else if is_nan(radiance.x) || is_nan(radiance.y) || is_nan(radiance.z) {
        (*path).counts += 0x100u;
    } else if is_infinite(radiance.x) || is_infinite(radiance.y) || is_infinite(radiance.z) {
        (*path).counts += 0x10000u;
    } else {
        add_direct(path);
        add_lights(path);
        (*path).squares += squared_deviation((*path).counts & 0xffu, (*path).sum.sum, radiance);
        (*path).counts += 1u;
        (*path).sum = compensated_sum((*path).sum, radiance, settings.zero);
    }
    (*path).rays += (*path).depth + 1u;
    let end = end_of_run((*path).sample, settings.end_sample);
    (*path).sample += 1u;
    var has_run = (*path).sample < end;
    if !has_run {
        let at = atomicAdd(&counters.records, 1u);
        let sum = (*path).sum.sum - (*path).sum.excess;
        var run = RunRecord();
        run.sum_r = sum.x;
        run.sum_g = sum.y;
        run.sum_b = sum.z;
        run.pixel = (*path).pixel;
        run.counts = (*path).counts;
        run.rays = (*path).rays;
        run.squares_r = (*path).squares.x;
        run.squares_g = (*path).squares.y;
        run.squares_b = (*path).squares.z;
        record_aov(&run, path);
        records[at] = run;
        has_run = start_run(path);
    }
    if has_run {
        start_sample(path);
    }
}
