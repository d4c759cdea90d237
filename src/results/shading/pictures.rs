//! Pictures of what takes light. In: shares of receivers, and what one receiver sees. Out: a chart
//! of periods, and the hemisphere of the receiver in the chart's colours.

use std::collections::BTreeMap;
use std::io::Write;
use std::path::{Path, PathBuf};

use glam::DVec3;

use crate::outputs::pictures::bars::{Bars, Stack};
use crate::outputs::pictures::colours::ColourScale;
use crate::outputs::pictures::drawing::Rgb;
use crate::outputs::pictures::fisheye::{Overlay, TINTS, Tint, fisheye};
use crate::outputs::provenance::Provenance;
use crate::outputs::shading::{Share, ShareRows};
use crate::outputs::sink::Sink;
use crate::outputs::tables::layout::BinKind;
use heliotile_core::error::{Error, Result};
use heliotile_core::opened::SeenObject;
use heliotile_core::replay::by_object::ObjectDisc;
use heliotile_core::replay::receiver_view::ReceiverView;
use heliotile_core::site::north::North;
use heliotile_core::site::place::Place;
use heliotile_core::weather::time::sun::Location;
use heliotile_core::weather::time::sun_path::{MONTHS, SunPath};
use heliotile_files::writing::guards::guard_output;

/// Colours that colour-blind people can tell apart (Okabe and Ito 2008), for the takers that take
/// most, and of all others.
const COLOURS: [Rgb; TINTS - 1] = [
    [0xd5, 0x5e, 0x00],
    [0x00, 0x72, 0xb2],
    [0xe6, 0x9f, 0x00],
    [0x00, 0x9e, 0x73],
    [0xcc, 0x79, 0xa7],
    [0xf0, 0xe4, 0x42],
    [0x50, 0x50, 0x50],
];
const OTHERS: Rgb = [0xb4, 0xb4, 0xb4];

/// Surroundings that one receiver sees.
pub struct Hemisphere {
    pub view: ReceiverView,
    pub disc: ObjectDisc,
    /// Names of the objects of `disc`.
    pub names: BTreeMap<SeenObject, String>,
    pub place: Option<Place>,
    pub north: North,
}

/// Returns true if a picture is a chart.
pub fn is_chart(path: &Path) -> bool {
    path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("svg"))
}

/// Refuses pictures of unknown endings, and pictures that would replace an input.
pub fn check(plots: &[PathBuf], inputs: &[&Path]) -> Result<()> {
    for plot in plots {
        if !is_chart(plot) && !plot.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("png")) {
            return Err(Error::Unsupported {
                what: "ending of a picture".into(),
                found: format!("`{}`", plot.display()),
                supported: ".png for what a receiver sees, .svg for a chart".into(),
            });
        }
        guard_output(plot, inputs)?;
    }
    Ok(())
}

/// Draws all pictures; `called` describes the conditions.
pub fn draw(
    plots: &[PathBuf],
    rows: &ShareRows,
    shares: &[Share],
    hemisphere: Option<Hemisphere>,
    called: &str,
    about: &Provenance,
) -> Result<()> {
    let takers = takers(shares, rows.labels.len());
    let name = |(i, (name, _)): (usize, &(String, Vec<f64>))| (name.clone(), COLOURS.get(i).copied().unwrap_or(OTHERS));
    let mut names: Vec<(String, Rgb)> = takers.iter().enumerate().map(name).collect();
    let has_others = names.len() > COLOURS.len();
    let png = hemisphere.map(|seen| {
        let colours: BTreeMap<String, Rgb> = names.iter().cloned().collect();
        names.truncate(COLOURS.len());
        names.extend(has_others.then(|| ("others".to_owned(), OTHERS)));
        let colour = move |name: &String| colours.get(name).copied().unwrap_or(OTHERS);
        let tints: BTreeMap<SeenObject, Rgb> =
            seen.names.iter().map(|(object, name)| (*object, colour(name))).collect();
        let (disc, site) =
            (seen.disc, seen.place.and_then(|place| Location::new(place.latitude_deg, 0.0, 0.0, 0.0).ok()));
        let at = move |direction: DVec3| tints.get(&disc.seen(direction)).copied().unwrap_or(OTHERS);
        let path = site.map(|site| (SunPath::on(&MONTHS, &site), "hours of mean solar time".to_owned()));
        let overlay =
            Overlay { path, north: seen.north, tint: Some(Tint { at: Box::new(at), names }), ..Overlay::default() };
        fisheye(&seen.view, &overlay, about)
    });
    let png = png.transpose()?;
    for plot in plots {
        let bytes = match &png {
            Some(png) if !is_chart(plot) => png.clone(),
            _ => bars(rows, &takers, about.with_place(&format!("{called}; mean of all receivers by area")))
                .drawing()
                .svg_file(about)
                .into_bytes(),
        };
        let mut sink = Sink::file(plot)?;
        sink.write_all(&bytes).map_err(Error::io(plot, "write to"))?;
        sink.finish()?;
    }
    Ok(())
}

/// Returns what each taker takes from all receivers, the mean by area for each period; those that
/// take most come first.
fn takers(shares: &[Share], periods: usize) -> Vec<(String, Vec<f64>)> {
    let weight = |share: &Share| share.area_m2.unwrap_or(1.0);
    let mut places: Vec<(usize, f64)> = shares.iter().map(|share| (share.group, weight(share))).collect();
    places.dedup_by_key(|place| place.0);
    let whole: f64 = places.iter().map(|place| place.1).sum();
    let mut found: BTreeMap<&str, Vec<f64>> = BTreeMap::new();
    for share in shares {
        let sums = found.entry(&share.taker).or_insert_with(|| vec![0.0; periods]);
        for taken in &share.light.taken {
            sums.iter_mut().zip(taken).for_each(|(sum, taken)| *sum += taken * weight(share) / whole);
        }
    }
    let mut takers: Vec<(String, Vec<f64>)> = found.into_iter().map(|(name, sums)| (name.to_owned(), sums)).collect();
    let all = |sums: &[f64]| sums.iter().sum::<f64>();
    takers.sort_by(|a, b| all(&b.1).total_cmp(&all(&a.1)));
    takers
}

fn bars(rows: &ShareRows, takers: &[(String, Vec<f64>)], called: String) -> Bars {
    let (first, rest) = takers.split_at(takers.len().min(COLOURS.len()));
    let one = |((name, values), colour): (&(String, Vec<f64>), &Rgb)| Stack {
        name: name.clone(),
        colour: *colour,
        values: values.clone(),
    };
    let mut stacks: Vec<Stack> = first.iter().zip(&COLOURS).map(one).collect();
    if !rest.is_empty() {
        let sum = |period: usize| rest.iter().map(|(_, values)| values[period]).sum();
        stacks.push(Stack { name: "others".into(), colour: OTHERS, values: (0..rows.labels.len()).map(sum).collect() });
    }
    Bars {
        title: "Direct light that objects take".into(),
        called,
        unit: if rows.kind == BinKind::Sums { "kWh/m2" } else { "W/m2" }.into(),
        labels: rows.labels.text.clone(),
        stacks,
        scale: ColourScale::FromZero,
    }
}
