//! The table of extremes: what a cell is, which cells there must be, the file that has all of them, and the page with the worst of each row.

use std::collections::BTreeSet;
use std::fmt::Write as _;

use crate::ROWS;
use crate::common::kernel::Plant;
use crate::common::trace::WITHOUT_OFFSET;

pub const TEXTBOOK_SPHERE: &str = "textbook's sphere";
pub const FIXED_T_MIN: &str = "fixed t_min";
pub const OFFSET_BY_BITS: &str = "offset of 256 ulps";
/// Not among the forms that must be planted, because it is not used.
pub const NO_OFFSET: &str = "no offset";
pub const SCHLICK: &str = "Schlick's reflectance";
pub const RUNNING_SUM: &str = "running sum in f32";
pub const MEAN_OF_SQUARES: &str = "variance as E[x²] - E[x]²";
pub const FRISVAD: &str = "Frisvad's basis";
pub const ONE_MINUS_COS: &str = "cone by 1 - cos";
pub const LOG_OF_ONE_MINUS: &str = "free flight by log(1 - u)";
pub const COMPARED_NAN: &str = "NaN test by x != x";

/// Rays that start at a fixed distance, as where every ray starts at t = 0.001.
pub const FIXED_OFFSET: [Plant; 2] = [WITHOUT_OFFSET, ("geometry/offset", "error * outward", "0.001 * direction")];
/// 256 ulps along the normal (Wächter and Binder, "A Fast and Robust Method for Avoiding Self-Intersection", Ray Tracing Gems, ch. 6), which does
/// not know how small the primitive is.
pub const BY_BITS: Plant = (
    "geometry/offset",
    "let moved = point + error * outward;",
    "let steps = vec3<i32>(256.0 * outward);
    let far = bitcast<vec3<f32>>(bitcast<vec3<i32>>(point) + select(steps, -steps, point < vec3<f32>(0.0)));
    let moved = select(far, point + outward / 65536.0, abs(point) < vec3<f32>(1.0 / 32.0));",
);

/// The worst forms known. Each must be planted in a cell and found there.
pub const FORMS: &[&str] = &[
    TEXTBOOK_SPHERE,
    FIXED_T_MIN,
    OFFSET_BY_BITS,
    SCHLICK,
    RUNNING_SUM,
    MEAN_OF_SQUARES,
    FRISVAD,
    ONE_MINUS_COS,
    LOG_OF_ONE_MINUS,
    COMPARED_NAN,
];

/// One range of one row: what was measured there, and what it must not be above.
pub struct Cell {
    /// What is driven to its extremes.
    pub row: &'static str,
    /// The inputs: `"D/r = 1e3"`.
    pub range: String,
    /// What is measured, with its unit.
    pub figure: &'static str,
    /// What the figure may be at most.
    pub limit: f64,
    /// Where the limit comes from, in a sentence.
    pub because: &'static str,
    /// What was measured.
    pub achieved: f64,
    /// What `check` says of the objects of such a scene, where f32 cannot hold it: the figure may then be over its limit.
    pub warnings: Vec<String>,
    /// What a known wrong form would have achieved instead, by name. Each must be above the limit.
    pub planted: Vec<(&'static str, f64)>,
}

impl Cell {
    pub fn new(range: impl Into<String>, figure: &'static str, limit: f64, because: &'static str) -> Cell {
        Cell {
            row: "",
            range: range.into(),
            figure,
            limit,
            because,
            achieved: f64::NAN,
            warnings: Vec::new(),
            planted: Vec::new(),
        }
    }

    pub fn achieved(self, achieved: f64) -> Cell {
        Cell { achieved, ..self }
    }

    pub fn warns(self, warnings: Vec<String>) -> Cell {
        Cell { warnings, ..self }
    }

    /// Adds a wrong form with its figure.
    pub fn planted(mut self, form: &'static str, figure: f64) -> Cell {
        self.planted.push((form, figure));
        self
    }

    /// What was measured, and whether a scene is warned of that needs to be.
    fn outcome(&self) -> String {
        let over = self.achieved > self.limit;
        format!("{}{}", short(self.achieved), if over { ", `check` warns" } else { "" })
    }

    /// What is wrong with the cell. A figure that is no number holds nothing.
    fn faults(&self) -> Vec<String> {
        let cell = format!("{}, {}: {}", self.row, self.range, self.figure);
        let mut all = Vec::new();
        let holds = |figure: f64| figure <= self.limit;
        if self.achieved.is_nan() || !holds(self.achieved) && self.warnings.is_empty() {
            all.push(format!("{cell}: {:e} is over the limit of {:e}", self.achieved, self.limit));
        }
        for (form, figure) in &self.planted {
            // What is no number is not found either: nothing was measured.
            if figure.is_nan() || holds(*figure) {
                all.push(format!("{cell}: the {form} is not found: {figure:e} is not above {:e}", self.limit));
            }
        }
        all
    }
}

/// A decade from 1e-1 down as a range, and its ends as powers of ten.
pub fn decade(exponent: i32) -> (String, (f64, f64)) {
    let end = -f64::from(exponent);
    (format!("1e-{} to 1e-{exponent}", exponent + 1), (end - 1.0, end))
}

/// The file with all cells, one a line, and the page.
pub const FILE: &str = "docs/dev/extremes.tsv";
pub const PAGE: &str = "docs/dev/extremes.md";
const HEAD: &str = "row\tfigure\trange\tlimit\tachieved\twrong forms, planted\twhere the limit comes from\n";

/// The cells of a file: row, figure and range each.
fn cells_of(file: &str) -> Vec<(&str, &str, &str)> {
    let cells = file.lines().skip(1).map(|line| {
        let mut columns = line.split('\t');
        let mut next = || columns.next().unwrap_or_default();
        (next(), next(), next())
    });
    cells.collect()
}

/// Everything that is wrong with the cells, by their file and the one that is wanted: over a limit, other cells, or a form
/// that none has. Empty where all is well.
pub fn faults(cells: &[Cell], text: &str, wanted_text: &str, forms: &[&str]) -> Vec<String> {
    let mut all: Vec<String> = cells.iter().flat_map(Cell::faults).collect();
    let (there, wanted) = (cells_of(text), cells_of(wanted_text));
    let missing = |of: &[(&str, &str, &str)], from: &[(&str, &str, &str)], fault: &str| -> Vec<String> {
        let from: BTreeSet<_> = from.iter().collect();
        let without = of.iter().filter(|cell| !from.contains(cell));
        without.map(|(row, figure, range)| format!("{row}, {range}: {figure}: {fault}")).collect()
    };
    all.extend(missing(&wanted, &there, &format!("in {FILE}, and there is no such cell")));
    all.extend(missing(&there, &wanted, &format!("the cell is not in {FILE}, which `GPU_RT_RENEW=1` writes anew")));
    if BTreeSet::from_iter(&there).len() < there.len() {
        all.push("two cells are the same".to_string());
    }
    for (row, _) in ROWS {
        if !wanted.iter().any(|cell| cell.0 == *row) {
            all.push(format!("{row}: there is no cell"));
        }
    }
    for form in forms {
        if !cells.iter().any(|cell| cell.planted.iter().any(|(name, _)| name == form)) {
            all.push(format!("the {form} is planted nowhere"));
        }
    }
    all
}

/// The cells of a row, those that measure the same together.
fn of_row<'a>(cells: &'a [Cell], row: &str) -> Vec<&'a Cell> {
    let own: Vec<&Cell> = cells.iter().filter(|cell| cell.row == row).collect();
    let mut figures: Vec<&str> = Vec::new();
    for cell in &own {
        if !figures.contains(&cell.figure) {
            figures.push(cell.figure);
        }
    }
    figures.iter().flat_map(|figure| own.iter().filter(move |cell| cell.figure == *figure).copied()).collect()
}

/// All cells, one a line, with tabs between the columns.
pub fn file(cells: &[Cell]) -> String {
    let mut text = HEAD.to_string();
    for (row, _) in ROWS {
        for cell in of_row(cells, row) {
            let planted: Vec<String> =
                cell.planted.iter().map(|(form, figure)| format!("{form}: {}", short(*figure))).collect();
            let columns =
                [row, cell.figure, &cell.range, &short(cell.limit), &cell.outcome(), &planted.join("; "), cell.because];
            let _ = writeln!(text, "{}", columns.join("\t"));
        }
    }
    text
}

/// The page: of each row the cell that comes nearest to its limit.
pub fn page(cells: &[Cell], driver: &str) -> String {
    let mut text = format!(
        "# Extremes\n\n\
         The accuracy of the numbers at the ends of their ranges, measured on {driver}. Each row has the cell that comes nearest to its limit;\n\
         [extremes.tsv](extremes.tsv) has all {} cells, with what each limit comes from (u = 2^-24 is the relative error of one operation in\n\
         f32), and what a known wrong form would have reached. Where f32 does not resolve a scene, a warning of `gpu-rt check` is enough. The page leaves these {} cells out.\n\n\
         `GPU_RT_RENEW=1 cargo test --release --test extremes` writes both files; do not edit them. Without the variable, the test fails if\n\
         a figure is over its limit, if the cells differ from those of the file, or if a known wrong form is not detected.\n\n\
         | quantity | cells | the nearest to its limit | limit | achieved |\n|---|--:|---|--:|--:|\n",
        cells.len(),
        cells.iter().filter(|cell| cell.achieved > cell.limit).count(),
    );
    for (row, _) in ROWS {
        let own = of_row(cells, row);
        let share = |cell: &Cell| if cell.limit > 0.0 { cell.achieved / cell.limit } else { 0.0 };
        let within = own.iter().filter(|cell| cell.achieved <= cell.limit);
        // The first of those that are equally near.
        let Some(worst) = within.reduce(|a, b| if share(b) > share(a) { b } else { a }) else { continue };
        let _ = writeln!(
            text,
            "| {row} | {} | {}; {} | {} | {} |",
            own.len(),
            worst.figure,
            worst.range,
            short(worst.limit),
            short(worst.achieved)
        );
    }
    text
}

/// Two digits.
fn short(value: f64) -> String {
    match value {
        0.0 => "0".to_string(),
        v if (0.01..1e4).contains(&v.abs()) && v.fract() == 0.0 => format!("{v}"),
        v => format!("{v:.1e}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const GAPS: &str = "gaps between surfaces";

    fn cell(row: &'static str, range: &str, limit: f64, achieved: f64) -> Cell {
        Cell { row, achieved, ..Cell::new(range, "error", limit, "") }
    }

    fn full() -> Vec<Cell> {
        ROWS.iter().map(|(row, _)| cell(row, "all", 1.0, 0.5)).collect()
    }

    fn compared(cells: &[Cell], wanted: &[Cell], forms: &[&str]) -> Vec<String> {
        faults(cells, &file(cells), &file(wanted), forms)
    }

    /// The faults of cells that are all declared.
    fn own_faults(cells: &[Cell], forms: &[&str]) -> Vec<String> {
        compared(cells, cells, forms)
    }

    #[test]
    fn a_table_that_is_full_and_within_its_limits_has_no_faults() {
        assert_eq!(own_faults(&full(), &[]), Vec::<String>::new());
    }

    #[test]
    fn a_cell_over_its_limit_is_a_fault() {
        let over = |achieved| {
            let mut cells = full();
            cells[3].achieved = achieved;
            own_faults(&cells, &[]).len()
        };
        assert_eq!((over(1.1), over(f64::NAN), over(f64::INFINITY)), (1, 1, 1));
    }

    #[test]
    fn a_cell_that_check_warns_of_may_exceed_its_limit_and_must_be_a_number() {
        let faults_of = |achieved, warnings: &[&str]| {
            let mut cells = full();
            cells[3].achieved = achieved;
            cells[3].warnings = warnings.iter().map(|warning| warning.to_string()).collect();
            own_faults(&cells, &[]).len()
        };
        assert_eq!((faults_of(1.1, &["too near"]), faults_of(f64::INFINITY, &["too near"])), (0, 0));
        assert_eq!((faults_of(1.1, &[]), faults_of(f64::NAN, &["too near"])), (1, 1));
    }

    #[test]
    fn a_wrong_form_that_is_not_found_is_a_fault() {
        let planted = |figure| {
            let mut cells = full();
            let first = cells.remove(0).planted("textbook", figure);
            cells.insert(0, first);
            own_faults(&cells, &["textbook"]).len()
        };
        assert_eq!((planted(0.9), planted(f64::NAN)), (1, 1));
        assert_eq!((planted(1.1), planted(f64::INFINITY)), (0, 0));
        assert_eq!(own_faults(&full(), &["textbook"]).len(), 1, "a wrong form that nobody planted");
    }

    #[test]
    fn the_page_has_the_cell_of_each_row_that_is_nearest_to_its_limit() {
        let mut cells = full();
        cells.push(cell(GAPS, "the worst", 2.0, 1.9));
        cells.push(cell(GAPS, "unresolved", 2.0, 3.0).warns(vec!["too near".to_string()]));
        let page = page(&cells, "a driver");
        assert!(page.contains("| gaps between surfaces | 3 | error; the worst | 2 | 1.9e0 |"), "{page}");
        assert_eq!(page.lines().filter(|line| line.starts_with("| ")).count(), ROWS.len() + 1);
    }

    #[test]
    fn cells_that_are_missing_or_not_declared_are_faults() {
        let of_range = |range: &str| cell(GAPS, range, 1.0, 0.5);
        let with =
            |more: &[&str]| full().into_iter().chain(more.iter().map(|range| of_range(range))).collect::<Vec<_>>();
        let wanted = with(&["1e-1", "1e-7"]);
        assert_eq!(compared(&with(&["1e-1", "1e-7"]), &wanted, &[]), Vec::<String>::new());
        // The row still has cells.
        assert_eq!(compared(&with(&["1e-1"]), &wanted, &[]).len(), 1, "one of a row is missing");
        assert_eq!(compared(&with(&["1e-1", "1e-7", "1e-8"]), &wanted, &[]).len(), 1, "one that is not declared");
        assert_eq!(compared(&with(&["1e-1", "1e-7", "1e-7"]), &wanted, &[]).len(), 1, "one that is there twice");
        // Another figure of the same range is another cell.
        let mut other = with(&["1e-1", "1e-7"]);
        other.last_mut().expect("there are some").figure = "share";
        assert_eq!(compared(&other, &wanted, &[]).len(), 2);
        let empty: Vec<Cell> = full().into_iter().filter(|cell| cell.row != GAPS).collect();
        assert_eq!(own_faults(&empty, &[]).len(), 1, "a row without a cell");
    }
}
