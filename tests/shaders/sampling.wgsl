//@ use sampler/independent
// Every map from uniforms; of those given, or of the row's own.
struct Out {
    disk: vec2<f32>,
    circle: vec2<f32>,
    hemisphere: vec3<f32>,
    root: f32,
    sphere: vec3<f32>,
    padding0: u32,
    ball: vec3<f32>,
    padding1: u32,
}

alias In = vec4<f32>;

fn run(row: u32) {
    let u = select(input[row / job.times], random4(row, 0u, 0u, 1u), job.times > 1u);
    var out: Out;
    out.disk = sample_disk(u.xy);
    out.circle = sample_circle(u.x);
    out.hemisphere = sample_cosine_hemisphere(u.xy);
    out.root = cube_root(u.x);
    out.sphere = sample_sphere(u.xy);
    out.ball = sample_ball(u.xyz);
    output[row] = out;
}
