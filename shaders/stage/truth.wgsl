//@ use bind/film
//@ use bind/records
//@ use bind/window
//@ use step/start
//@ use step/trace
//@ use choice/surface0
//@ use truth/ray
//@ relies on loops
// Stores what sample 0 of a pixel sees, once its run is finished. It traces that sample's camera ray once more, so that paths carry nothing of it.
override WORKGROUP_SIZE: u32 = 64u;

@compute @workgroup_size(WORKGROUP_SIZE)
fn truth(@builtin(global_invocation_id) id: vec3<u32>) {
    let finished = atomicLoad(&counters.records);
    let invocations = window.end_slot - window.first_slot;
    if id.x >= min(invocations, finished) {
        return;
    }
    for (var i = id.x; i < finished; i += invocations) {
        let run = records[i];
        if (run.counts & FIRST_RUN) == 0u {
            continue;
        }
        var path: Path;
        path.pixel = run.pixel;
        path.sample = 0u;
        start_sample(&path);
        trace(&path);
        //@ each truth_channel
        let ${name} = ${name}_of(&path);
        //@ end
        let pixel = rank_of_pixel(run.pixel) - window.first_pixel;
        //@ each truth_word
        film[pixel].stored[${number}u] = ${name};
        //@ end
    }
}
