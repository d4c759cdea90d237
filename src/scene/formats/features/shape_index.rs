//! The index of a shapefile. In: the bytes of the .shp and of the .shx (Esri 1998, "Organization of
//! the Index File"). Out: an index in which each entry leads to a record of the .shp.

const HEADER: usize = 100;
const ENTRY: usize = 8;

/// Returns the index of a shapefile: the one beside it, or, if that is absent or leads to places
/// without a record, one of all records in the order of the .shp.
pub(super) fn of(shapes: &[u8], beside: Option<&[u8]>) -> Vec<u8> {
    let sound = beside.and_then(|index| sound(shapes, index));
    written(shapes, &sound.unwrap_or_else(|| records(shapes)))
}

/// Returns the entries of an index if each leads to a record of the length that it states.
fn sound(shapes: &[u8], index: &[u8]) -> Option<Vec<[u32; 2]>> {
    let stated = usize::try_from(number(index, 24)?).ok()?.checked_mul(2)?;
    let body = index.get(HEADER..stated.min(index.len()))?;
    let entries = body.chunks_exact(ENTRY).map(|entry| Some([number(entry, 0)?, number(entry, 4)?]));
    let entries: Vec<[u32; 2]> = entries.collect::<Option<_>>()?;
    let leads = |[start, length]: &[u32; 2]| {
        let at = (*start as usize).checked_mul(2).filter(|at| *at >= HEADER);
        // Some writers pad records: the record may be shorter than the index states.
        at.and_then(|at| number(shapes, at + 4)).is_some_and(|found| found <= *length)
    };
    (!entries.is_empty() && entries.iter().all(leads)).then_some(entries)
}

/// Returns the places of all records, in the order of the file.
fn records(shapes: &[u8]) -> Vec<[u32; 2]> {
    let end = number(shapes, 24).map_or(0, |words| (words as usize).saturating_mul(2)).min(shapes.len());
    let mut entries = Vec::new();
    let mut at = HEADER;
    while at < end
        && let (Ok(start), Some(length)) = (u32::try_from(at / 2), number(shapes, at + 4))
    {
        entries.push([start, length]);
        at = (length as usize).saturating_mul(2).saturating_add(at + ENTRY);
    }
    entries
}

fn written(shapes: &[u8], entries: &[[u32; 2]]) -> Vec<u8> {
    let mut index = shapes.get(..HEADER.min(shapes.len())).unwrap_or_default().to_vec();
    let words = u32::try_from((HEADER + entries.len() * ENTRY) / 2).unwrap_or(u32::MAX);
    index.get_mut(24..28).into_iter().for_each(|slot| slot.copy_from_slice(&words.to_be_bytes()));
    index.extend(entries.iter().flatten().flat_map(|number| number.to_be_bytes()));
    index
}

/// Returns the big-endian number at a place.
fn number(bytes: &[u8], at: usize) -> Option<u32> {
    bytes.get(at..at.checked_add(4)?)?.try_into().ok().map(u32::from_be_bytes)
}
