//@ use bench/mesh
//@ use choice/walk
// A ray an invocation, and what it met.
override WORKGROUP_SIZE: u32 = 64u;

struct Job {
    first: u32,
    count: u32,
}

@group(0) @binding(0) var<uniform> job: Job;
@group(0) @binding(4) var<storage, read_write> met: array<vec2<u32>>;
@group(0) @binding(5) var<storage, read> rays: array<Ray>;

@compute @workgroup_size(WORKGROUP_SIZE)
fn walks(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x < job.count {
        let found = walk(rays[job.first + id.x]);
        met[id.x] = vec2<u32>(found.triangle, found.steps);
    }
}
