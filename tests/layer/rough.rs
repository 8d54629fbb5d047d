//! Modules of SPIR-V with quotients and roots as inexact as GPUs make them.

/// The words of a module before its first instruction.
const HEADER: usize = 5;

// Numbers of the SPIR-V specification, sections 3.20, 3.32 and 3.49, and of its extended instructions for GLSL.
const EXTENDED: u32 = 12;
/// Types, which stand behind all decorations.
const TYPES: std::ops::RangeInclusive<u32> = 19..=39;
const TYPE_FLOAT: u32 = 22;
const TYPE_VECTOR: u32 = 23;
const CONSTANT: u32 = 43;
const COMPOSITE: u32 = 44;
const FUNCTION: u32 = 54;
const DECORATE: u32 = 71;
const NO_CONTRACTION: u32 = 42;
const ADD: u32 = 129;
const SUBTRACT: u32 = 131;
const MULTIPLY: u32 = 133;
const DIVIDE: u32 = 136;
/// Square root, its inverse, and length.
const ROOTS: [u32; 3] = [31, 32, 66];
/// The interpolation of two values.
const MIX: u32 = 46;

/// The instructions of a module, and their opcodes. The upper half of an instruction's first word is its number of words (section 2.3).
pub fn instructions(words: &[u32]) -> impl Iterator<Item = (u32, &[u32])> {
    let mut rest = words.get(HEADER..).unwrap_or_default();
    std::iter::from_fn(move || {
        let first = *rest.first()?;
        let (own, after) = rest.split_at_checked((first >> 16).max(1) as usize)?;
        rest = after;
        Some((first & 0xffff, own))
    })
}

/// The module with quotients and roots times this factor, and with x + a (y - x) for mix(x, y, a), none of it contracted. WGSL allows 2.5 ULP for a
/// quotient and more for a root (section 15.7.4). GPUs make use of it, and NVIDIA's mix is that sum, which loses a small y. Software drivers round all of
/// them correctly: with a factor next to 1, they too return another number than 1 for x / x.
pub fn with_rough_quotients(words: &[u32], factor: f32) -> Vec<u32> {
    let mut bound = words[3];
    let mut fresh = || {
        bound += 1;
        bound - 1
    };
    // The factor as a number and as vectors, by their types.
    let mut factors: Vec<(u32, u32)> = Vec::new();
    let mut constants = Vec::new();
    let factor_of =
        |factors: &[(u32, u32)], of: u32| factors.iter().find(|(id, _)| *id == of).map(|(_, factor)| *factor);
    for instruction in instructions(words) {
        match instruction {
            (TYPE_FLOAT, &[_, id, 32]) => {
                let own = fresh();
                factors.push((id, own));
                constants.extend([4 << 16 | CONSTANT, id, own, factor.to_bits()]);
            }
            (TYPE_VECTOR, &[_, id, of, count]) if let Some(scalar) = factor_of(&factors, of) => {
                let own = fresh();
                factors.push((id, own));
                constants.extend([(3 + count) << 16 | COMPOSITE, id, own]);
                constants.extend((0..count).map(|_| scalar));
            }
            _ => {}
        }
    }
    let (mut rough, mut first_type, mut uncontracted) = (words[..HEADER].to_vec(), None, Vec::new());
    for (opcode, own) in instructions(words) {
        if TYPES.contains(&opcode) {
            first_type.get_or_insert(rough.len());
        }
        if opcode == FUNCTION {
            rough.append(&mut constants);
        }
        match (opcode, own) {
            (EXTENDED, &[_, of, result, _, MIX, x, y, share]) => {
                let (difference, part) = (fresh(), fresh());
                rough.extend([5 << 16 | SUBTRACT, of, difference, y, x]);
                rough.extend([5 << 16 | MULTIPLY, of, part, difference, share]);
                rough.extend([5 << 16 | ADD, of, result, x, part]);
                uncontracted.extend([difference, part, result]);
            }
            (DIVIDE, &[_, of, result, ..]) | (EXTENDED, &[_, of, result, ..])
                if (opcode == DIVIDE || ROOTS.contains(&own[4]))
                    && let Some(factor) = factor_of(&factors, of) =>
            {
                let exact = fresh();
                rough.extend(own);
                let at = rough.len() - own.len() + 2;
                rough[at] = exact;
                rough.extend([5 << 16 | MULTIPLY, of, result, exact, factor]);
                // A quotient's result may be decorated already.
                uncontracted.push(if opcode == DIVIDE { exact } else { result });
            }
            _ => rough.extend(own),
        }
    }
    rough[3] = bound;
    let decorations = uncontracted.into_iter().flat_map(|id| [3 << 16 | DECORATE, id, NO_CONTRACTION]);
    let first_type = first_type.unwrap_or(rough.len());
    rough.splice(first_type..first_type, decorations);
    rough
}
