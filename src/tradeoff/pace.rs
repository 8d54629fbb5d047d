//! The relative times of settings, on a machine that other load slows down at times.
//!
//! Every round times every setting once, in quick succession, so that a load of some seconds slows all of them alike.
//! The logarithm of a time is therefore the sum of the setting's own time, the slowdown of the round, and a residual. A
//! median polish (Tukey, Exploratory Data Analysis, 1977, chapter 11) finds the first two; single slow blocks do not
//! affect it.

/// The time of a setting.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pace {
    /// In a typical round.
    pub seconds: f64,
    /// Half the interquartile range, after the slowdown of the rounds is removed.
    pub spread: f64,
    /// The relative standard error.
    pub doubt: f64,
}

/// The interquartile range of a normal variate in standard deviations, and the factor of the median's standard error
/// over that of the mean.
const QUARTILES_PER_DEVIATION: f64 = 1.349;
const ERROR_OF_MEDIAN: f64 = 1.2533;
const PASSES: usize = 10;

/// The paces of settings from their times in each round. Uses the rounds that all settings have.
pub fn paces(times: &[&[f64]]) -> Vec<Pace> {
    let rounds = times.iter().map(|times| times.len()).min().unwrap_or(0);
    let logs: Vec<Vec<f64>> = times.iter().map(|times| times[..rounds].iter().map(|t| t.ln()).collect()).collect();
    let mut of_setting: Vec<f64> = logs.iter().map(|logs| median(logs)).collect();
    let mut of_round = vec![0.0; rounds];
    for _ in 0..PASSES {
        for (round, slowed) in of_round.iter_mut().enumerate() {
            *slowed = median(&logs.iter().zip(&of_setting).map(|(logs, own)| logs[round] - own).collect::<Vec<_>>());
        }
        for (own, logs) in of_setting.iter_mut().zip(&logs) {
            *own = median(&rest(logs, &of_round));
        }
    }
    let usual = median(&of_round);
    logs.iter()
        .map(|logs| {
            let rest: Vec<f64> = rest(logs, &of_round).iter().map(|rest| rest + usual).collect();
            let [low, middle, high] = [0.25, 0.5, 0.75].map(|share| quantile(&rest, share));
            let deviation = (high - low) / QUARTILES_PER_DEVIATION;
            Pace {
                seconds: middle.exp(),
                spread: 0.5 * (high.exp() - low.exp()),
                doubt: ERROR_OF_MEDIAN * deviation / (rounds as f64).sqrt(),
            }
        })
        .collect()
}

fn rest(logs: &[f64], of_round: &[f64]) -> Vec<f64> {
    logs.iter().zip(of_round).map(|(log, slowed)| log - slowed).collect()
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

    #[test]
    fn slow_rounds_and_single_slow_blocks_do_not_count() {
        let own = [1.0, 1.1, 0.5, 2.0];
        // The second half of the rounds is 40 % slower, and one block of each setting is much slower.
        let time = |setting: usize, round: usize| {
            let slowed = if round >= 6 { 1.4 } else { 1.0 };
            let jitter = 1.0 + 0.002 * ((7 * setting + 3 * round) % 5) as f64;
            let burst = if round == 2 * setting + 1 { 3.0 } else { 1.0 };
            own[setting] * slowed * jitter * burst
        };
        let times: Vec<Vec<f64>> = (0..4).map(|s| (0..11 + s).map(|round| time(s, round)).collect()).collect();
        let found = paces(&times.iter().map(Vec::as_slice).collect::<Vec<_>>());
        for (setting, pace) in found.iter().enumerate() {
            // Jitter is 1 % at most.
            let ratio = pace.seconds / found[0].seconds / own[setting];
            assert!((ratio - 1.0).abs() < 0.01 && pace.doubt < 0.01 && pace.spread < 0.02, "{setting}: {pace:?}");
        }
        // The control: plain medians are off by as much as the rounds are.
        let halves = [median(&times[0][..6]), median(&times[0][6..])];
        assert!(halves[1] / halves[0] > 1.3);
        // For a single setting the result is its median.
        assert_eq!(paces(&[&[2.0, 1.0, 4.0]])[0].seconds, 2f64.ln().exp());
        assert!(paces(&[]).is_empty());
    }

    #[test]
    fn a_doubt_is_of_the_median() {
        // One setting has a spread of 10 % over 16 rounds; two others have none.
        let uneven: Vec<f64> = (0..16).map(|i| (0.1 * ((5 * i) % 16) as f64 / 16.0).exp()).collect();
        let even = [1.0; 16];
        let found = paces(&[&uneven, &even, &even]);
        let expected = ERROR_OF_MEDIAN * 0.05 / QUARTILES_PER_DEVIATION / 4.0;
        assert!((found[0].doubt / expected - 1.0).abs() < 0.1, "{found:?}");
        assert!(found[1].doubt < 1e-9);
    }
}
