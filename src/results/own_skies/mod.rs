//! Skies and clouds from files of the user. In: names of files, the scaling of their light, the
//! conditions of a series. Out: the conditions under these skies and behind these clouds, and
//! warnings about the files.

mod hdr;
mod images;

use std::path::{Path, PathBuf};
use std::str::FromStr;

use super::resources::Resources;
use heliotile_core::error::{Error, Problem, Result};
use heliotile_core::sky::model::SkyModel;
use heliotile_core::sky::own_skies::{CloudLayer, OwnSky, SkyBalance, SkyScale, no_parts};
use heliotile_core::text::{Message, message};
use heliotile_core::units::parse_positive;
use heliotile_core::weather::conditions::Condition;
use heliotile_requests::{Request, Wrong};
use heliotile_weather::skies::{PatchFile, PatchQuantity, PatchRows, parse_patch_file};

use images::{Levels, is_picture, read_image};

/// Model of the sky, or a file of radiances.
#[derive(Clone, Debug, PartialEq)]
pub enum SkyChoice {
    /// Sky model, by its name.
    Model(SkyModel),
    /// Table, Radiance matrix or photograph.
    File(PathBuf),
}

impl SkyChoice {
    /// Returns the help text that says which values are possible.
    pub fn described() -> String {
        let model = SkyModel::described();
        format!(
            "{model}; or a file with a dot in its name: radiances of 145, 577 or 2305 patches as .csv, a matrix of Radiance (gendaymtx -s -O1, \
             genskyvec), or a square equidistant photograph of the sky as .png, .hdr or .exr"
        )
    }

    /// Returns the model that conditions are read with.
    pub fn model(&self) -> SkyModel {
        if let SkyChoice::Model(model) = self { *model } else { SkyModel::default() }
    }

    /// Returns the file of radiances.
    pub fn file(&self) -> Option<&Path> {
        if let SkyChoice::File(file) = self { Some(file) } else { None }
    }
}

impl FromStr for SkyChoice {
    type Err = Wrong;

    fn from_str(text: &str) -> std::result::Result<Self, Wrong> {
        match text.parse() {
            Ok(model) => Ok(SkyChoice::Model(model)),
            Err(_) if text.contains(['.', '/', '\\']) => Ok(SkyChoice::File(text.into())),
            Err(wrong) => Err(wrong),
        }
    }
}

/// Files of skies and clouds, and how their light is scaled.
#[derive(Clone, Debug, Default, PartialEq, Request)]
pub struct SkyFiles {
    /// Radiances in place of a model's.
    #[field(skip)]
    pub sky: Option<PathBuf>,
    /// Scale of the radiances in a file of --sky [default: dhi for photographs, given for tables
    /// and matrices].
    #[field(name = "sky_scale")]
    pub scale: Option<SkyScale>,
    /// Radiance of white in a photograph of --sky, W/m2/sr, for --sky-scale given [default: levels
    /// of .hdr and .exr are radiances].
    #[field(name = "sky_white", metavar = "RADIANCE", parse = parse_positive)]
    pub white_w_m2_sr: Option<f64>,
    /// Transmittance of clouds before sun and sky, 0 to 1 by direction: a table of patches as for
    /// --sky, or a square equidistant (fisheye) picture.
    #[field(metavar = "FILE", input = Any)]
    pub clouds: Option<PathBuf>,
    /// Azimuth of the top of the pictures of --sky and --clouds, degrees clockwise from true north;
    /// their left side is 90 degrees further clockwise [default: 0, north].
    #[field(metavar = "DEGREES", range = -360.0..=360.0, says = "give degrees from -360 to 360")]
    pub image_top_deg: Option<f64>,
}

/// Positions of conditions in the file that they come from.
pub(super) struct ConditionRows {
    /// `[condition]`: row of the file.
    pub places: Vec<usize>,
    /// Number of rows of the file.
    pub count: usize,
    /// Kind of the file, in words.
    pub file: &'static str,
}

/// Ratios to DHI at which the light of a file's skies causes no warning.
const FAIR: std::ops::RangeInclusive<f64> = 0.8..=1.25;

impl SkyFiles {
    /// Returns the files.
    pub fn files(&self) -> impl Iterator<Item = &Path> {
        [&self.sky, &self.clouds].into_iter().flatten().map(PathBuf::as_path)
    }

    /// Refuses choices without effect, before any file is read.
    pub(super) fn check(&self, model: SkyModel) -> Result<()> {
        let of_sky = [("sky_scale", self.scale.is_some()), ("sky_white", self.white_w_m2_sr.is_some())];
        if let Some((name, _)) = of_sky.into_iter().find(|(_, given)| *given && self.sky.is_none()) {
            return Err(Error::argument(
                name,
                "the sky is a model, not a file",
                "give a file with {sky}, or leave it out",
            )
            .because(Problem::needs("sky")));
        }
        if self.image_top_deg.is_some() && self.files().next().is_none() {
            let what = "no photograph of the sky or of clouds is given";
            return Err(Error::argument("image_top", what, "give one with {sky} or {clouds}, or leave it out"));
        }
        if self.clouds.is_some() && model.brightens() {
            return Err(no_parts());
        }
        Ok(())
    }

    /// Returns the conditions under the sky and behind the clouds; warns of what is odd about the
    /// files.
    pub(super) fn over(
        &self,
        conditions: Vec<Condition>,
        of: &ConditionRows,
        resources: &Resources,
    ) -> Result<Vec<Condition>> {
        let mut conditions = conditions;
        if let Some(path) = &self.sky {
            conditions = self.under(path, conditions, of, resources)?;
        }
        if let Some(path) = &self.clouds {
            conditions = self.behind(path, conditions, of, resources)?;
        }
        Ok(conditions)
    }

    fn under(
        &self,
        path: &Path,
        conditions: Vec<Condition>,
        of: &ConditionRows,
        resources: &Resources,
    ) -> Result<Vec<Condition>> {
        let bytes = (resources.files)(path)?;
        let scale_of = |kind: SourceKind| self.scale.unwrap_or(kind.scale());
        let (series, rows, kind) = if is_picture(path, &bytes)? {
            let are_relative = scale_of(SourceKind::Photograph) == SkyScale::Dhi;
            let levels = Levels::Radiances { white_w_m2_sr: self.white_w_m2_sr, are_relative };
            let image = read_image(path, &bytes, levels, self.image_top_deg.unwrap_or_default())?;
            let series = image.on_patches().ok_or_else(|| no_pixels(path))?;
            (series, vec![Some(0); conditions.len()], SourceKind::Photograph)
        } else {
            let file = parse_patch_file(path, &bytes, PatchQuantity::Radiance)?;
            let rows = matched(&file, path, &conditions, of, |condition| condition.dhi_w_m2 > 0.0)?;
            let kind = if file.is_matrix { SourceKind::Matrix } else { SourceKind::Table };
            (file.series, rows, kind)
        };
        let scale = scale_of(kind);
        let own = OwnSky::new(series, scale);
        let pairs = conditions.iter().zip(&rows).filter_map(|(condition, row)| Some((condition, (*row)?)));
        doubts(path, kind, scale, &own.balance(pairs)).iter().for_each(|text| resources.observer.warn(text));
        Ok(each_row(conditions, rows, |condition, row| own.over(condition, row)))
    }

    fn behind(
        &self,
        path: &Path,
        conditions: Vec<Condition>,
        of: &ConditionRows,
        resources: &Resources,
    ) -> Result<Vec<Condition>> {
        let bytes = (resources.files)(path)?;
        let (layer, rows) = if is_picture(path, &bytes)? {
            let image = read_image(path, &bytes, Levels::Shares, self.image_top_deg.unwrap_or_default())?;
            (CloudLayer::of_image(image).ok_or_else(|| no_pixels(path))?, vec![Some(0); conditions.len()])
        } else {
            let file = parse_patch_file(path, &bytes, PatchQuantity::Transmittance)?;
            let is_lit = |condition: &Condition| condition.dhi_w_m2 > 0.0 || condition.dni_w_m2 > 0.0;
            let rows = matched(&file, path, &conditions, of, is_lit)?;
            (CloudLayer::of_patches(file.series), rows)
        };
        Ok(each_row(conditions, rows, |condition, row| layer.over(condition, row)))
    }
}

/// Kind of the file that a sky was read from.
#[derive(Clone, Copy, Debug, PartialEq)]
enum SourceKind {
    Table,
    Matrix,
    Photograph,
}

impl SourceKind {
    fn scale(self) -> SkyScale {
        match self {
            SourceKind::Photograph => SkyScale::Dhi,
            SourceKind::Table | SourceKind::Matrix => SkyScale::Given,
        }
    }
}

/// Applies a row of a file to each condition; conditions without a row stay as they are.
fn each_row(
    conditions: Vec<Condition>,
    rows: Vec<Option<usize>>,
    over: impl Fn(Condition, usize) -> Condition,
) -> Vec<Condition> {
    let one = |(condition, row): (Condition, Option<usize>)| match row {
        Some(row) => over(condition, row),
        None => condition,
    };
    conditions.into_iter().zip(rows).map(one).collect()
}

fn no_pixels(path: &Path) -> Error {
    Error::input(path, None, "the picture has no pixels", "give a square picture")
}

fn matched(
    file: &PatchFile,
    path: &Path,
    conditions: &[Condition],
    of: &ConditionRows,
    needs: impl Fn(&Condition) -> bool,
) -> Result<Vec<Option<usize>>> {
    let labels: Vec<&str> = conditions.iter().map(|condition| condition.label.as_str()).collect();
    let needed: Vec<bool> = conditions.iter().map(needs).collect();
    let to = PatchRows { labels: &labels, needed: &needed, places: &of.places, rows: of.count, file: of.file };
    file.matched(path, to)
}

/// Returns warnings about a sky, from its light relative to the DHI of its conditions.
fn doubts(path: &Path, kind: SourceKind, scale: SkyScale, balance: &SkyBalance) -> Vec<Message> {
    let (file, mut found) = (path.display(), Vec::new());
    if kind != SourceKind::Photograph && balance.holds_sun() {
        let of_matrix = if kind == SourceKind::Matrix { " with `gendaymtx -s`" } else { "" };
        found.push(message!(
            "{file}: its skies give an open plane {:.0} % of the diffuse irradiance of the same rows: they seem to contain the sun, \
             which would count twice, as the direct irradiance is added. Make them{of_matrix} without the sun",
            100.0 * balance.ratio().unwrap_or_default()
        ));
    } else if let Some(ratio) = balance.ratio().filter(|ratio| scale == SkyScale::Given && !FAIR.contains(ratio)) {
        let of_matrix = match kind {
            SourceKind::Matrix => "; gendaymtx writes solar radiation with `-O1`, and by default only visible light",
            _ => "",
        };
        found.push(message!(
            "{file}: its skies give an open plane {:.0} % of the diffuse irradiance of the same rows, and are used unscaled; \
             {{sky_scale}} dhi scales them{of_matrix}",
            100.0 * ratio
        ));
    }
    if scale == SkyScale::Dhi && balance.black > 0 {
        let rows = balance.black;
        found.push(message!(
            "{file}: {rows} of its skies are black in rows with diffuse irradiance: a uniform sky is used there"
        ));
    }
    found
}

impl Default for SkyChoice {
    fn default() -> Self {
        SkyChoice::Model(SkyModel::default())
    }
}

heliotile_requests::parse_by_text!(SkyChoice: heliotile_requests::Form::TEXT => SkyChoice::file);

#[cfg(test)]
mod tests {
    use super::*;

    /// Names are models, names with a dot or a slash are files, and a word that is neither is
    /// refused with the names listed.
    #[test]
    fn a_name_with_a_dot_or_slash_is_a_file() {
        let read = |text: &str| text.parse::<SkyChoice>();
        assert_eq!(read("uniform").expect("a model"), SkyChoice::Model(SkyModel::Uniform));
        for file in ["sky.mtx", "skies/noon", "c:\\sky.png"] {
            assert_eq!(read(file).expect("a file"), SkyChoice::File(file.into()));
        }
        assert!(read("perez2").expect_err("neither").to_string().contains("perez1990"));
    }

    /// Four choices without effect are refused: a scale, a white and a top without a file, clouds
    /// in front of `perez1990`.
    #[test]
    fn choices_without_effect_are_refused() {
        let none = SkyFiles::default();
        let with_sky = SkyFiles { sky: Some("a.csv".into()), ..none.clone() };
        for (files, model) in [
            (SkyFiles { scale: Some(SkyScale::Dhi), ..none.clone() }, SkyModel::Perez),
            (SkyFiles { white_w_m2_sr: Some(1.0), ..none.clone() }, SkyModel::Perez),
            (SkyFiles { image_top_deg: Some(1.0), ..none.clone() }, SkyModel::Perez),
            (SkyFiles { clouds: Some("c.png".into()), ..none.clone() }, SkyModel::Perez1990),
        ] {
            assert!(matches!(files.check(model), Err(Error::Argument { .. })), "{files:?}");
        }
        assert!(none.check(SkyModel::Perez1990).is_ok() && with_sky.check(SkyModel::Perez).is_ok());
    }
}
