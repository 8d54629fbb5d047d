//@ use bench/mesh
//@ use choice/walk
//@ use lib/rng
// A ray an invocation, and what it met.
override WORKGROUP_SIZE: u32 = 64u;

struct Job {
    width: u32,
    height: u32,
    triangles: u32,
    // Rays of a pinhole camera; else from anywhere on the surface in any direction off it.
    from_camera: u32,
}

@group(0) @binding(0) var<uniform> job: Job;
@group(0) @binding(4) var<storage, read_write> met: array<vec2<u32>>;

fn camera_ray(i: u32) -> Ray {
    let x = (f32(i % job.width) + 0.5) / f32(job.width) - 0.5;
    let y = (f32(i / job.width) + 0.5) / f32(job.height) - 0.5;
    return Ray(vec3<f32>(0.0, 0.0, 4.0), normalize(vec3<f32>(0.7 * x, 0.7 * y, -1.0)));
}

fn surface_ray(i: u32) -> Ray {
    let at = random4(i, 0u, 0u, 1u);
    let to = random4(i, 0u, 1u, 1u);
    let corners = triangles[min(u32(at.x * f32(job.triangles)), job.triangles - 1u)];
    let a = vertices[corners.x].xyz;
    let ab = vertices[corners.y].xyz - a;
    let ac = vertices[corners.z].xyz - a;
    let root = sqrt(at.y);
    let normal = normalize(cross(ab, ac));
    let z = 1.0 - 2.0 * to.x;
    let r = sqrt(max(1.0 - z * z, 0.0));
    let direction = vec3<f32>(r * cos(6.2831853 * to.y - 3.1415926), r * sin(6.2831853 * to.y - 3.1415926), z);
    // To the outside, to which all normals point.
    let outward = select(-direction, direction, dot(direction, normal) > 0.0);
    return Ray(a + root * (1.0 - at.z) * ab + root * at.z * ac, outward);
}

@compute @workgroup_size(WORKGROUP_SIZE)
fn walks(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x < job.width * job.height {
        var ray: Ray;
        if job.from_camera != 0u {
            ray = camera_ray(id.x);
        } else {
            ray = surface_ray(id.x);
        }
        let found = walk(ray);
        met[id.x] = vec2<u32>(found.triangle, found.steps);
    }
}
