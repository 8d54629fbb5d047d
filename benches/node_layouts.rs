//! Node layouts and sizes of leaves against each other, on a displaced torus knot of a thousand triangles and more.
//!
//! `cargo bench --bench node_layouts [-- MOST_TRIANGLES ROUNDS [PLOT.svg]]`, on the device that GPU_RT_BENCH_DEVICE names
//! or the default one. Prints for every size the seconds of each build, and for each layout the rays per second (median
//! of rounds in turn), their ratio to the production layout, steps a ray and bytes a triangle; then what a ray costs by
//! the number of triangles. All layouts must find the same triangles. Software drivers are timed in processor seconds of
//! this process, since other programs may run on the machine.

use std::time::Instant;

use bytemuck::{Pod, Zeroable};
use glam::{Vec3, Vec4};
use gpu_rt::bvh::{self, Bounds, Bvh, Quality};
use gpu_rt::data::{HIT_NOTHING, PRIMITIVE_BIT};
use gpu_rt::error::Result;
use gpu_rt::gpu::buffers::{BufferSpec, Buffers, Readback};
use gpu_rt::gpu::device::{Adapters, Device};
use gpu_rt::gpu::layout;
use gpu_rt::gpu::link::{Choices, Chosen, Embedded, Library, Reason, link};
use gpu_rt::gpu::pipeline::{Pipeline, PipelineSpec};

const SIZES: [usize; 6] = [1_000, 10_000, 100_000, 1_000_000, 2_000_000, 3_000_000];
/// Rays of a dispatch: the camera's image.
const IMAGE: (u32, u32) = (512, 256);
const RAYS: u32 = IMAGE.0 * IMAGE.1;
const WORKGROUP: u32 = 64;

struct Walks;

impl Library for Walks {
    fn module(&self, name: &str) -> Option<&str> {
        match name {
            "bench/walks" => Some(include_str!("shaders/walks.wgsl")),
            "bench/mesh" => Some(include_str!("shaders/mesh.wgsl")),
            "bench/walk_binary" => Some(include_str!("shaders/walk_binary.wgsl")),
            "bench/walk_wide" => Some(include_str!("shaders/walk_wide.wgsl")),
            "bench/keys_bytes" => Some(include_str!("shaders/keys_bytes.wgsl")),
            "bench/keys_floats" => Some(include_str!("shaders/keys_floats.wgsl")),
            _ => Embedded.module(name),
        }
    }
}

struct Mesh {
    vertices: Vec<Vec4>,
    triangles: Vec<[u32; 3]>,
}

impl Mesh {
    /// A tube along a torus knot, rough on all scales; normals point outwards.
    fn knot(triangles: usize) -> Mesh {
        let around = ((triangles as f64 / 32.0).sqrt().round() as usize).max(3);
        let along = triangles / 2 / around;
        let curve = |t: f32| {
            let (sin_a, cos_a) = (2.0 * t).sin_cos();
            let (sin_b, cos_b) = (3.0 * t).sin_cos();
            Vec3::new((2.0 + cos_b) * cos_a, (2.0 + cos_b) * sin_a, sin_b) / 3.0
        };
        let turn = std::f32::consts::TAU;
        let point = |i: usize, j: usize| {
            let (t, s) = (i as f32 / along as f32 * turn, j as f32 / around as f32 * turn);
            let forward = (curve(t + 1e-3) - curve(t - 1e-3)).normalize();
            let side = forward.cross(Vec3::new(0.3, 0.2, 1.0)).normalize();
            let bump = |octave: u8| {
                let (f, phase) = (2f32.powi(octave.into()), f32::from(octave));
                ((7.0 * t + 1.3 * phase) * f).sin() * (2.0 * s * f + phase).sin() / f
            };
            let radius = 0.2 + 0.05 * (0..9).map(bump).sum::<f32>();
            (curve(t) + radius * (s.cos() * side + s.sin() * side.cross(forward))).extend(0.0)
        };
        let vertices = (0..along * around).map(|k| point(k / around, k % around)).collect();
        let at = |i: usize, j: usize| ((i % along) * around + j % around) as u32;
        let quad = |k: usize| {
            let (i, j) = (k / around, k % around);
            [[at(i, j), at(i + 1, j), at(i, j + 1)], [at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]]
        };
        Mesh { vertices, triangles: (0..along * around).flat_map(quad).collect() }
    }

    fn bounds(&self) -> Vec<Bounds> {
        let corner = |i: u32| self.vertices[i as usize].truncate();
        let around = |[a, b, c]: [Vec3; 3]| Bounds { min: a.min(b).min(c), max: a.max(b).max(c) };
        self.triangles.iter().map(|triangle| around(triangle.map(corner))).collect()
    }
}

fn union(a: &Bounds, b: &Bounds) -> Bounds {
    Bounds { min: a.min.min(b.min), max: a.max.max(b.max) }
}

fn half_area(bounds: &Bounds) -> f32 {
    let d = bounds.max - bounds.min;
    d.x * d.y + d.y * d.z + d.z * d.x
}

/// A node of a binary tree, with the exact box.
struct Binary {
    bounds: Bounds,
    /// Of its two children, or nothing.
    children: Option<[usize; 2]>,
    code: u32,
    leaves: u32,
}

/// The binary tree under a production node, added to `out`: the children that share the smallest box are joined first.
fn binary(tree: &Bvh, boxes: &[Bounds], code: u32, out: &mut Vec<Binary>) -> usize {
    if code & PRIMITIVE_BIT != 0 {
        let bounds = boxes[(code & !PRIMITIVE_BIT) as usize];
        out.push(Binary { bounds, children: None, code, leaves: 1 });
        return out.len() - 1;
    }
    let codes = tree.nodes[code as usize].children;
    let mut open: Vec<usize> =
        codes.iter().filter(|&&code| code != HIT_NOTHING).map(|&code| binary(tree, boxes, code, out)).collect();
    while open.len() > 1 {
        let pairs = (1..open.len()).flat_map(|b| (0..b).map(move |a| (a, b)));
        let joined = |&(a, b): &(usize, usize)| half_area(&union(&out[open[a]].bounds, &out[open[b]].bounds));
        let (a, b) = pairs.min_by(|p, q| joined(p).total_cmp(&joined(q))).expect("there are two");
        let (b, a) = (open.swap_remove(b), open.swap_remove(a));
        let leaves = out[a].leaves + out[b].leaves;
        let bounds = union(&out[a].bounds, &out[b].bounds);
        out.push(Binary { bounds, children: Some([a, b]), code: 0, leaves });
        open.push(out.len() - 1);
    }
    open[0]
}

/// Subtrees of so many leaves at most, by their primitives.
fn clusters(tree: &[Binary], at: usize, most: u32, out: &mut Vec<(Bounds, Vec<u32>)>) {
    fn leaves(tree: &[Binary], at: usize, out: &mut Vec<u32>) {
        match tree[at].children {
            Some(children) => children.iter().for_each(|&child| leaves(tree, child, out)),
            None => out.push(tree[at].code & !PRIMITIVE_BIT),
        }
    }
    match tree[at].children {
        Some(children) if tree[at].leaves > most => {
            children.iter().for_each(|&child| clusters(tree, child, most, out));
        }
        _ => {
            let mut held = Vec::new();
            leaves(tree, at, &mut held);
            out.push((tree[at].bounds, held));
        }
    }
}

/// A hierarchy over a mesh in one layout.
struct Layout {
    name: &'static str,
    modules: &'static [(&'static str, &'static str)],
    nodes: Vec<u8>,
    stack_size: u32,
    /// In the order of the leaves, with the original number.
    triangles: Vec<[u32; 4]>,
}

const BYTES: &[(&str, &str)] = &[("walk", "bench/walk_wide"), ("keys", "bench/keys_bytes")];

/// The production layout, with leaves of so many triangles at most.
fn leaves_of(name: &'static str, mesh: &Mesh, tree: &[Binary], root: usize, most: u32) -> (Layout, Bvh, Vec<Bounds>) {
    let mut held = Vec::new();
    clusters(tree, root, most, &mut held);
    let (mut triangles, mut codes) = (Vec::new(), Vec::new());
    for (_, leaf) in &held {
        codes.push(PRIMITIVE_BIT | (leaf.len() as u32 - 1) << 28 | triangles.len() as u32);
        for &i in leaf {
            let [a, b, c] = mesh.triangles[i as usize];
            triangles.push([a, b, c, i]);
        }
    }
    let boxes: Vec<Bounds> = held.iter().map(|(bounds, _)| *bounds).collect();
    let built = bvh::build(&boxes, &codes, Quality::default());
    let nodes = bytemuck::cast_slice(&built.nodes).to_vec();
    (Layout { name, modules: BYTES, nodes, stack_size: built.stack_size, triangles }, built, boxes)
}

/// Two boxes of f32 a node.
fn two_floats(tree: &[Binary], root: usize, triangles: Vec<[u32; 4]>) -> Layout {
    let mut nodes = vec![[0u32; 16]];
    let mut open = vec![(root, 0, 1)];
    let mut stack_size = 1;
    while let Some((at, here, depth)) = open.pop() {
        stack_size = stack_size.max(depth);
        let children = tree[at].children.expect("an inner node");
        for (side, &child) in children.iter().enumerate() {
            let child_node = &tree[child];
            let code = match child_node.children {
                None => child_node.code,
                Some(_) => {
                    nodes.push([0; 16]);
                    open.push((child, nodes.len() - 1, depth + 1));
                    nodes.len() as u32 - 1
                }
            };
            let words = &mut nodes[here];
            words[8 * side..8 * side + 3].copy_from_slice(&child_node.bounds.min.to_array().map(f32::to_bits));
            words[8 * side + 4..8 * side + 7].copy_from_slice(&child_node.bounds.max.to_array().map(f32::to_bits));
            words[3 + 4 * side] = code;
        }
    }
    let nodes = bytemuck::cast_slice(&nodes).to_vec();
    Layout { name: "2 boxes of f32", modules: &[("walk", "bench/walk_binary")], nodes, stack_size, triangles }
}

/// The production tree with boxes of f32.
fn four_floats(tree: &Bvh, boxes: &[Bounds], triangles: Vec<[u32; 4]>) -> Layout {
    let empty = Bounds { min: Vec3::splat(1e30), max: Vec3::splat(-1e30) };
    let mut hulls = vec![empty; tree.nodes.len()];
    let mut nodes = vec![[0u32; 28]; tree.nodes.len()];
    // Children stand after their parents.
    for (here, node) in tree.nodes.iter().enumerate().rev() {
        for (child, &code) in node.children.iter().enumerate() {
            let bounds = match code {
                HIT_NOTHING => empty,
                _ if code & PRIMITIVE_BIT != 0 => boxes[(code & !PRIMITIVE_BIT) as usize],
                _ => hulls[code as usize],
            };
            hulls[here] = union(&hulls[here], &bounds);
            for axis in 0..3 {
                nodes[here][4 * axis + child] = bounds.min[axis].to_bits();
                nodes[here][12 + 4 * axis + child] = bounds.max[axis].to_bits();
            }
            nodes[here][24 + child] = code;
        }
    }
    let nodes = bytemuck::cast_slice(&nodes).to_vec();
    let modules = &[("walk", "bench/walk_wide"), ("keys", "bench/keys_floats")];
    Layout { name: "4 boxes of f32", modules, nodes, stack_size: tree.stack_size, triangles }
}

#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct Job {
    first: u32,
    count: u32,
}

/// Rays of a pinhole camera, row by row, then as many from anywhere on the surface in any direction off it: an origin and
/// a direction each.
fn rays(mesh: &Mesh) -> Vec<[Vec4; 2]> {
    let from_camera = (0..RAYS).map(|i| {
        let x = ((i % IMAGE.0) as f32 + 0.5) / IMAGE.0 as f32 - 0.5;
        let y = ((i / IMAGE.0) as f32 + 0.5) / IMAGE.1 as f32 - 0.5;
        [Vec4::Z * 4.0, Vec3::new(0.7 * x, 0.7 * y, -1.0).normalize().extend(0.0)]
    });
    let mut state = 1u64;
    let mut uniform = move || {
        state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (state >> 40) as f32 / (1u64 << 24) as f32
    };
    let off_surface = (0..RAYS).map(|_| {
        let triangle = mesh.triangles[(f64::from(uniform()) * mesh.triangles.len() as f64) as usize];
        let [a, b, c] = triangle.map(|i| mesh.vertices[i as usize].truncate());
        let (root, share, z) = (uniform().sqrt(), uniform(), 1.0 - 2.0 * uniform());
        let (sin, cos) = (std::f32::consts::TAU * uniform()).sin_cos();
        let direction = (1.0 - z * z).sqrt() * Vec3::new(cos, sin, 0.0) + z * Vec3::Z;
        let outwards = direction.dot((b - a).cross(c - a)) >= 0.0;
        let origin = a + root * (1.0 - share) * (b - a) + root * share * (c - a);
        [origin.extend(0.0), if outwards { direction } else { -direction }.extend(0.0)]
    });
    from_camera.chain(off_surface).collect()
}

/// A layout on the device.
struct Walk<'a> {
    device: &'a Device,
    buffers: Buffers,
    pipeline: Pipeline,
    readback: Readback,
}

impl<'a> Walk<'a> {
    fn new(device: &'a Device, mesh: &Mesh, rays: &[[Vec4; 2]], layout: &Layout) -> Result<Walk<'a>> {
        let mut choices = Choices::default();
        let chosen =
            |&(choice, module): &(&'static str, &'static str)| (choice, Chosen { module, why: Reason::EveryRender });
        choices.modules.extend(layout.modules.iter().map(chosen));
        for (name, value) in [("stack_size", layout.stack_size.to_string()), ("space_of_nodes", "storage, read".into())]
        {
            choices.values.insert(name, value);
        }
        let (module, _) = link(&Walks, "bench/walks", &choices)?.validate()?;
        let bindings = layout::bindings(&module)?;
        let met = u64::from(RAYS) * 8;
        let why = "the benchmark";
        let buffers = Buffers::create(
            device,
            &[
                BufferSpec::uniform("job", size_of::<Job>() as u64, why),
                BufferSpec::scene("vertices", bytemuck::cast_slice(&mesh.vertices).into(), why),
                BufferSpec::scene("triangles", bytemuck::cast_slice(&layout.triangles).into(), why),
                BufferSpec::scene("nodes", layout.nodes.as_slice().into(), why),
                BufferSpec::scene("rays", bytemuck::cast_slice(rays).into(), why),
                BufferSpec::working("met", met, why),
            ],
        )?;
        let spec = PipelineSpec {
            name: layout.name,
            entry_point: "walks",
            module: &module,
            bindings: &bindings,
            workgroup: WORKGROUP,
            constants: &[],
        };
        let pipeline = Pipeline::new(device, &spec, &buffers)?;
        Ok(Walk { device, buffers, pipeline, readback: Readback::new(device, "met", met) })
    }

    /// All rays of a kind: the seconds that they take, and the triangle and the steps of each.
    fn run(&self, kind: u32) -> Result<(f64, Vec<[u32; 2]>)> {
        let job = Job { first: kind * RAYS, count: RAYS };
        self.device.queue.write_buffer(self.buffers.get("job")?, 0, bytemuck::bytes_of(&job));
        let start = now(self.device);
        let mut encoder = self.device.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        self.pipeline.dispatch(
            &mut encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default()),
            RAYS.div_ceil(WORKGROUP),
        );
        self.device.wait(self.device.queue.submit([encoder.finish()]))?;
        let seconds = now(self.device) - start;
        let mut encoder = self.device.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let bytes = u64::from(RAYS) * 8;
        self.readback.copy(&mut encoder, self.buffers.get("met")?, bytes);
        let submission = self.device.queue.submit([encoder.finish()]);
        let met = self.readback.read(self.device, submission, bytes, bytemuck::pod_collect_to_vec::<u8, [u32; 2]>)?;
        Ok((seconds, met))
    }
}

/// Processor seconds of all threads on a software driver, the clock's elsewhere.
fn now(device: &Device) -> f64 {
    static START: std::sync::OnceLock<Instant> = std::sync::OnceLock::new();
    let clock = START.get_or_init(Instant::now).elapsed().as_secs_f64();
    let spent = || -> Option<f64> {
        let threads = std::fs::read_dir("/proc/self/task").ok()?;
        let times = threads.map(|thread| {
            let text = std::fs::read_to_string(thread.ok()?.path().join("schedstat")).ok()?;
            text.split(' ').next()?.parse::<f64>().ok()
        });
        Some(times.map(|time| time.unwrap_or(0.0)).sum::<f64>() * 1e-9)
    };
    if device.name.software { spent().unwrap_or(clock) } else { clock }
}

fn median(numbers: &mut [f64]) -> f64 {
    numbers.sort_by(f64::total_cmp);
    numbers[numbers.len() / 2]
}

/// The fastest of three builds of each quality, by the clock.
fn report_builds(boxes: &[Bounds], codes: &[u32]) {
    for quality in [Quality::Fast, Quality::Medium, Quality::Best] {
        let mut least = f64::MAX;
        let mut nodes = 0;
        for _ in 0..3 {
            let start = Instant::now();
            nodes = bvh::build(boxes, codes, quality).nodes.len();
            least = least.min(start.elapsed().as_secs_f64());
        }
        let (count, nodes) = (boxes.len() as f64, nodes as f64);
        let (rate, bytes, children) = (count / least / 1e6, 64.0 * nodes / count, (count + nodes - 1.0) / nodes);
        println!(
            "  build {quality:?}: {least:.3} s, {rate:.2} million triangles/s; {bytes:.1} bytes a triangle, {children:.2} \
             children a node",
        );
    }
}

/// Times all layouts of one mesh; of the production layout the microseconds a ray, of the camera and off the surface,
/// and the steps.
fn compare(device: &Device, triangles: usize, rounds: usize) -> Result<[f64; 4]> {
    let mesh = Mesh::knot(triangles);
    let boxes = mesh.bounds();
    let codes: Vec<u32> = (0..boxes.len() as u32).map(|i| PRIMITIVE_BIT | i).collect();
    println!("{} triangles", boxes.len());
    report_builds(&boxes, &codes);

    let built = bvh::build(&boxes, &codes, Quality::default());
    let mut tree = Vec::new();
    let root = binary(&built, &boxes, built.root, &mut tree);
    let (production, wide, leaf_boxes) = leaves_of("4 boxes of bytes (production)", &mesh, &tree, root, 1);
    let mut again = Vec::new();
    let again_root = binary(&wide, &leaf_boxes, wide.root, &mut again);
    let ordered = production.triangles.clone();
    let listed = mesh.triangles.iter().zip(0..).map(|(&[a, b, c], i)| [a, b, c, i]).collect();
    let as_listed = Layout {
        name: "production, triangles as listed",
        modules: BYTES,
        nodes: bytemuck::cast_slice(&built.nodes).to_vec(),
        stack_size: built.stack_size,
        triangles: listed,
    };
    let layouts = [
        two_floats(&again, again_root, ordered.clone()),
        four_floats(&wide, &leaf_boxes, ordered),
        production,
        as_listed,
        leaves_of("bytes, leaves of up to 2", &mesh, &tree, root, 2).0,
        leaves_of("bytes, leaves of up to 4", &mesh, &tree, root, 4).0,
    ];
    const PRODUCTION: usize = 2;
    let rays = rays(&mesh);
    let walks: Vec<_> = layouts.iter().map(|layout| Walk::new(device, &mesh, &rays, layout)).collect();
    let mut seconds = vec![[Vec::new(), Vec::new()]; layouts.len()];
    let mut steps = vec![[0.0; 2]; layouts.len()];
    for round in 0..=rounds {
        for kind in 0..2 {
            let mut reference: Vec<[u32; 2]> = Vec::new();
            for way in (0..layouts.len()).map(|i| (i + PRODUCTION) % layouts.len()) {
                let Ok(walk) = &walks[way] else { continue };
                let (time, met) = walk.run(kind as u32)?;
                steps[way][kind] = met.iter().map(|ray| f64::from(ray[1])).sum::<f64>() / f64::from(RAYS);
                if way == PRODUCTION {
                    reference = met;
                } else {
                    // Of two triangles at one distance the first met is kept, and the order differs.
                    let others = met.iter().zip(&reference).filter(|(a, b)| a[0] != b[0]).count();
                    assert!(others * 1000 < met.len(), "{}: {others} rays met others", layouts[way].name);
                }
                // The first round warms up.
                if round > 0 {
                    seconds[way][kind].push(time);
                }
            }
        }
    }
    let mut cost = [0.0, 0.0, steps[PRODUCTION][0], steps[PRODUCTION][1]];
    for (way, layout) in layouts.iter().enumerate() {
        let bytes = layout.nodes.len() as f64 / triangles as f64;
        print!("  {:32} {bytes:6.1} bytes a triangle", layout.name);
        match &walks[way] {
            Ok(_) => {
                for (kind, name) in ["camera", "surface"].iter().enumerate() {
                    let production = &seconds[PRODUCTION][kind];
                    let mut ratios: Vec<f64> =
                        production.iter().zip(&seconds[way][kind]).map(|(production, own)| production / own).collect();
                    let own = median(&mut seconds[way][kind].clone()) / f64::from(RAYS) * 1e6;
                    if way == PRODUCTION {
                        cost[kind] = own;
                    }
                    let (rate, ratio) = (1.0 / own, median(&mut ratios));
                    print!("; {name} {rate:.3} ({ratio:.2}), {:.1} steps", steps[way][kind]);
                }
                println!();
            }
            Err(error) => println!("; {error}"),
        }
    }
    Ok(cost)
}

fn main() -> Result<()> {
    // Cargo passes `--bench`; the rest is ours.
    let args: Vec<String> = std::env::args().skip(1).filter(|arg| arg != "--bench").collect();
    let most: usize = args.first().map_or(3_000_000, |arg| arg.parse().expect("triangles"));
    let rounds: usize = args.get(1).map_or(5, |arg| arg.parse().expect("rounds"));
    let adapters = Adapters::find();
    let device = Device::open(adapters.choose(std::env::var("GPU_RT_BENCH_DEVICE").ok().as_deref())?)?;
    let unit = if device.name.software { "a processor second" } else { "a second" };
    println!("{}: million rays {unit} (ratio to production); {RAYS} rays, median of {rounds} rounds", device.name);
    let mut points: Vec<(f64, [f64; 4])> = Vec::new();
    for triangles in SIZES.into_iter().filter(|&triangles| triangles <= most) {
        points.push(((triangles as f64).log2(), compare(&device, triangles, rounds)?));
    }
    let names = ["camera, microseconds", "surface, microseconds", "camera, steps", "surface, steps"];
    for (kind, name) in names.iter().enumerate() {
        let line: Vec<(f64, f64)> = points.iter().map(|(x, cost)| (*x, cost[kind])).collect();
        let (start, slope, fit) = fitted(&line);
        println!(
            "{name} a ray: {start:.3} + {slope:.3} log2 N, r² {fit:.3}; {:.2?}",
            line.iter().map(|p| p.1).collect::<Vec<_>>()
        );
    }
    if let Some(path) = args.get(2).filter(|_| !points.is_empty()) {
        std::fs::write(path, plot(&points, &device.name.to_string())).expect("the plot can be written");
    }
    Ok(())
}

/// A picture of the costs by the logarithm of the number of triangles, with a line fitted to each.
fn plot(points: &[(f64, [f64; 4])], device: &str) -> String {
    let (width, height, margin) = (640.0, 400.0, 60.0);
    let (left, right) = (points[0].0.floor(), points[points.len() - 1].0.ceil());
    let top = points.iter().flat_map(|(_, cost)| [cost[0], cost[1]]).fold(0.0, f64::max).ceil();
    let x = |log: f64| margin + (log - left) / (right - left) * (width - 2.0 * margin);
    let y = |cost: f64| height - margin - cost / top * (height - 2.0 * margin);
    let mut out = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\" font-family=\"sans-serif\" \
         font-size=\"12\">\n<rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n<text x=\"{margin}\" y=\"20\">\
         Microseconds of one core a ray, by log2 of the triangles</text>\n<text x=\"{margin}\" y=\"38\">{device}</text>\n"
    );
    let mut line = |x0: f64, y0: f64, x1: f64, y1: f64, colour: &str| {
        out += &format!("<path d=\"M{x0:.1} {y0:.1}L{x1:.1} {y1:.1}\" stroke=\"{colour}\"/>\n");
    };
    line(x(left), y(0.0), x(right), y(0.0), "black");
    line(x(left), y(0.0), x(left), y(top), "black");
    for (kind, colour) in ["steelblue", "firebrick"].iter().enumerate() {
        let (start, slope, _) = fitted(&points.iter().map(|(log, cost)| (*log, cost[kind])).collect::<Vec<_>>());
        let from = left.max(-start / slope);
        line(x(from), y(start + slope * from), x(right), y(start + slope * right), colour);
    }
    for log in left as u32..=right as u32 {
        out += &format!("<text x=\"{:.1}\" y=\"{:.1}\">{log}</text>\n", x(log.into()) - 6.0, y(0.0) + 18.0);
    }
    for cost in 0..=top as u32 {
        out += &format!("<text x=\"{:.1}\" y=\"{:.1}\">{cost}</text>\n", x(left) - 18.0, y(cost.into()) + 4.0);
    }
    for (kind, (colour, name)) in [("steelblue", "camera"), ("firebrick", "surface")].iter().enumerate() {
        for (log, cost) in points {
            out += &format!("<circle cx=\"{:.1}\" cy=\"{:.1}\" r=\"4\" fill=\"{colour}\"/>\n", x(*log), y(cost[kind]));
        }
        let (last, cost) = points[points.len() - 1];
        out += &format!(
            "<text x=\"{:.1}\" y=\"{:.1}\" fill=\"{colour}\">{name}</text>\n",
            x(last) - 20.0,
            y(cost[kind]) - 10.0
        );
    }
    out + "</svg>\n"
}

/// The line of least squares through points: its start, its slope, and the square of the correlation.
fn fitted(points: &[(f64, f64)]) -> (f64, f64, f64) {
    let count = points.len() as f64;
    let mean = |f: &dyn Fn(&(f64, f64)) -> f64| points.iter().map(f).sum::<f64>() / count;
    let (x, y) = (mean(&|p| p.0), mean(&|p| p.1));
    let (xx, yy) = (mean(&|p| (p.0 - x).powi(2)), mean(&|p| (p.1 - y).powi(2)));
    let xy = mean(&|p| (p.0 - x) * (p.1 - y));
    (y - xy / xx * x, xy / xx, xy * xy / (xx * yy))
}
