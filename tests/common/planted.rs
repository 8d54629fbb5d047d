//! Renders by kernels in which production modules are replaced: for what no scene brings about.

use gpu_rt::data::Sampler;
use gpu_rt::film::Film;
use gpu_rt::flatten::{Wish, flatten_with};
use gpu_rt::gpu::layout;
use gpu_rt::gpu::link::link;
use gpu_rt::plan::{Bounce, Kernel, Plan, Scatter, Tables, choices_of};
use gpu_rt::render::{Goal, Job, Next, Renderer, TuningWish};
use gpu_rt::scene::Scene;

use crate::device::software;
use crate::kernel::Overlay;

/// Renders so many Sobol points of each pixel of a scene without media; not by queues.
pub fn render_planted(scene: &Scene, replaced: &[(&str, &str)], scatter: Scatter, samples: u32) -> Film {
    let size = (scene.image.width, scene.image.height);
    let wish = Wish { sampler: Sampler::Sobol, ..Wish::default() };
    let flat = flatten_with(scene, size, wish).expect("the scene flattens");
    assert!(flat.features.media == 0 && scatter != Scatter::Queues, "their kernels have choices of their own");
    let mut plan = Plan::new(&flat.features, scatter).expect("the kernels link");
    let (library, choices) = (Overlay::new(replaced), choices_of(&flat.features, &Tables::default()));
    let replace = |kernel: &mut Kernel| {
        let linked = link(&library, &format!("stage/{}", kernel.stage), &choices).expect("the kernel links");
        let (module, _) = linked.validate().unwrap_or_else(|error| panic!("{error}"));
        let bindings = layout::bindings(&module).expect("naga lays it out");
        *kernel = Kernel { linked, module, bindings, name: kernel.name.clone(), why: kernel.why.clone(), ..*kernel };
    };
    replace(&mut plan.generate);
    match &mut plan.bounce {
        Bounce::Fused(bounce) => replace(bounce),
        Bounce::Staged(staged) => {
            let stages = std::iter::once(&mut staged.intersect).chain(&mut staged.scatter).chain(&mut staged.shadow);
            stages.chain([&mut staged.refill]).for_each(replace);
        }
    }
    let max_depth = scene.render.max_depth;
    let job = Job { size, max_depth, seed: 0, first_sample: 0, goal: Goal::Samples(samples) };
    let mut renderer =
        Renderer::new(software(), &flat, &plan, &job, TuningWish::default(), false).expect("the kernels compile");
    let mut film = Film::with_sampler(size.0, size.1, flat.radiance_exponent, Sampler::Sobol).expect("the film fits");
    renderer.run(&job, &mut film, &mut |_, _| Next::GoOn).expect("the device renders");
    film
}
