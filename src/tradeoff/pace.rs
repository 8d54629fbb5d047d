//! The relative times of settings, on a machine that other load slows down at times.
//!
//! The defaults are timed again and again between the blocks of the other settings: they are the clock. A block's time counts relative to the
//! clock around it, so that a load that lasts longer than a few blocks slows both alike. The interval of a time comes from the differences
//! between rounds that remain.

use crate::metrics::estimate::CONFIDENCE;
use crate::metrics::student;

/// A block of samples: the time of its middle, in seconds since some moment, and the seconds that it took.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Timed {
    pub at: f64,
    pub seconds: f64,
}

/// The time of a setting.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pace {
    /// Seconds, at the speed of the machine in the median block of the clock.
    pub seconds: f64,
    /// Half the width of the interval of their logarithm, with [`CONFIDENCE`].
    pub half_width: f64,
}

/// The standard error of a median over that of the mean, for normal variates.
const ERROR_OF_MEDIAN: f64 = 1.2533;

/// The paces of settings from the times of their blocks in each round, and those of the clock, in the order of time. Blocks of the clock that are
/// blocks of a setting too do not count for themselves.
pub fn paces(settings: &[&[Timed]], clock: &[Timed]) -> Vec<Pace> {
    let relative: Vec<Vec<f64>> = settings
        .iter()
        .map(|blocks| blocks.iter().map(|block| block.seconds.ln() - clock_around(clock, block.at)).collect())
        .collect();
    let squares = |logs: &[f64]| {
        let mean = logs.iter().sum::<f64>() / logs.len() as f64;
        logs.iter().map(|log| (log - mean).powi(2)).sum::<f64>()
    };
    // The variance between rounds comes from the machine more than from a setting, so no setting has less than the pooled estimate: three
    // rounds that agree by chance prove nothing.
    let degrees = |logs: &Vec<f64>| logs.len().saturating_sub(1) as f64;
    let all_degrees = relative.iter().map(degrees).sum::<f64>();
    let pooled = relative.iter().map(|logs| squares(logs)).sum::<f64>() / all_degrees;
    let usual = median(&clock.iter().map(|block| block.seconds.ln()).collect::<Vec<_>>());
    let pace = |logs: &Vec<f64>| {
        let own = squares(logs) / degrees(logs);
        let (variance, degrees) = if own > pooled { (own, degrees(logs)) } else { (pooled, all_degrees) };
        let error = ERROR_OF_MEDIAN * (variance / logs.len() as f64).sqrt();
        Pace {
            seconds: (usual + median(logs)).exp(),
            half_width: error * student::quantile(1.0 - CONFIDENCE, degrees.max(1.0)),
        }
    };
    relative.iter().map(pace).collect()
}

/// The logarithm of the clock's seconds at a time: between its blocks before and after, by their distance.
fn clock_around(clock: &[Timed], at: f64) -> f64 {
    let before = clock.iter().rfind(|block| block.at < at);
    let after = clock.iter().find(|block| block.at > at);
    match (before, after) {
        (Some(before), Some(after)) => {
            let share = (at - before.at) / (after.at - before.at);
            (1.0 - share) * before.seconds.ln() + share * after.seconds.ln()
        }
        (Some(only), None) | (None, Some(only)) => only.seconds.ln(),
        // The clock has one block, at this time.
        (None, None) => clock.first().map_or(0.0, |block| block.seconds.ln()),
    }
}

/// How much the speed of the machine changed: the ratio of the clock's slow blocks to its fast ones, at the ends of the middle 80 %.
pub fn swing(clock: &[Timed]) -> f64 {
    let seconds: Vec<f64> = clock.iter().map(|block| block.seconds).collect();
    if seconds.is_empty() { 1.0 } else { quantile(&seconds, 0.9) / quantile(&seconds, 0.1) }
}

/// The median.
pub fn median(values: &[f64]) -> f64 {
    quantile(values, 0.5)
}

fn quantile(values: &[f64], share: f64) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let at = share * (sorted.len().saturating_sub(1)) as f64;
    let (low, high) = (at.floor() as usize, at.ceil() as usize);
    match sorted.get(high) {
        Some(above) => sorted[low] + (above - sorted[low]) * (at - low as f64),
        None => f64::NAN,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tradeoff::replicates::tests::Random;

    /// A machine whose speed changes: uniform numbers that are the same in every run of the test.
    struct Machine {
        random: Random,
        now: f64,
        /// How much slower it is, and until when.
        load: f64,
        until: f64,
    }

    impl Machine {
        fn new(seed: u64) -> Machine {
            Machine { random: Random(seed), now: 0.0, load: 1.0, until: 0.0 }
        }

        /// Renders a block that takes so many seconds on the idle machine, with a jitter of 4 %. A load of up to 80 % comes and goes, and stays
        /// for `stays` seconds at a time.
        fn block(&mut self, seconds: f64, stays: f64) -> Timed {
            if self.now >= self.until {
                self.load = if self.random.uniform() < 0.5 { 1.0 } else { 1.0 + 0.8 * self.random.uniform() };
                self.until = self.now - stays * self.random.uniform().ln();
            }
            let took = seconds * self.load * (1.0 + 0.04 * (self.random.uniform() - 0.5));
            let at = self.now + 0.5 * took;
            self.now += took;
            Timed { at, seconds: took }
        }
    }

    const SETTINGS: usize = 12;
    const ROUNDS: usize = 6;

    /// The blocks of settings that take the times given, and of the clock between every three of them.
    fn sweep(machine: &mut Machine, own: &[f64], stays: f64) -> (Vec<Vec<Timed>>, Vec<Timed>) {
        let (mut blocks, mut clock) = (vec![Vec::new(); own.len()], Vec::new());
        for round in 0..ROUNDS {
            for position in 0..own.len() {
                if position % 3 == 0 {
                    clock.push(machine.block(own[0], stays));
                }
                let setting = (position + round) % own.len();
                let block = machine.block(own[setting], stays);
                blocks[setting].push(block);
                clock.extend((setting == 0).then_some(block));
            }
            clock.push(machine.block(own[0], stays));
        }
        (blocks, clock)
    }

    fn paces_of_blocks(blocks: &[Vec<Timed>], clock: &[Timed]) -> Vec<Pace> {
        paces(&blocks.iter().map(Vec::as_slice).collect::<Vec<_>>(), clock)
    }

    /// How many settings differ from the first one by more than the intervals of both.
    fn differing(found: &[Pace]) -> usize {
        let differs =
            |pace: &&Pace| (pace.seconds / found[0].seconds).ln().abs() > pace.half_width.hypot(found[0].half_width);
        found[1..].iter().filter(differs).count()
    }

    /// On a busy machine, at most one in twenty settings that do the same work is faster or slower by its interval, whether the load
    /// stays for a part of a block or for all of a sweep. Planted: all blocks of a setting one after another, and no clock.
    #[test]
    fn load_makes_no_setting_faster() {
        const SEEDS: u64 = 60;
        let count = SEEDS as usize * (SETTINGS - 1);
        for stays in [0.3, 3.0, 30.0, 300.0] {
            let (mut wrong, mut planted) = (0, 0);
            for seed in 0..SEEDS {
                let (blocks, clock) = sweep(&mut Machine::new(1000 + seed), &[1.0; SETTINGS], stays);
                wrong += differing(&paces_of_blocks(&blocks, &clock));
                let mut machine = Machine::new(1000 + seed);
                let one_by_one: Vec<Vec<Timed>> =
                    (0..SETTINGS).map(|_| (0..ROUNDS).map(|_| machine.block(1.0, stays)).collect()).collect();
                planted += differing(&paces_of_blocks(&one_by_one, &[one_by_one[0][0]]));
            }
            println!("load for {stays} s: {wrong} of {count} are found to differ, and without a clock {planted}");
            // 5 %, and three standard errors of that share of 660.
            assert!(wrong as f64 <= 0.075 * count as f64, "load for {stays} s: {wrong}");
            assert!(stays != 30.0 || planted > count / 5, "{planted}");
        }
    }

    /// A setting that takes 30 % less time is found where the load stays for longer than a block, and its time is known to 25 %.
    #[test]
    fn a_faster_setting_is_found_under_load() {
        for (stays, least) in [(3.0, 30), (30.0, 50)] {
            let mut found = 0;
            for seed in 0..60 {
                let mut own = [1.0; SETTINGS];
                own[5] = 0.7;
                let (blocks, clock) = sweep(&mut Machine::new(2000 + seed), &own, stays);
                let paces = paces_of_blocks(&blocks, &clock);
                let ratio = (paces[5].seconds / paces[0].seconds).ln();
                found += usize::from(ratio < -paces[5].half_width.hypot(paces[0].half_width));
                assert!((ratio - 0.7f64.ln()).abs() < 0.25, "{stays}: {ratio}");
            }
            println!("load for {stays} s: found {found} of 60 times");
            assert!(found >= least, "load for {stays} s: {found} of 60");
        }
    }

    /// Intervals of an idle machine are as wide as its jitter, and its speed does not swing.
    #[test]
    fn an_idle_machine_has_narrow_intervals() {
        let mut machine = Machine { until: f64::INFINITY, ..Machine::new(7) };
        let (blocks, clock) = sweep(&mut machine, &[1.0, 1.1, 0.5, 2.0], 1.0);
        let found = paces_of_blocks(&blocks, &clock);
        for (own, pace) in [1.0, 1.1, 0.5, 2.0].into_iter().zip(&found) {
            assert!((pace.seconds / own).ln().abs() < pace.half_width && pace.half_width < 0.04, "{pace:?}");
        }
        assert!(swing(&clock) < 1.05);
        let busy =
            (0..20).filter(|&seed| swing(&sweep(&mut Machine::new(seed), &[1.0; SETTINGS], 3.0).1) > 1.3).count();
        assert!(busy >= 18, "{busy} of 20");
        assert!(paces(&[], &[]).is_empty() && swing(&[]) == 1.0);
    }
}
