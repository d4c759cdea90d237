//! In: whole numbers in nested arrays (boundaries, semantic values). Out: one flat list of marks of
//! four bytes, and the surfaces in it, found without recursion.

use std::fmt;
use std::ops::Range;

use serde::Deserialize;
use serde::de::{DeserializeSeed, Deserializer, Error, SeqAccess, Visitor};

/// Mark of the beginning of an array.
const OPEN: u32 = u32::MAX;
/// Mark of the end of an array.
const CLOSE: u32 = u32::MAX - 1;
/// Mark of a null.
const NOTHING: u32 = u32::MAX - 2;

/// Depth of the arrays of a MultiSolid, the deepest geometry there is (CityJSON 2.0.1, section 3).
const DEEPEST: usize = 5;

/// Nested arrays of numbers below `NOTHING`; every `OPEN` has its `CLOSE`.
#[derive(Debug, Default)]
pub(in crate::formats) struct Nested(pub(super) Vec<u32>);

/// A surface in boundaries.
#[derive(Debug)]
pub(super) struct Surface {
    /// Range of its rings among the marks.
    pub rings: Range<usize>,
    /// Its semantic value.
    pub value: Option<u32>,
    /// Its indices in the arrays around it, outermost first.
    pub path: [u32; 3],
}

impl Nested {
    /// Begins an array.
    pub(in crate::formats) fn open(&mut self) {
        self.0.push(OPEN);
    }

    /// Ends the array that began last.
    pub(in crate::formats) fn close(&mut self) {
        self.0.push(CLOSE);
    }

    /// Adds a number. `None`, and a number beyond those that boundaries may hold, become null.
    pub(in crate::formats) fn push(&mut self, number: Option<u32>) {
        self.0.push(number.map_or(NOTHING, |number| number.min(NOTHING)));
    }

    /// Returns all surfaces, where numbers stand `depth` arrays deep (3 in a MultiSurface, 4 in a
    /// Solid, 5 in a MultiSolid). Each surface has its number in `values`, whose arrays are two
    /// levels less deep. The error says what is wrong.
    pub(super) fn surfaces(&self, depth: usize, values: Option<&Nested>) -> Result<Vec<Surface>, String> {
        let mut values = Values { marks: values.map(|values| values.0.as_slice()), nulls: 0 };
        let (mut level, mut start, mut value) = (0_usize, 0, None);
        // Number of arrays that ended at each level since the array around them began.
        let mut ended = [0_u32; DEEPEST + 1];
        let mut found = Vec::new();
        for (i, &mark) in self.0.iter().enumerate() {
            match mark {
                OPEN => {
                    level += 1;
                    if level > depth {
                        return Err(format!("boundaries are nested more than {depth} arrays deep"));
                    } else if level + 1 == depth {
                        start = i + 1;
                        value = values.take()?;
                    } else if level + 1 < depth {
                        values.open()?;
                    }
                }
                CLOSE => {
                    if level + 1 == depth {
                        let count = |level: usize| ended.get(level).filter(|_| level < depth).copied();
                        let path = [2, 3, 4].map(|level| count(level).unwrap_or_default());
                        found.push(Surface { rings: start..i, value, path });
                    } else if level + 1 < depth {
                        values.close()?;
                    }
                    if let Some(count) = ended.get_mut(level) {
                        *count += 1;
                    }
                    // The count within starts anew in the next array.
                    if let Some(within) = ended.get_mut(level + 1) {
                        *within = 0;
                    }
                    level = level.saturating_sub(1);
                }
                NOTHING => return Err("boundaries hold null".into()),
                _ if level != depth => {
                    return Err(format!("boundaries hold vertex numbers {level} arrays deep in place of {depth}"));
                }
                _ => {}
            }
        }
        Ok(found)
    }

    /// Returns the rings of a surface, the outline first.
    pub(super) fn rings(&self, surface: &Surface) -> impl Iterator<Item = &[u32]> {
        let marks = self.0.get(surface.rings.clone()).unwrap_or_default();
        marks.split(|mark| *mark == CLOSE).filter_map(|ring| ring.strip_prefix(&[OPEN]))
    }

    /// Returns all numbers at any depth.
    pub(super) fn numbers_mut(&mut self) -> impl Iterator<Item = &mut u32> {
        self.0.iter_mut().filter(|mark| **mark < NOTHING)
    }

    /// Returns the only number; `None` if there is none or more than one.
    pub(super) fn single(&self) -> Option<u32> {
        match *self.0.as_slice() {
            [OPEN, number, CLOSE] if number < NOTHING => Some(number),
            _ => None,
        }
    }
}

/// Semantic values, read in step with boundaries. A null in place of an array stands for an array
/// of nulls.
struct Values<'a> {
    marks: Option<&'a [u32]>,
    /// Number of arrays of boundaries that are open within a null.
    nulls: usize,
}

impl Values<'_> {
    fn next(&mut self) -> Result<Option<u32>, String> {
        let Some(marks) = &mut self.marks else { return Ok(None) };
        let Some((&mark, rest)) = marks.split_first() else { return Err(differs()) };
        *marks = rest;
        Ok(Some(mark))
    }

    fn open(&mut self) -> Result<(), String> {
        if self.nulls > 0 {
            self.nulls += 1;
            return Ok(());
        }
        match self.next()? {
            None | Some(OPEN) => {}
            Some(NOTHING) => self.nulls = 1,
            Some(_) => return Err(differs()),
        }
        Ok(())
    }

    fn take(&mut self) -> Result<Option<u32>, String> {
        if self.nulls > 0 {
            return Ok(None);
        }
        match self.next()? {
            None | Some(NOTHING) => Ok(None),
            Some(OPEN | CLOSE) => Err(differs()),
            value => Ok(value),
        }
    }

    fn close(&mut self) -> Result<(), String> {
        if self.nulls > 0 {
            self.nulls -= 1;
            return Ok(());
        }
        match self.next()? {
            None | Some(CLOSE) => Ok(()),
            Some(_) => Err(differs()),
        }
    }
}

fn differs() -> String {
    "the values of its semantics are not one for each surface, in the same arrays as its boundaries".into()
}

impl<'de> Deserialize<'de> for Nested {
    fn deserialize<D: Deserializer<'de>>(source: D) -> Result<Self, D::Error> {
        let mut marks = Vec::new();
        Level { marks: &mut marks, depth: 0 }.deserialize(source)?;
        Ok(Nested(marks))
    }
}

/// Content of an array at `depth`.
struct Level<'m> {
    marks: &'m mut Vec<u32>,
    depth: usize,
}

impl<'de> DeserializeSeed<'de> for Level<'_> {
    type Value = ();

    fn deserialize<D: Deserializer<'de>>(self, source: D) -> Result<(), D::Error> {
        source.deserialize_any(self)
    }
}

impl<'de> Visitor<'de> for Level<'_> {
    type Value = ();

    fn expecting(&self, to: &mut fmt::Formatter) -> fmt::Result {
        to.write_str("whole numbers from 0 in arrays")
    }

    fn visit_u64<E: Error>(self, number: u64) -> Result<(), E> {
        let mark = u32::try_from(number).ok().filter(|mark| *mark < NOTHING);
        self.marks
            .push(mark.ok_or_else(|| E::custom(format_args!("{number} is beyond the 4294967292 vertices allowed")))?);
        Ok(())
    }

    fn visit_unit<E: Error>(self) -> Result<(), E> {
        self.marks.push(NOTHING);
        Ok(())
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut items: A) -> Result<(), A::Error> {
        if self.depth == DEEPEST {
            return Err(A::Error::custom(format_args!("arrays are nested more than {DEEPEST} deep")));
        }
        self.marks.push(OPEN);
        while items.next_element_seed(Level { marks: &mut *self.marks, depth: self.depth + 1 })?.is_some() {}
        self.marks.push(CLOSE);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn nested(text: &str) -> Nested {
        serde_json::from_str(text).expect(text)
    }

    /// Two shells of 2 and 1 surfaces are read with their indices, their 4 rings and their values;
    /// the values of a whole shell may be null.
    #[test]
    fn values_in_step_name_their_surfaces() {
        let solid = nested("[[[[0,1,2],[3,4,5]],[[6,7,8]]],[[[9,10,11]]]]");
        for (values, expected) in [
            (Some("[[4,null],[5]]"), [Some(4), None, Some(5)]),
            (Some("[null,[5]]"), [None, None, Some(5)]),
            (Some("null"), [None; 3]),
            (None, [None; 3]),
        ] {
            let values = values.map(nested);
            let surfaces = solid.surfaces(4, values.as_ref()).expect("in step");
            assert_eq!(surfaces.iter().map(|surface| surface.value).collect::<Vec<_>>(), expected);
            assert_eq!(
                surfaces.iter().map(|surface| surface.path).collect::<Vec<_>>(),
                [[0, 0, 0], [0, 1, 0], [1, 0, 0]]
            );
            let rings: Vec<&[u32]> = surfaces.iter().flat_map(|surface| solid.rings(surface)).collect();
            assert_eq!(rings, [[0, 1, 2], [3, 4, 5], [6, 7, 8], [9, 10, 11]]);
        }
    }

    /// Nine shapes that do not match are refused with a message.
    #[test]
    fn shapes_out_of_step_are_refused() {
        for (boundaries, depth, values, said) in [
            ("[[0,1,2]]", 3, None, "2 arrays deep in place of 3"),
            ("7", 3, None, "0 arrays deep in place of 3"),
            ("[[[[0,1,2]]]]", 3, None, "more than 3 arrays deep"),
            ("[[[0,null,2]]]", 3, None, "hold null"),
            ("[[[0,1,2]]]", 3, Some("[]"), "not one for each surface"),
            ("[[[0,1,2]]]", 3, Some("[0,1]"), "not one for each surface"),
            ("[[[0,1,2]]]", 3, Some("[[0]]"), "not one for each surface"),
            ("[[[0,1,2]]]", 3, Some("0"), "not one for each surface"),
            ("[[[[0,1,2]]],[[[0,1,2]]]]", 4, Some("[[0]]"), "not one for each surface"),
        ] {
            let values = values.map(nested);
            let what = nested(boundaries).surfaces(depth, values.as_ref()).expect_err(boundaries);
            assert!(what.contains(said), "{boundaries}: {what}");
        }
        for text in ["[-1]", "[1.5]", "[4294967293]", "[\"a\"]", "[[[[[[0]]]]]]", "{}"] {
            assert!(serde_json::from_str::<Nested>(text).is_err(), "{text}");
        }
    }
}
