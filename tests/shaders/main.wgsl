//@ use ${kernel}
// The entry point of every test kernel.
override WORKGROUP_SIZE: u32 = 64u;

struct Job {
    rows: u32,
}

@group(0) @binding(20) var<uniform> job: Job;

@compute @workgroup_size(WORKGROUP_SIZE)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x < job.rows {
        run(id.x);
    }
}
