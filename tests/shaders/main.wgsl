//@ use ${kernel}
// The entry point of every test kernel, and its rows: a kernel's module has the types.
override WORKGROUP_SIZE: u32 = 64u;

struct Job {
    // Of output.
    rows: u32,
    // How many of them each row of input has.
    times: u32,
    // The planted error that is there (tests/common/kernel.rs), from 1 on.
    planted: u32,
}

@group(0) @binding(20) var<uniform> job: Job;
@group(0) @binding(21) var<storage, read> input: array<In>;
@group(0) @binding(22) var<storage, read_write> output: array<Out>;

@compute @workgroup_size(WORKGROUP_SIZE)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x < job.rows {
        run(id.x);
    }
}
