//@ use slots/start
//@ use bind/records
//@ use choice/background
//@ use lib/float
// Takes the radiance of each path that ended into its run, and starts the slot's next sample or run.
override WORKGROUP_SIZE: u32 = 64u;

@compute @workgroup_size(WORKGROUP_SIZE)
fn refill(@builtin(global_invocation_id) id: vec3<u32>) {
    let slot = id.x;
    if slot >= settings.slots {
        return;
    }
    let direction = paths[place(PLANE_DIRECTION, slot)];
    if direction.w != HIT_NOTHING && direction.w != PATH_ENDED {
        return;
    }
    let state = paths[place(PLANE_THROUGHPUT, slot)];
    var radiance = vector_of(state);
    if direction.w == HIT_NOTHING {
        radiance *= background_radiance(vector_of(direction));
    }
    var run = paths[place(PLANE_SAMPLE, slot)];
    var sum = paths[place(PLANE_SUM, slot)];
    // A sample that is not finite is dropped and counted by reason; the bits tell, since x != x may be assumed false.
    if is_nan(radiance.x) || is_nan(radiance.y) || is_nan(radiance.z) {
        run.w += 0x100u;
    } else if is_infinite(radiance.x) || is_infinite(radiance.y) || is_infinite(radiance.z) {
        run.w += 0x10000u;
    } else {
        run.w += 1u;
        sum = word_of(vector_of(sum) + radiance, sum.w);
    }
    sum.w += state.w + 1u;
    run.y += 1u;
    if run.y < run.z {
        paths[place(PLANE_SAMPLE, slot)] = run;
        paths[place(PLANE_SUM, slot)] = sum;
        start_sample(slot, run.x, run.y);
    } else {
        let total = vector_of(sum);
        let at = atomicAdd(&counters.records, 1u);
        records[at] = RunRecord(total.x, total.y, total.z, run.x, run.w, sum.w);
        start_run(slot);
    }
}
