//! Samples that are not finite: found by their bits, dropped, and counted by reason and pixel.

use gpu_rt::film::{Film, Totals};
use gpu_rt::gpu::probe::numerics;
use gpu_rt::options::Scatter;
use gpu_rt::output::exr::{read_exr, write_exr};

use crate::common::device;
use crate::common::kernel::{Fault, Kernel, Overlay};
use crate::common::render::{Request, render_planted, scene};
use crate::common::rows::rows;
use crate::common::stats::Random;
use crate::common::vectors::decades;
use crate::table::{COMPARED_NAN, Cell};

const WIDTH: u32 = 16;
const HEIGHT: u32 = 8;
const SAMPLES: u32 = 32;
const COLOUR: [f32; 3] = [0.25, 0.5, 0.75];
/// Makes 2 of 8 samples NaN and 1 infinite, in the right half of the image.
const PLANTED: [Fault<'_>; 2] = [
    // A quarter of the rays there have a direction of length 2, and an eighth one of length 4.
    (
        "camera/pinhole",
        "camera_direction(film",
        "select(1.0, select(select(1.0, 4.0, u.x >= 0.875), 2.0, u.x < 0.25), 2u * column >= settings.image_width) \
         * camera_direction(film",
    ),
    // The square root of a negative number for those of length 2, and an overflow for those of length 4.
    (
        "background/solid",
        "return settings.background_bottom",
        "let size = length(direction);
        return settings.background_bottom * select(select(1.0, sqrt(1.5 - size), size > 1.5), 3e38 * size, size > 3.0)",
    ),
];
/// A compiler may assume that a NaN is equal to itself.
const COMPARED: Fault<'_> = ("lib/float", "(bitcast<u32>(x) & 0x7fffffffu) > 0x7f800000u", "x != x");

/// Whether `x != x` misses a NaN on this device.
pub fn folds() -> bool {
    !numerics(device::software()).expect("the probe runs").nan_compares
}

/// A sky of one colour, of which three of eight samples in the right half are no numbers. A sphere behind the camera uses all
/// kernels that a bounce has.
fn broken_sky(scatter: Scatter, more: &[Fault<'_>]) -> Film {
    let text = format!(
        "Scene(image: (width: {WIDTH}, height: {HEIGHT}),
         camera: (look_from: (0, 0, 0), look_at: (0, 0, -1), vertical_fov: 40), background: Solid({:?}),
         materials: {{ \"m\": Lambertian(albedo: Rgb(0.5, 0.5, 0.5)) }},
         objects: [Sphere(center: (0, 0, 9), radius: 1, material: \"m\")])",
        (COLOUR[0], COLOUR[1], COLOUR[2])
    );
    let request = Request::spp(SAMPLES).sobol().scatter(scatter);
    render_planted(&scene(&text), &request, &Overlay::new(&[&PLANTED[..], more].concat())).film
}

/// Samples that are counted under a reason that is not theirs, or not counted at all.
fn misplaced(Totals { rejected, .. }: Totals) -> f64 {
    let half = u64::from(WIDTH / 2 * HEIGHT * SAMPLES);
    let reasons = [(rejected.nan, half / 4), (rejected.infinite, half / 8), (rejected.cut, 0), (rejected.refused, 0)];
    reasons.iter().map(|(found, planted)| found.abs_diff(*planted)).sum::<u64>() as f64
}

/// Pixels whose colour is not exactly the sky's.
fn discoloured(film: &Film) -> f64 {
    film.develop().rgb.iter().filter(|rgb| **rgb != COLOUR).count() as f64
}

rows! {
    struct In { x: f32, y: f32, operation: u32, padding: u32 }
}

/// Numbers and others made by division, difference, product, root, logarithm and exponential, that the device takes for
/// something else than what their bits say, of some 1000; and how many of them were NaN, and infinite.
fn mistaken(kernel: &Kernel) -> (f64, [u32; 2]) {
    let (nan, infinity) = (f32::NAN, f32::INFINITY);
    let special = [0.0, -0.0, 1.0, -1.0, 3e38, -3e38, 1000.0, infinity, -infinity, nan, 1e-38];
    let mut rows: Vec<In> = Vec::new();
    for operation in 0..6 {
        rows.extend(special.iter().flat_map(|&x| special.map(|y| In { x, y, operation, padding: 0 })));
    }
    let mut random = Random(71);
    let mut any = || (decades(&mut random, -30.0, 30.0)) as f32;
    rows.extend((0..300).map(|row| In { x: any(), y: any(), operation: row % 6, padding: 0 }));
    let mut found = [0; 2];
    let wrong = kernel.run::<_, [u32; 4]>(&rows).into_iter().filter(|[made, nan, infinite, _]| {
        let made = f32::from_bits(*made);
        found[0] += u32::from(made.is_nan());
        found[1] += u32::from(made.is_infinite());
        (*nan != 0, *infinite != 0) != (made.is_nan(), made.is_infinite())
    });
    (wrong.count() as f64, found)
}

/// The table's cells of rejection.
pub fn cells() -> Vec<Cell> {
    // The form is wrong only where the compiler takes x != x for false.
    let folds = folds();
    let plant = |cell: Cell, figure: &dyn Fn() -> f64| match folds {
        true => cell.planted(COMPARED_NAN, figure()),
        false => cell,
    };
    let mut all = Vec::new();
    let compared = [COMPARED];
    let kernel = |replaced| Kernel::replacing("test/broken", replaced);
    let (wrong, found) = mistaken(&kernel(&[]));
    assert!(found.iter().all(|&n| n > 50), "NaN and infinities are made at all: {found:?}");
    let cell = Cell::new(
        "0/0, inf - inf, 0 inf, roots and logarithms below 0, overflows; numbers from 1e-30 to 1e30",
        "Of 1026 values made in a kernel, those that are wrongly classified as finite or not finite",
        0.0,
        "none, because the test uses the bits.",
    )
    .achieved(wrong);
    all.push(plant(cell, &|| mistaken(&kernel(&compared)).0));
    for (name, scatter) in [("one kernel", Scatter::Fused), ("a kernel a stage", Scatter::Linked)] {
        let own = broken_sky(scatter, &[]);
        let wrong = folds.then(|| broken_sky(scatter, &compared));
        let wrong = |figure: &dyn Fn(&Film) -> f64| wrong.as_ref().map_or(f64::NAN, figure);
        let range = format!("of 4096 samples 512 are NaN and 256 infinite; {name}");
        let counts = Cell::new(
            &range,
            "Samples of a render that are counted for a wrong reason, or not at all",
            0.0,
            "none, because each is rejected separately, for its own reason.",
        )
        .achieved(misplaced(own.totals));
        all.push(plant(counts, &|| wrong(&|film| misplaced(film.totals))));
        let colours = Cell::new(
            &range,
            "Pixels of 128 that do not have exactly the sky's colour",
            0.0,
            "none, because a rejected sample does not change the mean of the others, which all have one colour.",
        )
        .achieved(discoloured(&own));
        all.push(plant(colours, &|| wrong(&discoloured)));
    }
    all
}

/// Injected samples that are not finite stand in the image's file, pixel by pixel, and the others are all there.
#[test]
fn injected_samples_are_dropped_and_counted_by_reason_and_pixel() {
    for scatter in [Scatter::Fused, Scatter::Linked] {
        let film = broken_sky(scatter, &[]);
        let totals = film.totals;
        assert_eq!(totals.paths, u64::from(WIDTH * HEIGHT * SAMPLES));
        assert_eq!(misplaced(totals), 0.0, "{scatter:?}: {totals:?}");
        let sandbox = tempfile::tempdir().expect("a temporary folder");
        let file = sandbox.path().join("sky.exr");
        write_exr(&file, &film.develop(), &[]).expect("it is written");
        let image = read_exr(&file).expect("it is read");
        let by_pixel = |left: u32, right: u32| {
            let columns = (0..WIDTH).map(|column| if 2 * column < WIDTH { left } else { right });
            Some(columns.collect::<Vec<_>>().repeat(HEIGHT as usize))
        };
        assert_eq!(image.rejected, by_pixel(0, 3 * SAMPLES / 8), "{scatter:?}");
        assert_eq!(image.samples, by_pixel(SAMPLES, 5 * SAMPLES / 8), "{scatter:?}");
        assert!(image.rgb.iter().all(|rgb| *rgb == COLOUR), "{scatter:?}");
    }
}
