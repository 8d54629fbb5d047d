//! The wavefront against the plain one-kernel version of the same tracer, in turn in one run.
//!
//! `cargo bench --bench one_kernel [-- SCENE.ron WIDTHxHEIGHT SAMPLES ROUNDS]`, on the device that GPU_RT_BENCH_DEVICE
//! names or the default one. Prints paths per second of each, and their ratio round by round. The two must deliver the
//! same bytes, or the comparison is of different work.

use std::path::Path;
use std::time::Instant;

use gpu_rt::data::{RUN_LENGTH, Settings, Window};
use gpu_rt::error::Result;
use gpu_rt::film::{Film, Picture, RunRecord};
use gpu_rt::flatten::{Flat, flatten};
use gpu_rt::gpu::buffers::{BufferSpec, Buffers, Readback};
use gpu_rt::gpu::device::{Adapters, Device};
use gpu_rt::gpu::layout;
use gpu_rt::gpu::link::{Embedded, Library, link};
use gpu_rt::gpu::pipeline::{Pipeline, PipelineSpec};
use gpu_rt::plan::{Plan, Scatter, SettingsLayout, Tables, Tuning, choices_of};
use gpu_rt::render::{Goal, Job, Next, Renderer, TuningWish, tuning};
use gpu_rt::scene::Scene;

/// The production shaders, and the plain kernel beside them.
struct WithOneKernel;

impl Library for WithOneKernel {
    fn module(&self, name: &str) -> Option<&str> {
        match name {
            "bench/one_kernel" => Some(include_str!("shaders/one_kernel.wgsl")),
            _ => Embedded.module(name),
        }
    }
}

/// The plain tracer, ready to go.
struct OneKernel<'a> {
    device: &'a Device,
    buffers: Buffers,
    pipeline: Pipeline,
    records: Readback,
    pixels: u32,
    workgroup: u32,
}

impl<'a> OneKernel<'a> {
    fn new(device: &'a Device, flat: &Flat, plan: &Plan, tables: &Tables, job: &Job) -> Result<OneKernel<'a>> {
        let workgroup = 64;
        let choices = choices_of(&flat.features, tables);
        let linked = link(&WithOneKernel, "bench/one_kernel", &choices)?;
        let (module, _) = linked.validate()?;
        let bindings = layout::bindings(&module)?;
        let pixels = job.size.0 * job.size.1;
        let sizes = Tuning { slots: 1, workgroup, scatter: Scatter::Fused, records_per_slot: 1 };
        let mut specs = plan.buffers(flat, &sizes);
        specs.retain(|spec| bindings.contains_key(spec.name) && spec.name != "records");
        specs.push(BufferSpec::working("records", u64::from(pixels) * size_of::<RunRecord>() as u64, "a run a pixel"));
        let buffers = Buffers::create(device, &specs)?;
        let spec = PipelineSpec {
            name: "one_kernel",
            entry_point: "one_kernel",
            module: &module,
            bindings: &bindings,
            workgroup,
            constants: &[],
        };
        let pipeline = Pipeline::new(device, &spec, &buffers)?;
        let settings = Settings { max_depth: job.max_depth, seed: job.seed, slots: 1, ..flat.settings };
        device.queue.write_buffer(buffers.get("settings")?, 0, &SettingsLayout::of(&module)?.bytes(&settings));
        let records = Readback::new(device, "records", u64::from(pixels) * size_of::<RunRecord>() as u64);
        let this = OneKernel { device, buffers, pipeline, records, pixels, workgroup };
        this.pass(0, None)?;
        Ok(this)
    }

    /// A run of every pixel, added to the film; without a film nothing but the driver's compilation happens.
    fn pass(&self, block: u32, film: Option<&mut Film>) -> Result<()> {
        let window = Window { first_block: block, end: self.pixels, bounces: 0 };
        self.device.queue.write_buffer(self.buffers.get("window")?, 0, bytemuck::bytes_of(&window));
        let mut encoder = self.device.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let groups = if film.is_some() { self.pixels.div_ceil(self.workgroup) } else { 0 };
        self.pipeline.dispatch(&mut encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default()), groups);
        let bytes = u64::from(self.pixels) * size_of::<RunRecord>() as u64;
        self.records.copy(&mut encoder, self.buffers.get("records")?, bytes);
        let submission = self.device.queue.submit([encoder.finish()]);
        self.records.read(self.device, submission, bytes, |bytes| {
            if let Some(film) = film {
                film.add(bytemuck::cast_slice(bytes));
            }
        })
    }
}

fn median(mut numbers: Vec<f64>) -> f64 {
    numbers.sort_by(f64::total_cmp);
    numbers[numbers.len() / 2]
}

fn main() -> Result<()> {
    // Cargo passes `--bench`; the rest is ours.
    let args: Vec<String> = std::env::args().skip(1).filter(|arg| arg != "--bench").collect();
    let arg = |i: usize, default: &str| args.get(i).cloned().unwrap_or(default.to_string());
    let scene = Scene::load(Path::new(&arg(0, "scenes/weekend.ron")))?;
    let size = arg(1, "640x360");
    let (width, height) = size.split_once('x').expect("WIDTHxHEIGHT");
    let size = (width.parse().expect("width"), height.parse().expect("height"));
    let samples: u32 = arg(2, "8").parse().expect("samples");
    let rounds: usize = arg(3, "5").parse().expect("rounds");
    assert!(samples.is_multiple_of(RUN_LENGTH), "whole runs");

    let adapters = Adapters::find();
    let device = Device::open(adapters.choose(std::env::var("GPU_RT_BENCH_DEVICE").ok().as_deref())?)?;
    println!("{} at {}x{}, {samples} samples, on {}", arg(0, "scenes/weekend.ron"), size.0, size.1, device.name);
    let flat = flatten(&scene, size)?;
    let goal = Goal::Samples(samples);
    let job = Job { size, max_depth: scene.render.max_depth, seed: 0, first_sample: 0, goal };
    let class = device.class();
    let tables = Tables::new(&flat, class.table_bytes());
    let paths = f64::from(size.0) * f64::from(size.1) * f64::from(samples);

    let mut ways: Vec<(&str, Renderer)> = Vec::new();
    for (name, scatter) in [("fused", Scatter::Fused), ("linked", Scatter::Linked), ("queues", Scatter::Queues)] {
        let wish = TuningWish { scatter: Some(scatter), ..TuningWish::default() };
        let plan = Plan::with_tables(&flat.features, tuning(class, &job, wish).scatter, &tables)?;
        ways.push((name, Renderer::new(&device, &flat, &plan, &job, wish, false)?));
    }
    let plan = Plan::with_tables(&flat.features, Scatter::Fused, &tables)?;
    let plain = OneKernel::new(&device, &flat, &plan, &tables, &job)?;
    let mut rates = vec![Vec::new(); ways.len() + 1];
    for round in 0..=rounds {
        let mut pictures: Vec<Picture> = Vec::new();
        for (way, (_, renderer)) in ways.iter_mut().enumerate() {
            let mut film = Film::new(size.0, size.1, flat.radiance_exponent)?;
            let outcome = renderer.run(&job, &mut film, &mut |_, _| Next::GoOn)?;
            pictures.push(film.develop());
            // The first round warms up.
            if round > 0 {
                rates[way].push(paths / outcome.seconds);
            }
        }
        let mut film = Film::new(size.0, size.1, flat.radiance_exponent)?;
        let start = Instant::now();
        for block in 0..samples / RUN_LENGTH {
            plain.pass(block, Some(&mut film))?;
        }
        if round > 0 {
            rates[ways.len()].push(paths / start.elapsed().as_secs_f64());
        }
        pictures.push(film.develop());
        for picture in &pictures {
            assert!(picture.rgb == pictures[0].rgb, "the ways must do the same work");
        }
    }
    let plain_rates = rates[ways.len()].clone();
    println!("one kernel: {:.3} million paths/s (median of {rounds})", median(plain_rates.clone()) / 1e6);
    for ((name, _), rates) in ways.iter().zip(&rates) {
        let ratios: Vec<f64> = rates.iter().zip(&plain_rates).map(|(a, b)| a / b).collect();
        let (low, high) = ratios.iter().fold((f64::MAX, 0.0f64), |(low, high), r| (low.min(*r), high.max(*r)));
        println!(
            "wavefront, {name}: {:.3} million paths/s; {:.2} x the one kernel ({low:.2} to {high:.2})",
            median(rates.clone()) / 1e6,
            median(ratios),
        );
    }
    Ok(())
}
