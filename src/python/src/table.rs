//! The table of receivers. In: receivers of archives. Out: a column for each of their properties.

use crate::memory::{Block, Texts};
use heliotile::archive::LayeredReceiver;
use heliotile::{Receiver, Result};

/// Shares of a receiver's hemisphere: sky, ground, obstruction.
type Views = [f32; 3];

/// Property of a receiver that a column holds.
enum ReceiverColumn {
    /// Text, empty where it is not known.
    Text(fn(&Receiver) -> &str),
    /// Metres, m2 or shares; NaN where it is not known.
    Number(fn(&Receiver, Views) -> f64),
}

use ReceiverColumn::{Number, Text};

const COLUMNS: [(&str, ReceiverColumn); 15] = [
    ("receiver", Text(|receiver| &receiver.id)),
    ("x", Number(|receiver, _| receiver.position.x)),
    ("y", Number(|receiver, _| receiver.position.y)),
    ("z", Number(|receiver, _| receiver.position.z)),
    ("nx", Number(|receiver, _| receiver.normal.x)),
    ("ny", Number(|receiver, _| receiver.normal.y)),
    ("nz", Number(|receiver, _| receiver.normal.z)),
    ("area_m2", Number(|receiver, _| receiver.area.unwrap_or(f64::NAN))),
    ("surface", Text(|receiver| receiver.surface.as_deref().unwrap_or_default())),
    ("object", Text(|receiver| &receiver.part.object)),
    ("building", Text(|receiver| &receiver.part.building)),
    ("kind", Text(|receiver| receiver.part.kind.as_str())),
    ("sky_view", Number(|_, [sky, _, _]| f64::from(sky))),
    ("ground_view", Number(|_, [_, ground, _]| f64::from(ground))),
    ("obstruction_view", Number(|_, [_, _, obstruction]| f64::from(obstruction))),
];

/// A column to which receivers are appended.
enum Column {
    Texts(fn(&Receiver) -> &str, Texts),
    Numbers(fn(&Receiver, Views) -> f64, Vec<f64>),
}

impl Column {
    fn push(&mut self, receiver: &Receiver, views: Views) {
        match self {
            Column::Texts(text, values) => values.push(text(receiver)),
            Column::Numbers(number, values) => values.push(number(receiver, views)),
        }
    }

    fn block(self) -> Result<Block> {
        match self {
            Column::Texts(_, values) => values.block(),
            Column::Numbers(_, values) => {
                let count = values.len();
                Ok(Block::new(values, &[count]))
            }
        }
    }
}

/// Returns the columns `[receiver]` with their names.
pub fn columns_of(receivers: impl Iterator<Item = Result<LayeredReceiver<()>>>) -> Result<Vec<(&'static str, Block)>> {
    let mut columns = COLUMNS.map(|(name, told)| match told {
        Text(text) => (name, Column::Texts(text, Texts::default())),
        Number(number) => (name, Column::Numbers(number, Vec::new())),
    });
    for row in receivers {
        let LayeredReceiver { receiver, views, .. } = row?;
        columns.iter_mut().for_each(|(_, column)| column.push(&receiver, views));
    }
    columns.into_iter().map(|(name, column)| Ok((name, column.block()?))).collect()
}
