//! Sums over a weather file by kind of surface and by orientation. In: receivers and their sums.
//! Out: a table as text.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use crate::outputs::annual::AnnualRow;
use heliotile_core::replay::components::Component;
use heliotile_core::site::north::North;
use heliotile_core::units::tilt_and_azimuth;

/// Least tilt of a surface with a compass side, degrees: flat roofs have a slope of 1 to 3, pitched
/// ones begin at about 15.
const FLAT_BELOW_DEG: f64 = 10.0;

const SIDES: [&str; 4] = ["north", "east", "south", "west"];
const NO_SIDES: [&str; 2] = ["flat", "underneath"];

/// Running sums of rows with the same kind or side.
#[derive(Default)]
struct Group {
    receivers: usize,
    /// Number of receivers that have an area.
    with_area: usize,
    area_m2: f64,
    /// Sums of kWh by component; `plain` are sums of kWh/m2 without regard to areas.
    weighted: [f64; 7],
    plain: [f64; 7],
}

impl Group {
    fn add(&mut self, row: &AnnualRow) {
        let area = row.receiver.area;
        self.receivers += 1;
        self.with_area += usize::from(area.is_some());
        self.area_m2 += area.unwrap_or_default();
        for (i, sum) in row.kwh_m2.into_iter().enumerate() {
            self.weighted[i] += area.unwrap_or_default() * f64::from(sum);
            self.plain[i] += f64::from(sum);
        }
    }

    /// Returns the sum of the components' means: by area, or plain if a receiver has no area.
    fn mean(&self, components: &[Component]) -> f64 {
        let (sums, whole) = match self.has_area() {
            true => (&self.weighted, self.area_m2),
            false => (&self.plain, self.receivers.max(1) as f64),
        };
        components.iter().map(|component| sums[*component as usize]).sum::<f64>() / whole
    }

    fn has_area(&self) -> bool {
        self.with_area == self.receivers && self.area_m2 > 0.0
    }
}

/// Running sums by kind of surface and by side.
pub struct KindsAndSides {
    kinds: BTreeMap<String, (Group, BTreeMap<&'static str, Group>)>,
    north: North,
}

impl KindsAndSides {
    /// Returns empty sums; sides are by true north.
    pub fn new(north: North) -> Self {
        KindsAndSides { kinds: BTreeMap::new(), north }
    }

    /// Adds a receiver.
    pub fn add(&mut self, row: &AnnualRow) {
        let (tilt, azimuth) = tilt_and_azimuth(self.north.to_true(row.receiver.normal));
        let (all, sides) = self.kinds.entry(kind(row, tilt)).or_default();
        all.add(row);
        sides.entry(side(tilt, azimuth)).or_default().add(row);
    }

    /// Returns the table, with a line that defines the sides if it has any.
    pub fn table(&self) -> String {
        let kinds = &self.kinds;
        let mut out = format!(
            "{:14} {:>9} {:>11} {:>10} {:>9} {:>9} {:>9} {:>9} {:>11}\n",
            "surfaces",
            "receivers",
            "area m2",
            "sun_direct",
            "sky_direct",
            "reflected",
            "mirrored",
            "total",
            "sum, MWh"
        );
        let mut sided = false;
        for (name, (all, sides)) in kinds {
            line(&mut out, name, all);
            // A row for "all are flat" would repeat the row of the kind.
            let tells = |(side, group): &(&&str, &Group)| group.receivers < all.receivers || !NO_SIDES.contains(side);
            for (side, group) in sides.iter().filter(tells) {
                sided = true;
                line(&mut out, &format!("{name}, {side}"), group);
            }
        }
        if sided {
            let _ = writeln!(
                out,
                "flat: tilted by less than {FLAT_BELOW_DEG} degrees; others by azimuth: north from 315 to 45 degrees, east from 45 to 135, \
                 south from 135 to 225, west from 225 to 315"
            );
        }
        out
    }
}

fn line(out: &mut String, name: &str, group: &Group) {
    let total = group.mean(&[Component::Total]);
    let (area, sum) = match group.has_area() {
        true => (format!("{:.1}", group.area_m2), format!("{:.1}", total * group.area_m2 / 1e3)),
        false => ("-".to_owned(), "-".to_owned()),
    };
    // Writing to a string cannot fail.
    let _ = writeln!(
        out,
        "{name:14} {:>9} {area:>11} {:>10.1} {:>10.1} {:>9.1} {:>9.1} {total:>9.1} {sum:>11}",
        group.receivers,
        group.mean(&[Component::SunDirect]),
        group.mean(&[Component::SkyDirect]),
        group.mean(&[Component::SunReflected, Component::SkyReflected]),
        group.mean(&[Component::SunMirrored, Component::SkyMirrored]),
    );
}

/// Returns the kind of a receiver; if its model states none, the direction that it faces.
fn kind(row: &AnnualRow, tilt_deg: f64) -> String {
    match row.receiver.part.kind.as_str() {
        "" if tilt_deg < 60.0 => "looking up".to_owned(),
        "" if tilt_deg > 120.0 => "looking down".to_owned(),
        "" => "upright".to_owned(),
        kind => kind.to_owned(),
    }
}

/// Returns `flat`, `underneath`, or the compass side that a surface faces; azimuths are 0 to 360.
pub fn side(tilt_deg: f64, azimuth_deg: f64) -> &'static str {
    if tilt_deg < FLAT_BELOW_DEG {
        return NO_SIDES[0];
    }
    if tilt_deg > 180.0 - FLAT_BELOW_DEG {
        return NO_SIDES[1];
    }
    // Azimuths are below 360, so the quarter is at most 4, which is north again.
    let quarter = ((azimuth_deg + 45.0) / 90.0) as usize % SIDES.len();
    SIDES.get(quarter).copied().unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;
    use heliotile_core::site::receiver::Receiver;

    fn row(kind: &str, tilt_deg: f64, azimuth_deg: f64, area: Option<f64>, total: f32) -> AnnualRow {
        let (level, z) = tilt_deg.to_radians().sin_cos();
        let (x, y) = azimuth_deg.to_radians().sin_cos();
        let mut receiver = Receiver::new("r".into(), DVec3::ZERO, DVec3::new(level * x, level * y, z));
        receiver.part.kind = kind.to_owned();
        let mut kwh_m2 = [0.0; 7];
        kwh_m2[Component::Total as usize] = total;
        AnnualRow { receiver: Receiver { area, ..receiver }, kwh_m2 }
    }

    fn by_kind_and_side(rows: &[AnnualRow], north: North) -> String {
        let mut sums = KindsAndSides::new(north);
        rows.iter().for_each(|row| sums.add(row));
        sums.table()
    }

    /// A roof of 30 degrees facing south is not flat, one of 5 is: 1000 on 10 m2 and 700 on 20 m2
    /// have the mean 800 and sum to 24 MWh.
    #[test]
    fn pitched_roofs_have_sides() {
        let text = by_kind_and_side(
            &[
                row("roof", 30.0, 180.0, Some(10.0), 1000.0),
                row("roof", 5.0, 0.0, Some(20.0), 700.0),
                row("wall", 90.0, 314.0, Some(1.0), 400.0),
            ],
            North::default(),
        );
        let cells = |name: &str| -> Vec<String> {
            let line =
                text.lines().find(|line| line.get(..14).is_some_and(|head| head.trim_end() == name)).expect(name);
            line[14..].split_whitespace().map(str::to_owned).collect()
        };
        assert_eq!((cells("roof")[6].as_str(), cells("roof")[7].as_str()), ("800.0", "24.0"));
        assert_eq!((cells("roof, south")[6].as_str(), cells("roof, flat")[6].as_str()), ("1000.0", "700.0"));
        assert_eq!(cells("wall"), cells("wall, west"));
        assert!(text.contains("less than 10 degrees"), "{text}");
        // Flat roofs alone have one row.
        assert!(!by_kind_and_side(&[row("roof", 5.0, 0.0, None, 700.0)], North::default()).contains("roof, "));
    }

    /// Receivers without areas have a plain mean, 550 of 500 and 600, and neither area nor MWh; the
    /// kind of a receiver that faces up is "looking up".
    #[test]
    fn without_areas_there_is_no_energy() {
        let text =
            by_kind_and_side(&[row("", 0.0, 0.0, None, 500.0), row("", 0.0, 0.0, Some(3.0), 600.0)], North::default());
        let line = text.lines().nth(1).expect("a row");
        let cells: Vec<&str> = line.split_whitespace().collect();
        assert_eq!(cells, ["looking", "up", "2", "-", "0.0", "0.0", "0.0", "0.0", "550.0", "-"], "{text}");
    }

    /// An azimuth at the border of two sides belongs to the next side: 8 of 8.
    #[test]
    fn a_border_azimuth_belongs_to_the_next_side() {
        for (azimuth, expected) in [
            (0.0, "north"),
            (44.9, "north"),
            (45.0, "east"),
            (134.9, "east"),
            (135.0, "south"),
            (225.0, "west"),
            (314.9, "west"),
            (315.0, "north"),
        ] {
            assert_eq!(side(90.0, azimuth), expected, "{azimuth}");
        }
    }
}
