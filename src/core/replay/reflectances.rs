//! Reflectances, transmittances and densities of leaves that a replay changes. In: the changes that
//! a user requests, the archive's materials, the weather. Out: checked schedules of materials.

use crate::named::NamedValues;
use crate::text::{Message, message};
use heliotile_requests::{Parse, Request};
use std::path::{Path, PathBuf};
use std::str::FromStr;

use crate::archive::manifest::Manifest;
use crate::error::{Error, Problem, Result};
use crate::light::fresnel::specular_mean;
use crate::light::states::Schedule;
use crate::opened::OpenSite;
use crate::replay::schedule_csv::{Column, ReadFile, Rows, parse_schedule};
use crate::site::ground::MonthlyGround;
use crate::site::material::{Class, MAX_LEAF_AREA_DENSITY, Material, left_after_metre};
use crate::weather::row::WeatherRow;

/// Source, in the weather file, of the ground's reflectance under snow.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Snow {
    /// The snow's reflectance wherever the snow depth is 1 cm or more
    Depth,
    /// The column `albedo`, wherever it has a value
    Albedo,
}

/// Column of the values in a schedule's file.
const REFLECTANCE: Column<'static> = Column { name: "reflectance", low: 0.0, high: 1.0 };
const TRANSMITTANCE: Column<'static> = Column { name: "transmittance", low: 0.0, high: 1.0 };
const LEAF_AREA_DENSITY: Column<'static> = Column { name: "leaf_area_density", low: 0.0, high: MAX_LEAF_AREA_DENSITY };

/// Depth from which on snow covers the ground.
const COVER_CM: f64 = 1.0;

/// Transmittance or leaf area density as a number, or the file that states it for each row of a
/// weather file.
#[derive(Clone, Debug, PartialEq)]
pub enum ConstantOrFile {
    /// One value for all conditions: a transmittance from 0 to 1, a density in m2/m3.
    Value(f64),
    /// A CSV file with a value for each row of the weather file, or for each month.
    File(PathBuf),
}

impl FromStr for ConstantOrFile {
    type Err = String;

    fn from_str(text: &str) -> std::result::Result<Self, String> {
        match text.parse::<f64>() {
            Ok(value) if value.is_finite() => Ok(ConstantOrFile::Value(value)),
            Ok(value) => Err(format!("{value} is not a finite number")),
            Err(_) if text.is_empty() => Err("give a number or a CSV file".into()),
            Err(_) => Ok(ConstantOrFile::File(text.into())),
        }
    }
}

/// Materials of an archive whose reflectances and transmittances may change.
pub struct Changeable<'a> {
    /// Path of the archive, for messages.
    pub site: &'a Path,
    /// Materials, by the numbers in cell keys.
    pub materials: &'a [Material],
    /// Reflectance of the ground by month, if the archive states it. Replays of weather use it
    /// where no other change applies.
    pub ground: Option<&'a MonthlyGround>,
}

/// Changes of reflectances and transmittances. Later entries win over earlier ones, constants over
/// the archive's monthly values, schedules over constants, snow over all of them.
#[derive(Clone, Debug, Default, Request)]
pub struct Changes {
    /// Change a diffuse reflectance: GROUP=0.6, or a material's name, `ground` or `obstruction` in
    /// place of the group; may be repeated, the last one counts.
    #[field(name = "reflectance", metavar = "GROUP=VALUE", parse = parse_reflectance)]
    pub constant: Vec<(String, f64)>,
    /// Change a diffuse reflectance over time: a CSV with a column `reflectance` and a line for
    /// each condition, for each row of the weather file, or for each of 12 months; may be repeated.
    #[field(name = "schedule", metavar = "GROUP=FILE", parse = parse_named, input = Any)]
    pub scheduled: Vec<(String, PathBuf)>,
    /// Source of the snow cover, and the reflectance of snow.
    #[field(skip)]
    pub snow: Option<(Snow, f64)>,
    /// Change the transmittance of canopies, the share of light that each of their faces, or each
    /// metre of a volume of leaves, lets through: GROUP=0.4, or a CSV as for --schedule, with a
    /// column `transmittance` (leaves by season); may be repeated, the last one counts.
    #[field(metavar = "GROUP=VALUE|FILE", parse = parse_named, input = Any)]
    pub transmittance: Vec<(String, ConstantOrFile)>,
    /// Change the leaf area density of crowns that are volumes of leaves, m2/m3: GROUP=0.8, or a
    /// CSV as for --schedule, with a column `leaf_area_density` (leaves by season); may be
    /// repeated, the last one counts.
    #[field(metavar = "GROUP=VALUE|FILE", parse = parse_named, input = Any)]
    pub leaf_area_density: Vec<(String, ConstantOrFile)>,
}

impl Changes {
    /// Returns the files that reflectances, transmittances and densities follow.
    pub fn files(&self) -> impl Iterator<Item = &Path> {
        let leaves = self.transmittance.iter().chain(&self.leaf_area_density);
        self.scheduled.iter().filter_map(Parse::path).chain(leaves.filter_map(Parse::path))
    }

    /// Returns true if nothing changes.
    pub fn is_empty(&self) -> bool {
        let leaves_stay = self.transmittance.is_empty() && self.leaf_area_density.is_empty();
        self.constant.is_empty() && self.scheduled.is_empty() && self.snow.is_none() && leaves_stay
    }

    /// Returns the changes whose names are `known`; snow stays.
    pub fn only(&self, known: impl Fn(&str) -> bool) -> Changes {
        let mut some = self.clone();
        some.constant.retain(|(name, _)| known(name));
        some.scheduled.retain(|(name, _)| known(name));
        some.transmittance.retain(|(name, _)| known(name));
        some.leaf_area_density.retain(|(name, _)| known(name));
        some
    }

    /// Returns the schedules over `conditions` conditions that have no date. `files` returns the
    /// bytes of schedule files.
    pub fn undated(&self, changeable: &Changeable, conditions: usize, files: ReadFile) -> Result<Vec<Schedule>> {
        let rows = Rows::Conditions(conditions);
        let mut schedules = self.reflecting(changeable, conditions)?;
        schedules.extend(self.following(changeable, rows, files)?);
        schedules.extend(self.letting_through(changeable, rows, files)?);
        Ok(schedules)
    }

    /// Returns the schedules of reflectance that files state.
    fn following(&self, changeable: &Changeable, rows: Rows, files: ReadFile) -> Result<Vec<Schedule>> {
        let of = |(name, path): &(String, PathBuf)| {
            let members = changeable.opaque(name)?;
            schedule(changeable, members, parse_schedule(path, &files(path)?, REFLECTANCE, rows)?)
        };
        self.scheduled.iter().map(of).collect()
    }

    fn reflecting(&self, changeable: &Changeable, conditions: usize) -> Result<Vec<Schedule>> {
        let of =
            |(name, value): &(String, f64)| schedule(changeable, changeable.opaque(name)?, vec![*value; conditions]);
        self.constant.iter().map(of).collect()
    }

    fn letting_through(&self, changeable: &Changeable, rows: Rows, files: ReadFile) -> Result<Vec<Schedule>> {
        let of = |(name, follow): &(String, ConstantOrFile), column: Column<'static>| {
            let values = match follow {
                ConstantOrFile::Value(value) => {
                    let Column { name: key, low, high } = column;
                    if !(low..=high).contains(value) {
                        let what = format!("`{name}` is {value}, not from {low} to {high}");
                        let problem = Problem::OutOfRange { found: *value, least: low, most: high };
                        return Err(Error::argument(key, what, "change the number").because(problem));
                    }
                    vec![*value; rows.count()]
                }
                ConstantOrFile::File(path) => parse_schedule(path, &files(path)?, column, rows)?,
            };
            Ok(Schedule { materials: changeable.canopies(name, column.name)?, values })
        };
        let faces = self.transmittance.iter().map(|named| of(named, TRANSMITTANCE));
        let volumes = self.leaf_area_density.iter().map(|named| {
            let Schedule { materials, values } = of(named, LEAF_AREA_DENSITY)?;
            Ok(Schedule { materials, values: values.into_iter().map(left_after_metre).collect() })
        });
        faces.chain(volumes).collect()
    }

    /// Returns the schedules over the rows of a weather file, and warnings for the user. `files`
    /// returns the bytes of schedule files.
    pub fn over(
        &self,
        changeable: &Changeable,
        rows: &[WeatherRow],
        files: ReadFile,
    ) -> Result<(Vec<Schedule>, Vec<Message>)> {
        let materials = changeable.materials;
        let mut schedules = by_month(changeable, rows)?;
        schedules.extend(self.reflecting(changeable, rows.len())?);
        let mut warnings = Vec::new();
        let dates: Vec<_> = rows.iter().map(|row| row.interval.date).collect();
        schedules.extend(self.following(changeable, Rows::Dated(&dates), files)?);
        if let Some((snow, reflectance)) = self.snow {
            let cover = |row: &WeatherRow| match snow {
                Snow::Depth => row.snow_depth_cm.filter(|depth| *depth >= COVER_CM).map(|_| reflectance),
                Snow::Albedo => row.albedo,
            };
            let covers: Vec<Option<f64>> = rows.iter().map(cover).collect();
            if covers.iter().all(Option::is_none) {
                warnings.push(match snow {
                    Snow::Depth if rows.iter().all(|row| row.snow_depth_cm.is_none()) => {
                        "the weather file states no snow depth (TMY3 has none): {snow} depth changes nothing".into()
                    }
                    Snow::Depth => {
                        message!("the weather file never has {COVER_CM} cm of snow: {{snow}} depth changes nothing")
                    }
                    Snow::Albedo => "the weather file has no albedo: {snow} albedo changes nothing".into(),
                });
            }
            // Snow lies over the ground as scheduled so far: later schedules win.
            let before = schedules.clone();
            let snowy = |&m: &usize| materials[m].class == Class::Ground && !changeable.is_canopy(m);
            for material in (0..materials.len()).filter(snowy) {
                let scheduled = before.iter().rev().find(|schedule| schedule.materials.contains(&material));
                let bare = |row: usize| scheduled.map_or(materials[material].diffuse, |s| s.values[row]);
                let values = covers.iter().enumerate().map(|(row, cover)| cover.unwrap_or_else(|| bare(row)));
                schedules.push(schedule(changeable, vec![material], values.collect())?);
            }
        }
        schedules.extend(self.letting_through(changeable, Rows::Dated(&dates), files)?);
        Ok((schedules, warnings))
    }
}

impl<'a> Changeable<'a> {
    /// Takes the materials and the monthly ground of an archive. Without diffuse reflections no
    /// light depends on the ground, so its months are left out.
    pub fn new(site: &'a OpenSite, manifest: &'a Manifest) -> Self {
        let ground = manifest.ground.as_ref().filter(|_| site.settings().diffuse);
        Changeable { site: site.path(), materials: site.materials(), ground }
    }
}

impl Changeable<'_> {
    /// Returns true if a group, a material or a class has this name.
    pub fn knows(&self, name: &str) -> bool {
        members(self.site, self.materials, name).is_ok()
    }

    fn is_canopy(&self, material: usize) -> bool {
        self.materials[material].transmittance.is_some()
    }

    /// Returns the opaque materials of a name. It is an error if there are none.
    fn opaque(&self, name: &str) -> Result<Vec<usize>> {
        let mut members = members(self.site, self.materials, name)?;
        members.retain(|&material| !self.is_canopy(material));
        self.some(
            members,
            name,
            "is a canopy, whose reflectance follows from its transmittance",
            "change its {transmittance}",
        )
        .map_err(|error| error.because(Problem::other_kind("canopy")))
    }

    /// Returns the canopies of a name that have a value of this key. It is an error if there are
    /// none. A volume has the `transmittance` of a metre, and a `leaf_area_density`.
    fn canopies(&self, name: &str, key: &'static str) -> Result<Vec<usize>> {
        let any = key == TRANSMITTANCE.name;
        let of_kind = |material: &&Material| material.transmittance.is_some() && (any || material.volume);
        let mut members = members(self.site, self.materials, name)?;
        members.retain(|&material| of_kind(&&self.materials[material]));
        let canopies: Vec<&str> =
            self.materials.iter().filter(of_kind).map(|material| material.name.as_str()).collect();
        let hint = match canopies.is_empty() {
            true => format!("give a material a `{key}` in materials.toml and build the archive again"),
            false => format!("name canopies or their group: {}", canopies.join(", ")),
        };
        let what = match any {
            true => "is not a canopy: it has no transmittance",
            false => "is no volume of leaves: it has no leaf area density",
        };
        self.some(members, name, what, hint).map_err(|error| error.because(Problem::Lacks(key)))
    }

    fn some(&self, members: Vec<usize>, name: &str, what: &str, hint: impl Into<Message>) -> Result<Vec<usize>> {
        match members.is_empty() {
            true => Err(Error::input(self.site, None, format!("`{name}` {what}"), hint)),
            false => Ok(members),
        }
    }
}

/// Returns the schedule of the ground that the archive states by month, if it does.
fn by_month(changeable: &Changeable, rows: &[WeatherRow]) -> Result<Vec<Schedule>> {
    let Some(ground) = changeable.ground else { return Ok(Vec::new()) };
    let Some(material) = changeable.materials.iter().position(|material| material.name == ground.material) else {
        let what =
            format!("states monthly reflectances of the ground `{}`, but holds no such material", ground.material);
        return Err(Error::input(changeable.site, None, what, "build the archive again"));
    };
    let values = rows.iter().map(|row| ground.of(row.interval.date.month, row.snow_depth_cm)).collect();
    Ok(vec![schedule(changeable, vec![material], values)?])
}

/// Returns the materials of a group. Without such a group it returns the materials of that name, or
/// else those of that class.
fn members(site: &Path, materials: &[Material], name: &str) -> Result<Vec<usize>> {
    let all = |named: &dyn Fn(&Material) -> bool| (0..materials.len()).filter(|&m| named(&materials[m])).collect();
    let of_class = |class| all(&|material| material.class == class);
    let found: [Vec<usize>; 2] = [all(&|m| m.group.as_deref() == Some(name)), all(&|m| m.name == name)];
    let found = found.into_iter().find(|members| !members.is_empty());
    let found: Vec<usize> = match (found, name) {
        (Some(found), _) if !name.is_empty() => found,
        (_, name) => Class::of_name(name).map(of_class).unwrap_or_default(),
    };
    if found.is_empty() {
        let mut groups: Vec<&str> = materials.iter().filter_map(|m| m.group.as_deref()).collect();
        groups.sort_unstable();
        groups.dedup();
        let listed = |names: &[&str]| match names {
            [] => "none".to_string(),
            names if names.len() > 20 => format!("{}, ...", names[..20].join(", ")),
            names => names.join(", "),
        };
        let names: Vec<&str> = materials.iter().map(|m| m.name.as_str()).collect();
        let what = format!("there is no group and no material `{name}`");
        let hint =
            format!("name a group ({}), a material ({}), `ground` or `obstruction`", listed(&groups), listed(&names));
        return Err(Error::input(site, None, what, hint).because(Problem::unknown(name, [])));
    }
    Ok(found)
}

/// Returns a schedule. Values that exceed 1 together with the specular reflectance of a material
/// are an error.
fn schedule(changeable: &Changeable, members: Vec<usize>, values: Vec<f64>) -> Result<Schedule> {
    let materials = changeable.materials;
    let largest = values.iter().copied().fold(0.0, f64::max);
    for &material in &members {
        let specular = specular_mean(&materials[material]);
        // The mean of a glass is a sum with rounding errors, and must not refuse a rest that just
        // fits.
        if largest + specular > 1.0 + 1e-9 {
            // Specular reflectances of glass have many digits, so the message rounds them up to
            // four.
            let shown = (specular * 1e4 - 1e-6).ceil() / 1e4;
            let what = format!(
                "material `{}` would reflect more light than arrives: {largest} diffusely and {shown} like a mirror",
                materials[material].name
            );
            let hint = format!("its diffuse reflectance can be at most {:.4}", 1.0 - shown);
            return Err(Error::input(changeable.site, None, what, hint));
        }
    }
    Ok(Schedule { materials: members, values })
}

crate::serde_by_name!(Snow);

impl NamedValues for Snow {
    const VALUES: &'static [(&'static str, &'static str, Self)] = &[
        ("depth", "The snow's reflectance wherever the snow depth is 1 cm or more", Snow::Depth),
        ("albedo", "The column `albedo`, wherever it has a value", Snow::Albedo),
    ];
}

crate::parse_by_name!(Snow);
impl Parse for ConstantOrFile {
    fn parse(text: &str) -> std::result::Result<Self, heliotile_requests::Wrong> {
        Ok(text.parse::<Self>()?)
    }

    fn path(&self) -> Option<&Path> {
        if let ConstantOrFile::File(file) = self { Some(file) } else { None }
    }
}

/// Reads `NAME=VALUE`: a group, material or class, and its value.
pub fn parse_named<T: FromStr<Err: std::fmt::Display>>(text: &str) -> std::result::Result<(String, T), String> {
    // The last equals sign counts: a name may hold one, a number does not.
    match text.rsplit_once('=') {
        Some((name, value)) if !name.is_empty() => {
            let value = value.trim().parse().map_err(|error| format!("`{value}`: {error}"))?;
            Ok((name.to_string(), value))
        }
        _ => Err("give a group or a material, an equals sign and a value".into()),
    }
}

fn parse_reflectance(text: &str) -> std::result::Result<(String, f64), String> {
    match parse_named(text)? {
        (name, value) if (0.0..=1.0).contains(&value) => Ok((name, value)),
        (_, value) => Err(format!("a reflectance is from 0 to 1, not {value}")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::weather::time::calendar::Date;
    use crate::weather::time::sun::Interval;
    use glam::DVec3;

    fn materials() -> Vec<Material> {
        let group = |name: &str| Some(name.to_string());
        vec![
            Material::matt("lawn", 0.2, Class::Ground),
            Material { group: group("ground"), ..Material::matt("street", 0.1, Class::Ground) },
            Material { group: group("facade"), ..Material::matt("wall", 0.4, Class::Obstruction) },
            Material { specular: 0.5, group: group("facade"), ..Material::matt("glass", 0.1, Class::Obstruction) },
        ]
    }

    fn changeable(materials: &[Material]) -> Changeable<'_> {
        Changeable { site: Path::new("a.helio"), materials, ground: None }
    }

    fn no_files(name: &Path) -> Result<Vec<u8>> {
        panic!("{} is asked for", name.display())
    }

    fn rows() -> Vec<WeatherRow> {
        let row = |month: u32, snow_depth_cm, albedo| {
            let date = Date::new(2021, month, 3).expect("a date");
            WeatherRow {
                line: 9,
                interval: Interval { date, start_min: 0.0, end_min: 60.0 },
                sun: DVec3::Z,
                ghi_w_m2: None,
                dni_w_m2: 0.0,
                dhi_w_m2: 0.0,
                albedo,
                snow_depth_cm,
            }
        };
        vec![row(1, Some(5.0), Some(0.7)), row(2, Some(0.4), None), row(3, None, Some(0.25))]
    }

    /// By depth, snow lies on both grounds in one of three rows, and by albedo in two, over the
    /// constant 0.3 of the street and the stored 0.2 of the lawn.
    #[test]
    fn snow_lies_on_ground_by_depth_or_albedo() {
        for (snow, lawn, street) in
            [(Snow::Depth, [0.6, 0.2, 0.2], [0.6, 0.3, 0.3]), (Snow::Albedo, [0.7, 0.2, 0.25], [0.7, 0.3, 0.25])]
        {
            let changes =
                Changes { constant: vec![("ground".into(), 0.3)], snow: Some((snow, 0.6)), ..Changes::default() };
            let (schedules, warnings) = changes.over(&changeable(&materials()), &rows(), &no_files).expect("schedules");
            assert!(warnings.is_empty());
            let of =
                |material| schedules.iter().rev().find(|s| s.materials.contains(&material)).map(|s| s.values.clone());
            assert_eq!((of(0), of(1), of(2)), (Some(lawn.to_vec()), Some(street.to_vec()), None));
        }
        let bare = [rows()[1]];
        let changes = Changes { snow: Some((Snow::Depth, 0.6)), ..Changes::default() };
        let (schedules, warnings) = changes.over(&changeable(&materials()), &bare, &no_files).expect("schedules");
        assert_eq!(warnings.len(), 1);
        assert_eq!(schedules.iter().map(|s| s.values[0]).collect::<Vec<_>>(), [0.2, 0.1]);
    }

    /// A lawn of 0.1 x month, half of it under any snow, follows the weather: 0.05, 0.1, 0.3. A
    /// constant 0.25 wins over it, and snow of 0.6 over both where it is 1 cm deep. A monthly
    /// ground without a material is refused by its name.
    #[test]
    fn monthly_ground_follows_the_weather() {
        let materials = materials();
        let reflectance = std::array::from_fn(|month| 0.1 * (month + 1) as f64).map(|value: f64| value.min(1.0));
        let ground = MonthlyGround { material: "lawn".into(), reflectance, snow_modifier: 0.5 };
        let over = |ground: &MonthlyGround, changes: &Changes| {
            let changeable = Changeable { ground: Some(ground), ..changeable(&materials) };
            let schedules = changes.over(&changeable, &rows(), &no_files).map(|found| found.0)?;
            Ok(schedules.into_iter().rev().find(|s| s.materials.contains(&0)).expect("of the lawn").values)
        };
        let constant = Changes { constant: vec![("lawn".into(), 0.25)], ..Changes::default() };
        let snowy = Changes { snow: Some((Snow::Depth, 0.6)), ..Changes::default() };
        for (changes, values) in [
            (Changes::default(), [0.05, 0.1, reflectance[2]]),
            (constant, [0.25; 3]),
            (snowy, [0.6, 0.1, reflectance[2]]),
        ] {
            assert_eq!(over(&ground, &changes).expect("values"), values);
        }
        let other = MonthlyGround { material: "plane".into(), ..ground };
        let refused: Error = over(&other, &Changes::default()).expect_err("no such material");
        assert!(refused.to_string().contains("of the ground `plane`"), "{refused}");
    }

    /// A group includes its 2 materials, a class its 2, and a material's name stands for the
    /// material. The error for an unknown name lists the 2 groups and 4 materials. A reflectance of
    /// 0.6 on a facade with half of its light mirrored is refused with the 0.5 that is left.
    #[test]
    fn a_name_stands_for_a_group_class_or_material() {
        let change = |name: &str, value| Changes { constant: vec![(name.into(), value)], ..Changes::default() };
        let schedules = change("facade", 0.5).undated(&changeable(&materials()), 2, &no_files).expect("schedules");
        assert_eq!(schedules, [Schedule { materials: vec![2, 3], values: vec![0.5, 0.5] }]);
        assert_eq!(
            change("lawn", 0.5).undated(&changeable(&materials()), 1, &no_files).expect("schedules")[0].materials,
            [0]
        );
        let text =
            change("roof", 0.5).undated(&changeable(&materials()), 1, &no_files).expect_err("unknown").to_string();
        assert!(
            text.contains(
                "a group (facade, ground), a material (lawn, street, wall, glass), `ground` or `obstruction`"
            ),
            "{text}"
        );
        let text =
            change("facade", 0.6).undated(&changeable(&materials()), 1, &no_files).expect_err("too much").to_string();
        assert!(text.contains("`glass`") && text.contains("at most 0.5000"), "{text}");
        assert!(change("", 0.6).undated(&changeable(&materials()), 1, &no_files).is_err());
    }
}
