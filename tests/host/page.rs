//! The page that `gpu-rt tradeoff` writes: what stands first, what is folded, and that no screen is too narrow for it.

use gpu_rt::metrics::estimate::Estimate;
use gpu_rt::options::{RenderOptions, TRADE_OFFS};
use gpu_rt::tradeoff::judge::Measured;
use gpu_rt::tradeoff::model::{Falling, Model, Ranking};
use gpu_rt::tradeoff::page::html;
use gpu_rt::tradeoff::report::{Example, Findings};
use gpu_rt::tradeoff::sweep::{Setting, Unmeasured};

fn setting(option: Option<(&str, &str)>) -> Setting {
    let (name, value) = option.unzip();
    let option = name.map(|name| *TRADE_OFFS.iter().find(|option| option.name == name).expect("a declared option"));
    let value = value.unwrap_or_default().to_string();
    Setting { option, value, options: RenderOptions::default(), max_depth: 50, scale: 1.0, denoise: false }
}

/// A setting whose noise was measured with these numbers of samples.
fn measured(setting: Setting, samples: &[u32]) -> Measured {
    let noise = Falling { noise: 0.5, ..Falling::SILENT };
    let none = Estimate { value: 0.0, error: 0.0, degrees: 8.0 };
    let seconds_to = |target: f64| Some(0.5 / target * 0.1);
    Measured {
        setting,
        rounds: 8,
        seconds_compile: 0.1,
        seconds_here: 0.1,
        seconds_half_width: 0.002,
        seconds_error: 0.01,
        model: Model { squared_bias: 0.0, squared_bias_upper: 0.0, noise, seconds: 0.1, fixed_seconds: 0.0 },
        flips: samples.iter().map(|&samples| (samples, 0.5 / f64::from(samples).sqrt())).collect(),
        noises: samples.iter().map(|&samples| (samples, noise.at(f64::from(samples)))).collect(),
        signed: none,
        squared: none,
        biased: false,
        lacks_paths: false,
        against_reference: false,
        reliable: true,
        reasons_unreliable: Vec::new(),
        relmse_ratio: 0.5,
        bias_known: true,
        noise_error: 0.01,
        times: [1e-1, 1e-2, 1e-3].map(seconds_to),
        ranking: Ranking::Front,
    }
}

/// The findings if the defaults were measured with these numbers of samples.
fn findings(samples: &[u32]) -> Findings {
    Findings {
        // A name that no line has room for, with letters that HTML gives a meaning.
        scene: format!("{}<&>.ron", "x".repeat(90)),
        device: "a device".into(),
        driver: "its driver".into(),
        size: (64, 64),
        full_size: (64, 64),
        calibration: None,
        seed: 0,
        budget: 60.0,
        seconds: 50.0,
        swing: 1.0,
        reference: None,
        reference_reliable: None,
        error_of_truth: None,
        against_reference: None,
        distance: None,
        interrupted: false,
        measured: vec![measured(setting(None), samples)],
        unmeasured: vec![Unmeasured { setting: setting(Some(("clamp", "10"))), why: "no time".into() }],
        middle_of: None,
        examples: vec![Example {
            setting: "defaults".into(),
            samples: 16,
            seconds: 1.6,
            error: 0.06,
            relmse: 0.03,
            flip: 0.1,
            picture: Vec::new(),
            flip_map: Vec::new(),
        }],
    }
}

/// The lines of the first plot of a page.
fn lines(page: &str) -> usize {
    let (_, rest) = page.split_once("<svg").expect("a plot");
    rest.split("</svg>").next().unwrap_or_default().matches("<polyline").count()
}

#[test]
fn the_answer_and_the_plot_come_first_and_details_are_folded() {
    let page = html(&findings(&[4, 16, 64])).expect("a page");
    let at = |words: &str| page.find(words).unwrap_or_else(|| panic!("{words} in {page}"));
    let order = [
        "&lt;&amp;&gt;.ron: speed and accuracy</h1>",
        "1 of 2 settings measured",
        "To reach a relative MSE of 1e-1 (31.6 %), which is a relMSE of 5.0e-2, use the defaults",
        "<svg",
        "<summary>How to read the plot",
        "<summary>All settings",
        "<summary>The conditions of the measurement",
        "<summary>What the settings give up",
        "What each setting gives in the same time",
    ];
    assert!(order.map(at).is_sorted(), "{page}");
    assert_eq!(page.matches("<details>").count(), 4);
    assert!(!page.contains("<details open"));
    // The table and the long sentences are within a fold.
    let folded: String = page.split("<details>").skip(1).filter_map(|part| part.split("</details>").next()).collect();
    for words in
        ["<table>", "The relative MSE is the mean over pixels", "not measured: no time", "biases are differences"]
    {
        assert_eq!(folded.matches(words).count(), page.matches(words).count(), "{words}");
        assert!(folded.contains(words), "{words}");
    }
}

#[test]
fn an_unreliable_reference_is_a_condition_of_the_measurement() {
    let says = |reference_reliable: Option<bool>| {
        let report = Findings { reference: Some("r.exr".into()), reference_reliable, ..findings(&[4, 16, 64]) };
        assert_eq!(report.json()["reference_reliable"], serde_json::json!(reference_reliable));
        html(&report).expect("a page").contains("the header of the reference calls its error unreliable")
    };
    assert_eq!([Some(false), Some(true), None].map(says), [true, false, false]);
}

#[test]
fn curves_are_dashed_beyond_what_was_measured() {
    // The curve has 1 to 4096 samples.
    let [solid, dashed] =
        [&[1, 64, 4096], &[4, 16, 64]].map(|samples| lines(&html(&findings(samples)).expect("a page")));
    assert!(dashed > solid + 20, "{dashed} lines, {solid} if all was measured");
}

#[test]
fn no_screen_scrolls_sideways() {
    let page = html(&findings(&[4, 16, 64])).expect("a page");
    assert!(page.contains("<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">"));
    let (_, rest) = page.split_once("<style>").expect("a style");
    let style = rest.split("</style>").next().unwrap_or_default();
    // Nothing scrolls by itself, and nothing is wider than a narrow screen: no width in pixels, and none above 19rem without a way out.
    assert!(!style.contains("overflow-x") && !style.contains("position"), "{style}");
    assert!(style.contains("overflow-wrap: anywhere"));
    let fixed = style.split([';', '{', '}']).map(str::trim).filter(|rule| {
        let (name, value) = rule.split_once(": ").unwrap_or_default();
        (name == "width" && value != "100%") || (name == "min-width" && value != "9rem")
    });
    assert_eq!(fixed.collect::<Vec<_>>(), Vec::<&str>::new());
    assert_eq!(style.matches("minmax(").count(), style.matches("minmax(min(").count(), "columns give way");
    // Both plots scale, and one of them is for narrow screens.
    assert_eq!(page.matches("viewBox=").count(), 2);
    assert!(style.contains("figure svg { display: block; width: 100%;"));
    for (class, width) in [("wide", 900), ("narrow", 450)] {
        assert!(page.contains(&format!("<div class=\"{class}\">\n<svg width=\"{width}\"")), "{class}");
    }
    // A row of the table becomes a card, whose cells name their column.
    assert!(style.contains("content: attr(data-heading)"));
    assert_eq!(page.matches("<td data-heading=").count(), 13);
}
