//! The modules under shaders/, and what their heads say.
//!
//! A head is the first lines of a module: `//@ implements film when FACTS` says that the module stands behind `choice/film` where these facts
//! hold ([`When`]). What follows `//@ without` in the file stands there where no module's facts hold. `//@ alternative …` says the same of one of
//! several ways to do a thing, which `plan` lists. A module may implement several choices.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::sync::LazyLock;

use super::vocabulary::Vocabulary;
use super::when::{Facts, Reason, When};

/// A source of module texts. In tests it has additional modules.
pub trait Library {
    fn module(&self, name: &str) -> Option<&str>;

    /// The heads of its modules.
    fn heads(&self) -> &Heads {
        &HEADS
    }

    /// The names that its modules may have without a `//@ use`.
    fn vocabulary(&self) -> &Vocabulary {
        &VOCABULARY
    }
}

/// The modules under shaders/. They are compiled into the program. With debug assertions they are read from disk, so
/// that an edit of a shader needs no recompilation.
pub struct Embedded;

#[cfg(not(debug_assertions))]
static TEXTS: LazyLock<BTreeMap<String, Cow<'static, str>>> = LazyLock::new(|| {
    use include_dir::{Dir, include_dir};
    static SHADERS: Dir<'static> = include_dir!("$CARGO_MANIFEST_DIR/shaders");
    fn walk(dir: &'static Dir<'static>, texts: &mut BTreeMap<String, Cow<'static, str>>) {
        texts.extend(dir.files().filter_map(|file| {
            let name = file.path().to_str()?.strip_suffix(".wgsl")?;
            Some((name.replace('\\', "/"), file.contents_utf8()?.into()))
        }));
        dir.dirs().for_each(|dir| walk(dir, texts));
    }
    let mut texts = BTreeMap::new();
    walk(&SHADERS, &mut texts);
    texts
});

#[cfg(debug_assertions)]
static TEXTS: LazyLock<BTreeMap<String, Cow<'static, str>>> = LazyLock::new(|| {
    use std::path::Path;
    fn walk(root: &Path, dir: &Path, texts: &mut BTreeMap<String, Cow<'static, str>>) {
        for path in std::fs::read_dir(dir).into_iter().flatten().flatten().map(|entry| entry.path()) {
            if path.is_dir() {
                walk(root, &path, texts);
            } else if let Some(name) = path.strip_prefix(root).ok().and_then(|p| p.to_str()?.strip_suffix(".wgsl"))
                && let Ok(text) = std::fs::read_to_string(&path)
            {
                texts.insert(name.replace('\\', "/"), text.into());
            }
        }
    }
    let root = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/shaders"));
    let mut texts = BTreeMap::new();
    walk(root, root, &mut texts);
    texts
});

impl Library for Embedded {
    fn module(&self, name: &str) -> Option<&str> {
        TEXTS.get(name).map(|text| &**text)
    }
}

impl Embedded {
    /// The names of all modules, sorted.
    pub fn names() -> Vec<String> {
        TEXTS.keys().cloned().collect()
    }
}

static HEADS: LazyLock<Heads> = LazyLock::new(|| Heads::of(TEXTS.iter().map(|(name, text)| (name.as_str(), &**text))));

static VOCABULARY: LazyLock<Vocabulary> = LazyLock::new(|| {
    let is_in = |name: &str| name.starts_with("data/") || name.starts_with("lib/");
    let stands_alone = |text: &str| text.lines().next().is_none_or(|line| head_of(line).is_none());
    let own = TEXTS.iter().map(|(name, text)| (name.as_str(), &**text));
    Vocabulary::of(own.filter(|(name, text)| is_in(name) && stands_alone(text)))
});

/// What begins the part of a module that stands where none of its choices' facts hold.
pub(super) const WITHOUT: &str = "//@ without";

/// A module behind a choice.
#[derive(Clone, Debug)]
pub struct Head {
    pub module: String,
    /// When it is chosen, or what is wrong with that line.
    pub when: Result<When, String>,
}

/// The modules behind a choice.
#[derive(Clone, Debug, Default)]
pub struct Implementations {
    pub heads: Vec<Head>,
    /// The modules that have a part for where no facts hold. There must be one at most.
    pub without: Vec<String>,
    /// Whether `plan` lists the choice.
    pub is_alternative: bool,
}

/// The choices, by the modules' heads.
#[derive(Clone, Debug, Default)]
pub struct Heads(BTreeMap<String, Implementations>);

/// What stands behind a choice.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Chosen {
    pub module: String,
    /// Whether it is the part of the module that stands where no facts hold.
    pub is_without: bool,
    pub why: Reason,
}

impl Heads {
    /// Of modules by their names and texts.
    pub fn of<'a>(modules: impl IntoIterator<Item = (&'a str, &'a str)>) -> Heads {
        let mut choices = BTreeMap::<String, Implementations>::new();
        for (module, text) in modules {
            let has_other_part = text.lines().any(|line| line == WITHOUT);
            for (line, is_alternative) in text.lines().map_while(head_of) {
                let (choice, when) = line.split_once(" when ").unwrap_or((line, ""));
                let own = choices.entry(choice.to_string()).or_default();
                own.is_alternative |= is_alternative;
                own.heads.push(Head { module: module.to_string(), when: When::parse(when) });
                own.without.extend(has_other_part.then(|| module.to_string()));
            }
        }
        Heads(choices)
    }

    /// All choices by name.
    pub fn choices(&self) -> &BTreeMap<String, Implementations> {
        &self.0
    }

    /// What stands behind a choice.
    ///
    /// # Errors
    /// Says what is wrong with the heads of its modules.
    pub fn choose(&self, choice: &str, facts: &Facts) -> Result<Chosen, String> {
        let own = self.0.get(choice).ok_or_else(|| format!("no module implements `{choice}`"))?;
        let mut holding = Vec::new();
        for Head { module, when } in &own.heads {
            let why = when.as_ref().map_err(String::clone).and_then(|when| when.reason(facts));
            let why = why.map_err(|error| format!("{error}, in the head of {module}"))?;
            holding.extend(why.map(|why| Chosen { module: module.clone(), is_without: false, why }));
        }
        match (&holding[..], &own.without[..]) {
            ([chosen], _) => Ok(chosen.clone()),
            ([], [module]) => Ok(Chosen { module: module.clone(), is_without: true, why: Reason::EveryRender }),
            ([], []) => Err(format!("no module that implements `{choice}` is there when these facts hold")),
            ([], [a, b, ..]) => Err(format!("{a} and {b} say what stands in the place of `{choice}`")),
            ([a, b, ..], _) => Err(format!("{} and {} both implement `{choice}`", a.module, b.module)),
        }
    }
}

/// The rest of a line of a head, and whether it is that of an alternative.
pub(super) fn head_of(line: &str) -> Option<(&str, bool)> {
    let implements = line.strip_prefix("//@ implements ").map(|rest| (rest, false));
    implements.or_else(|| Some((line.strip_prefix("//@ alternative ")?, true)))
}
