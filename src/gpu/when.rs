//! Conditions over the facts of a kernel: what stands behind `when` and `//@ if`.

use std::collections::BTreeMap;
use std::fmt;

/// The reason why something is linked.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Reason {
    /// Every render needs it.
    EveryRender,
    /// An object of the scene (with its location in the file) or an option needs it.
    Requested(String),
}

impl fmt::Display for Reason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Reason::EveryRender => f.write_str("every render"),
            Reason::Requested(by) => f.write_str(by),
        }
    }
}

impl Reason {
    /// This reason if it is `Requested`, else the other.
    pub(super) fn or(self, other: &Reason) -> Reason {
        if self == Reason::EveryRender { other.clone() } else { self }
    }
}

/// All facts that a kernel may have, by name. One that holds has its reason.
pub type Facts = BTreeMap<String, Option<Reason>>;

/// The reason for a fact that holds.
pub fn reason_of<'a>(facts: &'a Facts, fact: &str) -> Option<&'a Reason> {
    facts.get(fact)?.as_ref()
}

/// A condition: facts with `&`, `|`, `!` and brackets. `&` binds before `|`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum When {
    Fact(String),
    Not(Box<When>),
    All(Vec<When>),
    Any(Vec<When>),
}

impl When {
    /// # Errors
    /// What is wrong with the text.
    pub fn parse(text: &str) -> Result<When, String> {
        let mut rest = text;
        let when = any(&mut rest)?;
        if rest.is_empty() { Ok(when) } else { Err(format!("`{rest}` is left over in the condition `{text}`")) }
    }

    /// Whether it holds, with the reason of its first operand that does. That something is absent has the reason of every render.
    ///
    /// # Errors
    /// Names a fact that there is not.
    pub fn reason(&self, facts: &Facts) -> Result<Option<Reason>, String> {
        let of_each =
            |operands: &[When]| operands.iter().map(|operand| operand.reason(facts)).collect::<Result<Vec<_>, _>>();
        Ok(match self {
            When::Fact(name) => facts.get(name).cloned().ok_or_else(|| format!("the plan has no fact `{name}`"))?,
            When::Not(operand) => operand.reason(facts)?.is_none().then_some(Reason::EveryRender),
            When::All(operands) => {
                let reasons = of_each(operands)?;
                if reasons.iter().all(Option::is_some) { reasons.into_iter().next().flatten() } else { None }
            }
            When::Any(operands) => of_each(operands)?.into_iter().flatten().next(),
        })
    }

    /// The names of its facts, from left to right.
    pub fn facts(&self) -> Vec<&str> {
        match self {
            When::Fact(name) => vec![name],
            When::Not(operand) => operand.facts(),
            When::All(operands) | When::Any(operands) => operands.iter().flat_map(When::facts).collect(),
        }
    }
}

fn any(rest: &mut &str) -> Result<When, String> {
    several(rest, '|', When::Any, |rest| several(rest, '&', When::All, operand))
}

/// Operands with `sign` between them.
fn several(
    rest: &mut &str,
    sign: char,
    joined: fn(Vec<When>) -> When,
    operand: impl Fn(&mut &str) -> Result<When, String>,
) -> Result<When, String> {
    let first = operand(rest)?;
    let mut operands = vec![first];
    while take(rest, sign) {
        operands.push(operand(rest)?);
    }
    Ok(if operands.len() > 1 { joined(operands) } else { operands.remove(0) })
}

fn operand(rest: &mut &str) -> Result<When, String> {
    if take(rest, '!') {
        return Ok(When::Not(Box::new(operand(rest)?)));
    }
    if take(rest, '(') {
        let inner = any(rest)?;
        return if take(rest, ')') { Ok(inner) } else { Err("a `(` has no `)`".to_string()) };
    }
    let end = rest.find(|c: char| !c.is_alphanumeric() && c != '_' && c != '.').unwrap_or(rest.len());
    let (name, after) = rest.split_at(end);
    *rest = after.trim_start();
    if name.is_empty() { Err(format!("a fact is missing before `{rest}`")) } else { Ok(When::Fact(name.to_string())) }
}

fn take(rest: &mut &str, sign: char) -> bool {
    let after = rest.trim_start().strip_prefix(sign);
    after.inspect(|after| *rest = after.trim_start()).is_some()
}
