//! Probes a driver's arithmetic where WGSL leaves it open or drivers are known to be wrong, with one dispatch of a small kernel
//! (shaders/stage/probe.wgsl). Its results are compared with the correct ones bit by bit. Shaders declare the properties that
//! they rely on. A kernel is refused if the driver lacks a property of one of its shaders.

use std::f64::consts::PI;

use super::buffers::{BufferSpec, Buffers, Readback};
use super::device::Device;
use super::layout;
use super::link::{Choices, Embedded, Linked, link};
use super::numerics::{LOG_ERROR, LOOPS, LOOPS_NEEDED, Numerics, PROPERTIES, Property, Rounding};
use super::pipeline::{Pipeline, PipelineSpec};
use crate::data::{Answer, Trial};
use crate::error::Result;

/// The number of trials of the probe, one for each invocation.
pub const TRIALS: usize = 64;

impl Numerics {
    /// Checks that the driver has all properties that a kernel relies on.
    ///
    /// # Errors
    /// `Error::Device` with the driver, the shader and the property.
    pub fn allow(&self, device: &Device, kernel: &str, linked: &Linked) -> Result<()> {
        for property in self.lacking() {
            if let Some((_, module)) = linked.relies.iter().find(|(name, _)| name == property.name) {
                return Err(device.failed(&format!(
                    "this driver {}. The kernel {kernel} relies on it (`{}`, in shaders/{module}.wgsl), and its image would be \
                     wrong. Update the driver, or choose another device: `gpu-rt devices` shows what each can do",
                    property.without, property.name
                )));
            }
        }
        Ok(())
    }
}

/// The findings of the probe about this device. The probe runs once.
///
/// # Errors
/// `Error::Device` if the device fails.
pub fn numerics(device: &Device) -> Result<&Numerics> {
    match device.numerics.get() {
        Some(found) => Ok(found),
        None => {
            let trials = trials();
            let mut found = judge(&trials, &run(device, &trials)?);
            // A GPU that rounds an fma once may fuse any product with a sum, in one kernel and not in another: that the kernel of the
            // probe has none says nothing of the others.
            if (found.fma_fused || found.contraction) && device.forbid_contraction() {
                found = judge(&trials, &run(device, &trials)?);
            }
            Ok(device.numerics.get_or_init(|| found))
        }
    }
}

/// Runs the probe and returns the results of this device.
pub fn run(device: &Device, trials: &[Trial]) -> Result<Vec<Answer>> {
    let linked = link(&Embedded, "stage/probe", &Choices::default())?;
    let (module, _) = linked.validate()?;
    let bindings = layout::bindings(&module)?;
    let bytes = size_of_val(trials) as u64;
    let why = "the numerics probe";
    let questions = BufferSpec::table("trials", bytemuck::cast_slice(trials).into(), bytes, why);
    let answers_bytes = (trials.len() * size_of::<Answer>()) as u64;
    let buffers = Buffers::create(device, &[questions, BufferSpec::working("answers", answers_bytes, why)])?;
    let spec = PipelineSpec {
        name: "probe",
        entry_point: "probe",
        module: &module,
        text: &linked.text,
        bindings: &bindings,
        workgroup: TRIALS as u32,
        constants: &[],
    };
    let pipeline = Pipeline::new(device, &spec, &buffers)?;
    let readback = Readback::new(device, "answers", answers_bytes);
    let mut encoder = device.encoder("probe");
    pipeline.dispatch(&mut encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default()), 1);
    readback.copy(device, &mut encoder, buffers.get("answers")?, 0, answers_bytes)?;
    let answers: Vec<Answer> =
        readback.read(device, device.submit(encoder), answers_bytes, bytemuck::pod_collect_to_vec)?;
    // The state of no generator is 0.
    device.expect_done(answers.iter().all(|answer| answer.loop_state != 0))?;
    Ok(answers)
}

/// The inputs of the trials, which are always the same.
pub fn trials() -> Vec<Trial> {
    let mut random = TrialNumbers(1);
    (0..TRIALS).map(|index| trial(index, &mut random)).collect()
}

fn trial(index: usize, random: &mut TrialNumbers) -> Trial {
    // NaNs of both signs, quiet and signalling; infinities; and numbers with similar bits.
    const SPECIAL: [u32; 8] =
        [0x7fc0_0000, 0xffc0_0001, 0x7f80_0001, 0xffff_ffff, 0x7f80_0000, 0xff80_0000, 0x7f7f_ffff, 0x4000_0000];
    // Ties, words that round up to 2^32, and words of 24 bits.
    const WORDS: [u32; 8] =
        [0xffff_ffff, 0xffff_ff80, 0xffff_ff7f, 0x0100_0001, 0x0100_0003, 0x8000_0080, 0x00ff_ffff, 0];
    let share = index as f64 / (TRIALS - 1) as f64;
    let (x, y) = loop {
        let small = random.float(-12, -1);
        let (x, y) = if index.is_multiple_of(2) { (random.float(0, 1), small) } else { (small, random.float(0, 1)) };
        if error_of_sum(x, y) != 0.0 && error_of_product(x, y) != 0.0 {
            break (x, y);
        }
    };
    let [p, q] = loop {
        let (p, q_y) = ([random.float(-3, 3), random.float(-3, 3)], random.float(-3, 3));
        let q = [(f64::from(p[0]) * f64::from(q_y) / f64::from(p[1])) as f32, q_y];
        if exact_edge_sign(p, q) != 0 {
            break [p, q];
        }
    };
    Trial {
        x,
        y,
        product: x * y,
        // The f32 nearest to pi is larger than pi.
        angle: (((2.0 * share - 1.0) * PI) as f32).clamp(-(PI as f32).next_down(), (PI as f32).next_down()),
        far_angle: 10f64.powf(1.0 + 5.0 * share) as f32,
        // 1 - 2^-1 to 1 - 2^-24, and between.
        log_of: match index {
            0..24 => 1.0 - 2f32.powi(-1 - index as i32),
            _ => (1.0 - 0.5 * share) as f32,
        },
        word: WORDS.get(index).copied().unwrap_or_else(|| random.bits()),
        special: SPECIAL[index % SPECIAL.len()],
        // A 16th of it has all of its digits, unless it is flushed.
        least: 0x0080_0000 | (random.bits() & 0x007f_fff0),
        subnormal: 1 | (random.bits() & 0x007f_ffff),
        zero: 0,
        loops: if index == 0 { LOOPS } else { 0 },
        p_x: p[0],
        p_y: p[1],
        q_x: q[0],
        q_y: q[1],
    }
}

/// The findings from a driver's results.
pub fn judge(trials: &[Trial], answers: &[Answer]) -> Numerics {
    let is_complete = answers.len() == trials.len();
    let all = |right: &dyn Fn(&Trial, &Answer) -> bool| {
        is_complete && trials.iter().zip(answers).all(|(trial, answer)| right(trial, answer))
    };
    let any = |wrong: &dyn Fn(&Trial, &Answer) -> bool| !all(&|trial, answer| !wrong(trial, answer));
    let largest = |error: &dyn Fn(&Trial, &Answer) -> f64| {
        let errors = trials.iter().zip(answers).map(|(trial, answer)| error(trial, answer));
        // A NaN is as wrong as can be.
        let none = if is_complete { 0.0 } else { f64::INFINITY };
        errors.fold(none, |most: f64, error| if error.is_nan() { f64::INFINITY } else { most.max(error) })
    };
    let off = |bits: u32, right: f64| (f64::from(f32::from_bits(bits)) - right).abs();
    let of_nan = |trial: &Trial, answer: &Answer, said: u32| {
        let bits = answer.classes_of_special & 0b1110;
        !f32::from_bits(trial.special).is_nan()
            || if said == 1 { answer.classes_of_special & 1 == 1 } else { bits == said }
    };
    let log = |trial: &Trial| f64::from(trial.log_of).ln();
    let nearest = all(&|trial, answer| answer.converted == (trial.word as f32).to_bits());
    let towards_zero = all(&|trial, answer| answer.converted == truncated(trial.word).to_bits());
    Numerics {
        two_sum: all(&|trial, answer| answer.sum_error == error_of_sum(trial.x, trial.y).to_bits()),
        two_sum_barrier: all(&|trial, answer| answer.sum_error_barrier == error_of_sum(trial.x, trial.y).to_bits()),
        two_product_barrier: all(&|trial, answer| {
            answer.product_error_barrier == error_of_product(trial.x, trial.y).to_bits()
        }),
        fma_fused: all(&|trial, answer| answer.fma_error == error_of_product(trial.x, trial.y).to_bits()),
        contraction: any(&|_, answer| answer.contracted & 0x7fff_ffff != 0),
        nan_compares: all(&|trial, answer| of_nan(trial, answer, 1)),
        nan_fails_comparisons: all(&|trial, answer| of_nan(trial, answer, 0b1000)),
        nan_by_bits: all(&|trial, answer| answer.classes_of_special & CLASSES_BY_BITS == classes_by_bits(trial)),
        loop_iterations: answers.first().map_or(0, |answer| loops_until(answer.loop_state)),
        subnormals: all(&|trial, answer| {
            let made = f64::from(f32::from_bits(trial.least)) / 16.0;
            let from = f64::from(f32::from_bits(trial.subnormal)) * 16_777_216.0;
            answer.made_subnormal == (made as f32).to_bits() && answer.from_subnormal == (from as f32).to_bits()
        }),
        conversion: match (nearest, towards_zero) {
            (true, _) => Rounding::Nearest,
            (_, true) => Rounding::TowardsZero,
            _ => Rounding::Neither,
        },
        words_reach_one: any(&|_, answer| f32::from_bits(answer.uniform_of_32) >= 1.0),
        uniforms_exact: all(&|trial, answer| answer.uniform_of_24 == uniform_of_24(trial)),
        log_error: largest(&|trial, answer| off(answer.logarithm, log(trial))),
        log_relative_error: largest(&|trial, answer| off(answer.logarithm, log(trial)) / log(trial).abs()),
        sin_error: largest(&|trial, answer| off(answer.sine, f64::from(trial.angle).sin())),
        sin_error_far: largest(&|trial, answer| off(answer.far_sine, f64::from(trial.far_angle).sin())),
        edge_signs: all(&|trial, answer| answer.edge_sign == edge_sign(trial)),
    }
}

/// The right answers of the trials to a property of [`super::numerics::PROPERTIES`], by one member of the answers.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Expected {
    pub property: &'static str,
    pub without: &'static str,
    pub member: &'static str,
    pub right: Right,
}

/// How an answer is right.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Right {
    /// The bits of `mask` are those of `words`.
    Words { mask: u32, words: Vec<u32> },
    /// As a float it is at most `error` away.
    Floats { error: f64, values: Vec<f64> },
    /// It is the state of a generator that has made at least so many steps. If it has made `all`, loops have no limit.
    Loops { least: u32, all: u32 },
}

/// The right answers, for programs that run the probe elsewhere.
pub fn expected(trials: &[Trial]) -> Vec<Expected> {
    let words = |mask, right: &dyn Fn(&Trial) -> u32| Right::Words { mask, words: trials.iter().map(right).collect() };
    let logarithms: Vec<f64> = trials.iter().map(|trial| f64::from(trial.log_of).ln()).collect();
    let of = |name: &str| match name {
        "loops" => ("loop_state", Right::Loops { least: LOOPS_NEEDED, all: LOOPS }),
        "uniforms" => ("uniform_of_24", words(u32::MAX, &uniform_of_24)),
        "bits" => ("classes_of_special", words(CLASSES_BY_BITS, &classes_by_bits)),
        "signs" => ("edge_sign", words(u32::MAX, &|trial| edge_sign(trial) as u32)),
        _ => ("logarithm", Right::Floats { error: LOG_ERROR, values: logarithms.clone() }),
    };
    let expected = |Property { name, without, .. }| {
        let (member, right) = of(name);
        Expected { property: name, without, member, right }
    };
    PROPERTIES.into_iter().map(expected).collect()
}

/// The bits of `classes_of_special` that tests by bits set.
const CLASSES_BY_BITS: u32 = 0b11_0000;

/// The right ones of these bits.
fn classes_by_bits(trial: &Trial) -> u32 {
    let special = f32::from_bits(trial.special);
    u32::from(special.is_nan()) << 4 | u32::from(special.is_infinite()) << 5
}

/// The right bits of `uniform_of_24`.
fn uniform_of_24(trial: &Trial) -> u32 {
    ((trial.word >> 8) as f32 / 16_777_216.0).to_bits()
}

/// The right `edge_sign`.
fn edge_sign(trial: &Trial) -> i32 {
    exact_edge_sign([trial.p_x, trial.p_y], [trial.q_x, trial.q_y])
}

/// x + y minus its rounding to f32. Exact for exponents that are at most 24 apart, because their sum in f64 is.
fn error_of_sum(x: f32, y: f32) -> f32 {
    let exact = f64::from(x) + f64::from(y);
    (exact - f64::from(exact as f32)) as f32
}

/// x y minus its rounding to f32. Exact, because the product has at most 48 digits.
fn error_of_product(x: f32, y: f32) -> f32 {
    let exact = f64::from(x) * f64::from(y);
    (exact - f64::from(exact as f32)) as f32
}

/// The sign of p.x q.y - p.y q.x. The products are exact in f64.
fn exact_edge_sign(p: [f32; 2], q: [f32; 2]) -> i32 {
    let product = |a: f32, b: f32| f64::from(a) * f64::from(b);
    product(p[0], q[1]).total_cmp(&product(p[1], q[0])) as i32
}

/// The float of the word's upper 24 bits.
fn truncated(word: u32) -> f32 {
    let digits = 32 - word.leading_zeros();
    let dropped = digits.saturating_sub(24);
    (word >> dropped << dropped) as f32
}

/// The number of steps after which the probe's generator reaches this state; 0 if it never does.
fn loops_until(state: u32) -> u32 {
    let step = |state: &u32| Some(state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223));
    let found = std::iter::successors(Some(1), step).take(LOOPS as usize + 1).position(|reached| reached == state);
    found.unwrap_or_default() as u32
}

/// Numbers for the trials: SplitMix64 (Steele, Lea and Flood, OOPSLA 2014).
struct TrialNumbers(u64);

impl TrialNumbers {
    fn bits(&mut self) -> u32 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 32) as u32
    }

    /// A number with 24 random digits, a random sign, and a random exponent from `low` to below `high`.
    fn float(&mut self, low: i32, high: i32) -> f32 {
        let digits = self.bits();
        let exponent = low + (self.bits() % (high - low) as u32) as i32;
        let size = (1.0 + f64::from(digits & 0x007f_ffff) / 8_388_608.0) * 2f64.powi(exponent);
        if digits >> 31 == 0 { size as f32 } else { -size as f32 }
    }
}
