//! The position of every value in a RON text.
//!
//! ron and serde drop positions, so the text is scanned a second time into a tree of byte ranges. The
//! scanner knows brackets, keys, strings and comments, and nothing about the scene. It keeps unknown
//! text as a word; ron reports the error. It has its own stack, so that deep nesting cannot overflow
//! the program's.

/// One step on the way from the top of the scene file to a value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Step<'a> {
    /// A field of a struct: `radius`.
    Field(&'a str),
    /// An element of a list, or a component of a vector, from 0.
    Index(usize),
    /// The value under a key of a map: a material by its name.
    Key(&'a str),
    /// Into an enum's variant: `Sphere`.
    Variant(&'a str),
}

/// The number of a value in the tree.
pub type Id = u32;

/// The most values in a text. Two characters can be a value, which takes 44 bytes here, and more where it becomes an object. Two
/// million spheres are 14 million values.
pub const MOST_VALUES: usize = 1 << 24;

/// A range of bytes. 32 bits are enough: `load` refuses longer files.
#[derive(Clone, Copy, Debug, Default)]
pub struct Span {
    pub start: u32,
    pub end: u32,
}

impl Span {
    pub fn is_empty(self) -> bool {
        self.start == self.end
    }
}

#[derive(Clone, Copy, Debug, Default)]
struct Node {
    /// The value itself, without its key.
    value: Span,
    /// The name before the bracket, as in `Sphere(...)`; empty where there is none.
    name: Span,
    /// The key or field name before the colon; empty for an element of a list or tuple.
    key: Span,
    parent: Option<Id>,
    /// This node's elements are `children[first..first + count]`.
    first: u32,
    count: u32,
}

/// Two brackets that do not belong together.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Mismatch {
    /// The byte of the bracket that is open; `None` if there is none.
    pub opened: Option<u32>,
    /// The byte of the one that would close it.
    pub closed: u32,
}

/// The tree of values.
#[derive(Clone, Debug, Default)]
pub struct Spans {
    nodes: Vec<Node>,
    children: Vec<Id>,
    /// The value of the complete text; `None` if there are only spaces and comments.
    pub root: Option<Id>,
    /// The innermost bracket that the text never closes.
    pub unclosed_bracket: Option<u32>,
    /// The first bracket that is closed by one of another kind, or that closes none.
    pub mismatch: Option<Mismatch>,
    /// The block comment that the text never closes.
    pub unclosed_comment: Option<u32>,
    /// The first value beyond `MOST_VALUES`. The tree ends there.
    pub one_too_many: Option<u32>,
}

/// Names of structs. RON allows them before the bracket, and they are not steps of a path.
const STRUCT_NAMES: [&str; 6] = ["Scene", "ImageSize", "Camera", "RenderDefaults", "DVec3", "Some"];

impl Spans {
    /// Scans a text. It never fails: a text that is not valid RON gives some tree, too.
    pub fn scan(text: &str) -> Spans {
        let mut scanner = Scanner {
            text,
            spans: Spans::default(),
            open: Vec::new(),
            pending: Vec::new(),
            key: Span::default(),
            at: 0,
        };
        scanner.run();
        scanner.spans
    }

    /// The value at the end of the path. If the text lacks it, the innermost value on the path.
    pub fn find(&self, text: &str, steps: &[Step<'_>]) -> Option<Id> {
        self.follow(text, steps).map(|(id, _)| id)
    }

    /// The value at the end of these steps, or the innermost one on the way there and the steps that the text lacks.
    pub fn follow<'s>(&self, text: &str, mut steps: &'s [Step<'s>]) -> Option<(Id, &'s [Step<'s>])> {
        let mut id = self.root?;
        while let [step, rest @ ..] = steps {
            let next = match *step {
                Step::Field(name) => self.child_where(id, |key| field_name(slice(text, key)) == name),
                Step::Key(name) => self.child_where(id, |key| is_key(slice(text, key), name)),
                Step::Index(index) => self.children(id).get(index).copied(),
                Step::Variant(name) => (self.name(text, id) == name).then(|| self.inside(id)),
            };
            let Some(next) = next else { break };
            (id, steps) = (next, rest);
        }
        Some((id, steps))
    }

    /// The innermost value whose text or key contains the byte at `offset`.
    pub fn at(&self, offset: u32) -> Option<Id> {
        let mut id = self.root?;
        loop {
            let children = self.children(id);
            let after = children.partition_point(|&child| self.entry_start(child) <= offset);
            let Some(&child) = after.checked_sub(1).and_then(|before| children.get(before)) else {
                return Some(id);
            };
            if self.value(child).end <= offset {
                return Some(id);
            }
            id = child;
        }
    }

    /// The path to a value. `into_variant` adds the value's own name, as for a field inside it.
    pub fn path<'t>(&self, text: &'t str, id: Id, into_variant: bool) -> Vec<Step<'t>> {
        let mut steps = Vec::new();
        let mut id = Some(id);
        let mut inside = into_variant;
        while let Some(current) = id {
            let name = self.name(text, current);
            if inside && !name.is_empty() && !STRUCT_NAMES.contains(&name) {
                steps.push(Step::Variant(name));
            }
            let parent = self.parent(current);
            let key = self.key(current);
            if !key.is_empty() {
                steps.push(key_step(slice(text, key)));
            } else if let Some(parent) = parent
                && self.inside(parent) != current
            {
                let before = self.children(parent).iter().position(|&child| child == current);
                steps.extend(before.map(Step::Index));
            }
            id = parent;
            inside = true;
        }
        steps.reverse();
        steps
    }

    pub fn value(&self, id: Id) -> Span {
        self.node(id).value
    }

    pub fn key(&self, id: Id) -> Span {
        self.node(id).key
    }

    pub fn parent(&self, id: Id) -> Option<Id> {
        self.node(id).parent
    }

    /// The start of the value's key, or of the value if it has no key.
    pub fn entry_start(&self, id: Id) -> u32 {
        let key = self.key(id);
        if key.is_empty() { self.value(id).start } else { key.start }
    }

    pub fn children(&self, id: Id) -> &[Id] {
        let Node { first, count, .. } = self.node(id);
        self.children.get(first as usize..(first + count) as usize).unwrap_or(&[])
    }

    /// The name before the value's bracket, or "".
    pub fn name<'t>(&self, text: &'t str, id: Id) -> &'t str {
        field_name(slice(text, self.node(id).name))
    }

    /// The end of the name before the value's bracket; the value's start if there is no name.
    pub fn name_end(&self, id: Id) -> u32 {
        let node = self.node(id);
        node.name.end.max(node.value.start)
    }

    /// The content of a variant: the number in `Scale(2)`; the value itself in `Sphere(radius: 2)` and `Rgb(1, 1, 1)`.
    fn inside(&self, id: Id) -> Id {
        match self.children(id) {
            &[only] if !self.node(id).name.is_empty() && self.key(only).is_empty() => only,
            _ => id,
        }
    }

    fn child_where(&self, id: Id, matches: impl Fn(Span) -> bool) -> Option<Id> {
        self.children(id).iter().copied().find(|&child| matches(self.key(child)))
    }

    /// A value of this tree; nothing for any other number.
    fn node(&self, id: Id) -> Node {
        self.nodes.get(id as usize).copied().unwrap_or_default()
    }
}

/// The text of a span.
pub fn slice(text: &str, span: Span) -> &str {
    text.get(span.start as usize..span.end as usize).unwrap_or("")
}

/// A field's name without the `r#` that RON allows before it.
fn field_name(text: &str) -> &str {
    text.strip_prefix("r#").unwrap_or(text)
}

/// Whether a map's key, as written, is the string `name`.
fn is_key(text: &str, name: &str) -> bool {
    match text.strip_prefix('"').and_then(|rest| rest.strip_suffix('"')) {
        Some(plain) if !plain.contains('\\') => plain == name,
        // Escapes and raw strings are rare: ron itself decodes them.
        _ => ron::from_str::<String>(text).is_ok_and(|key| key == name),
    }
}

fn key_step(text: &str) -> Step<'_> {
    match text.find('"') {
        Some(quote) => Step::Key(text.get(quote..).unwrap_or("").trim_matches(['"', '#'])),
        None => Step::Field(field_name(text)),
    }
}

/// The characters that ron skips between tokens.
fn is_space(c: char) -> bool {
    matches!(c, ' ' | '\t'..='\r' | '\u{85}' | '\u{200E}' | '\u{200F}' | '\u{2028}' | '\u{2029}')
}

/// The offset of the first byte at or after `from` that is neither space nor comment. The error is the
/// start of a block comment that is never closed.
pub fn skip_space(text: &str, from: usize) -> Result<usize, usize> {
    let mut at = from;
    loop {
        let rest = text.get(at..).unwrap_or("");
        let trimmed = rest.trim_start_matches(is_space);
        at += rest.len() - trimmed.len();
        if trimmed.starts_with("//") {
            at += trimmed.find('\n').unwrap_or(trimmed.len());
        } else if trimmed.starts_with("/*") {
            at += block_comment(trimmed).ok_or(at)?;
        } else {
            return Ok(at);
        }
    }
}

/// The length of the block comment at the start of a text. Block comments nest.
fn block_comment(text: &str) -> Option<usize> {
    let mut depth = 0usize;
    let mut at = 0;
    while let Some(found) = text.get(at..)?.find(['/', '*']) {
        at += found;
        let rest = text.get(at..)?;
        if rest.starts_with("/*") {
            depth += 1;
            at += 2;
        } else if rest.starts_with("*/") {
            depth = depth.saturating_sub(1);
            at += 2;
            if depth == 0 {
                return Some(at);
            }
        } else {
            at += 1;
        }
    }
    None
}

/// A bracket that is open.
struct Open {
    node: Id,
    bracket: usize,
    /// The index in `pending` of this bracket's first element.
    first_pending: usize,
}

struct Scanner<'t> {
    text: &'t str,
    spans: Spans,
    open: Vec<Open>,
    /// The elements so far of all open brackets. Those of the innermost bracket are last.
    pending: Vec<Id>,
    /// The key before the colon that was just read; empty otherwise.
    key: Span,
    at: usize,
}

impl<'t> Scanner<'t> {
    fn run(&mut self) {
        while self.skip_space() {
            if self.spans.nodes.len() >= MOST_VALUES {
                self.spans.one_too_many = Some(self.at as u32);
                break;
            }
            match self.next() {
                Some(',') => {
                    self.value_is_missing();
                    self.at += 1;
                }
                Some(':') => self.take_key(),
                Some(')' | ']' | '}') => self.close(),
                Some('#') if self.open.is_empty() => self.skip_attribute(),
                Some(_) => self.value(),
                None => break,
            }
        }
        self.value_is_missing();
        self.spans.unclosed_bracket = self.open.last().map(|open| open.bracket as u32);
        while let Some(open) = self.open.pop() {
            self.finish(open);
        }
        self.spans.root = self.pending.first().copied();
    }

    fn rest(&self) -> &'t str {
        self.text.get(self.at..).unwrap_or("")
    }

    fn next(&self) -> Option<char> {
        self.rest().chars().next()
    }

    /// Moves to the next token; false at the end of the text.
    fn skip_space(&mut self) -> bool {
        match skip_space(self.text, self.at) {
            Ok(at) => self.at = at,
            Err(comment) => {
                self.spans.unclosed_comment = Some(comment as u32);
                self.at = self.text.len();
            }
        }
        self.at < self.text.len()
    }

    /// Skips one `#![enable(...)]` before the scene. ron checks it.
    fn skip_attribute(&mut self) {
        let rest = self.rest();
        self.at += rest.find(']').map_or(rest.len(), |end| end + 1);
    }

    /// A string, a word, or a bracket with or without a name before it.
    fn value(&mut self) {
        let start = self.at;
        if self.is_at_bracket() {
            self.open_bracket(start, start);
            return;
        }
        let string = string_length(self.rest());
        let is_name = self.next().is_some_and(|c| c == '_' || c.is_alphabetic());
        self.at += string.unwrap_or_else(|| word_length(self.rest()));
        let end = self.at;
        if string.is_none() && is_name && self.skip_space() && self.is_at_bracket() {
            self.open_bracket(start, end);
        } else {
            self.add(start, end);
        }
    }

    fn is_at_bracket(&self) -> bool {
        self.rest().starts_with(['(', '[', '{'])
    }

    /// Opens the bracket here; its name, if any, is the given range.
    fn open_bracket(&mut self, start: usize, end: usize) {
        let id = self.add(start, end);
        if let Some(node) = self.spans.nodes.get_mut(id as usize) {
            node.name = span(start, end);
        }
        self.open.push(Open { node: id, bracket: self.at, first_pending: self.pending.len() });
        self.at += 1;
    }

    /// Adds a value to the innermost open bracket, under the key that was just read, if any.
    fn add(&mut self, start: usize, end: usize) -> Id {
        let id = self.spans.nodes.len() as Id;
        self.spans.nodes.push(Node {
            value: span(start, end),
            name: Span::default(),
            key: std::mem::take(&mut self.key),
            parent: self.open.last().map(|open| open.node),
            first: 0,
            count: 0,
        });
        self.pending.push(id);
        id
    }

    /// Handles a colon: the last value is the key of the next one.
    fn take_key(&mut self) {
        self.at += 1;
        let first_pending = self.open.last().map_or(0, |open| open.first_pending);
        if self.pending.len() == first_pending {
            return;
        }
        let Some(&id) = self.pending.last() else {
            return;
        };
        if self.spans.key(id).is_empty() {
            self.key = self.spans.value(id);
            self.pending.pop();
            // A word or a string has no elements, and nothing refers to it.
            if id as usize + 1 == self.spans.nodes.len() {
                self.spans.nodes.pop();
            }
        }
    }

    /// Handles a key without a value: the text where the value should be becomes the value.
    fn value_is_missing(&mut self) {
        if !self.key.is_empty() {
            self.add(self.at, (self.at + 1).min(self.text.len()));
        }
    }

    /// Closes the innermost bracket, of any kind. If the kinds differ, ron reports an error here anyway.
    fn close(&mut self) {
        self.value_is_missing();
        let opened = self.open.last().map(|open| open.bracket);
        let fits = matches!(
            (opened.and_then(|at| self.text.as_bytes().get(at)), self.next()),
            (Some(b'('), Some(')')) | (Some(b'['), Some(']')) | (Some(b'{'), Some('}'))
        );
        if !fits && self.spans.mismatch.is_none() {
            self.spans.mismatch = Some(Mismatch { opened: opened.map(|at| at as u32), closed: self.at as u32 });
        }
        self.at += 1;
        if let Some(open) = self.open.pop() {
            self.finish(open);
        }
    }

    fn finish(&mut self, open: Open) {
        let first = self.spans.children.len();
        self.spans.children.extend(self.pending.drain(open.first_pending..));
        if let Some(node) = self.spans.nodes.get_mut(open.node as usize) {
            node.value.end = self.at as u32;
            node.first = first as u32;
            node.count = (self.spans.children.len() - first) as u32;
        }
    }
}

fn span(start: usize, end: usize) -> Span {
    Span { start: start as u32, end: end as u32 }
}

/// The length of the string, raw string or byte string at the start of the text. An unclosed one reaches
/// to the text's end. RON's characters ('x') are not handled: no field of a scene is one, so that ron
/// reports an error there.
fn string_length(text: &str) -> Option<usize> {
    let unprefixed = text.strip_prefix('b').unwrap_or(text);
    let prefix = text.len() - unprefixed.len();
    if let Some(raw) = unprefixed.strip_prefix('r') {
        let hashes = raw.len() - raw.trim_start_matches('#').len();
        let content = raw.get(hashes..)?.strip_prefix('"')?;
        let ending = format!("\"{}", "#".repeat(hashes));
        return Some(match content.find(&ending) {
            Some(end) => prefix + 1 + hashes + 1 + end + ending.len(),
            None => text.len(),
        });
    }
    let content = unprefixed.strip_prefix('"')?;
    let mut bytes = content.bytes().enumerate();
    while let Some((at, byte)) = bytes.next() {
        match byte {
            b'"' => return Some(prefix + 1 + at + 1),
            b'\\' => drop(bytes.next()),
            _ => {}
        }
    }
    Some(text.len())
}

/// The length of the number, identifier or unknown word at the start of the text: at least one character.
fn word_length(text: &str) -> usize {
    let ends = |&(at, c): &(usize, char)| {
        let rest = text.get(at..).unwrap_or("");
        at > 0 && (is_space(c) || "()[]{},:\"".contains(c) || rest.starts_with("//") || rest.starts_with("/*"))
    };
    text.char_indices().find(ends).map_or(text.len(), |(at, _)| at)
}
