//! `heliotile info` of archives, and `archive verify`. In: an archive. Out: its contents, or its
//! damaged blocks.

use std::fmt::Write;

use super::{Outcome, say, scene, sunlight, warn, weather};
use crate::cli::worded_text;
use heliotile::archive::{Accuracy, TileNumber, format, open_archive, tables};
use heliotile::atlas::{Atlas, VerifyRequest, about};
use heliotile::cases::Info;
use heliotile::covering::black_below_horizon;
use heliotile::materials::{density_of, rounded};
use heliotile::output::is_archive;
use heliotile::requests::Problem;
use heliotile::text::{counted, excerpt};
use heliotile::tracing::in_hours;
use heliotile::{BandOptics, Component, Error, Provenance, Result, SceneRequest, SiteFrame, WeatherOptions};

/// Number of settings in the first of two lines.
const SETTINGS_A_LINE: usize = 7;

/// Most characters of a text of an archive that are shown.
const MAX_SHOWN: usize = 80;

/// `heliotile info`.
pub fn info(args: &Info, _: Provenance) -> Result<Outcome> {
    if let Some(name) = &args.rule {
        return sunlight::rules(name);
    }
    if let Some(file) = &args.weather {
        return weather::info(
            file,
            &args.about_weather,
            args.scene.frame.latitude_deg.zip(args.scene.frame.longitude_deg),
        );
    }
    if args.about_weather != WeatherOptions::default() {
        let hint = "give a weather file with {weather}, or leave them out";
        return Err(Error::argument("time_zone, shift, weather_stamp, date_order", "describe a weather file", hint)
            .because(Problem::needs("weather")));
    }
    if let [place] = args.files.as_slice()
        && let Some(atlas) = Atlas::find(place)?
    {
        say(&worded_text(&about::info(&atlas)?))?;
        return Ok(Outcome::Fine);
    }
    let path = match args.files.as_slice() {
        [path] if is_archive(path) && args.scene.surface.is_none() => path,
        files => {
            let request = SceneRequest { files: files.to_vec(), ..args.scene.clone() };
            return scene::info(&request.site()?);
        }
    };
    // Options of scenes do not apply to archives: they are refused rather than ignored.
    if args.scene.frame != SiteFrame::default() {
        let hint = "leave --crs, --latitude, --longitude, --rotate-deg, --elevation and --scale out";
        return Err(Error::input(path, None, "is an archive, whose place was stated when it was built", hint)
            .because(Problem::other_kind("archive")));
    }
    if !args.scene.footprints.is_default() {
        let hint = "leave --height, --storey-height and --base out";
        return Err(Error::input(path, None, "is an archive, not a file of footprints", hint));
    }
    let SceneRequest { materials, materials_only, no_ground, assume_version, .. } = &args.scene;
    if materials.is_some() || *materials_only || *no_ground || assume_version.is_some() {
        let hint = "leave --materials, --materials-only, --no-ground and --assume-version out";
        return Err(Error::input(path, None, "is an archive, whose surfaces were stated when it was built", hint)
            .because(Problem::other_kind("archive")));
    }
    let archive = open_archive(path, args.io)?;
    let manifest = archive.manifest();
    let mut out = String::new();
    let (scene, receivers, s) = (&manifest.scene, &manifest.receivers, &manifest.settings);
    line!(out, "{}", archive.path().display());
    let [name, version] = [&manifest.creator.name, &manifest.creator.version].map(|text| excerpt(text, MAX_SHOWN));
    line!(out, "  written by  {name} {version}");
    line!(out, "  root        {}", format::hex(&archive.root()));
    line!(
        out,
        "  scene       {}, {}, hash {}",
        counted(scene.triangles, "triangle"),
        counted(scene.materials, "material"),
        scene.content_hash
    );
    let [low, high] = scene.bounds_m;
    line!(
        out,
        "  bounds      {:.2} {:.2} {:.2} to {:.2} {:.2} {:.2} m",
        low[0],
        low[1],
        low[2],
        high[0],
        high[1],
        high[2]
    );
    if let Some(place) = &manifest.place {
        line!(out, "  place       {}", excerpt(&place.to_string(), 4 * MAX_SHOWN));
    }
    let tiles = counted(receivers.tiles.into(), "tile");
    line!(out, "  receivers   {} in {tiles} of {}", receivers.count, receivers.tile_size);
    let numbers: Vec<String> = s.numbers().map(|(setting, number)| format!("{}={number}", setting.name)).collect();
    let (first, rest) = numbers.split_at(numbers.len().min(SETTINGS_A_LINE));
    line!(out, "  settings    {}", first.join(" "));
    line!(out, "              {}; probes shared by {}", rest.join(" "), s.share);
    if !s.quality.is_empty() {
        line!(out, "  quality     {}", excerpt(&s.quality, MAX_SHOWN));
    }
    match &manifest.accuracy {
        Some(accuracy) => say_accuracy(&mut out, accuracy),
        None => {
            line!(out, "  error       not estimated: `build --error 2%` chooses settings and states their error");
        }
    }
    if !s.left_out.is_empty() {
        let why = manifest.negligible.as_ref().map_or(String::new(), |known| format!("; negligible: {known}"));
        line!(out, "  left out    {}{why}", s.left_out.join(", "));
    }
    if let Some(lost) = black_below_horizon(&archive)? {
        line!(out, "  horizon     {}", worded_text(&lost));
    }
    if let Some(ground) = &manifest.ground {
        let months: Vec<String> = ground.reflectance.iter().map(f64::to_string).collect();
        line!(
            out,
            "  ground      {} reflects {} by month, times {} under snow; {} without a date",
            ground.material,
            months.join(" "),
            ground.snow_modifier,
            rounded(ground.mean())
        );
    }
    if manifest.replay_only {
        line!(out, "  traced      for replay only: no hits, no cells");
    } else {
        line!(out, "  traced      {} probes, {} bounce cells", manifest.counts.probes, manifest.counts.bounce_cells);
    }
    if archive.has(format::OPTICS, TileNumber::FIRST) {
        let names = tables::MaterialsTable::from_block(&archive.block(format::MATERIALS, TileNumber::FIRST)?)?.name;
        let optics = tables::OpticsTable::from_block(&archive.block(format::OPTICS, TileNumber::FIRST)?)?;
        let of_material = names.iter().zip(optics.canopy.iter().zip(&optics.transmittance));
        let canopies: Vec<String> = of_material
            .filter(|(_, (kind, _))| **kind > 0)
            .map(|(name, (kind, tau))| match *kind == tables::VOLUME {
                true => format!("{}={} m2/m3", excerpt(name, MAX_SHOWN), rounded(density_of(*tau))),
                false => format!("{}={tau}", excerpt(name, MAX_SHOWN)),
            })
            .collect();
        if !canopies.is_empty() {
            line!(out, "  canopies    {}", canopies.join(" "));
        }
    }
    if archive.has(format::BANDS, TileNumber::FIRST) {
        let names = tables::MaterialsTable::from_block(&archive.block(format::MATERIALS, TileNumber::FIRST)?)?.name;
        let table = tables::BandsTable::from_block(&archive.block(format::BANDS, TileNumber::FIRST)?)?;
        let optics = table.optics(names.len()).unwrap_or_default();
        let stated = names.iter().zip(&optics).filter(|(_, optics)| **optics != BandOptics::default());
        let stated: Vec<String> = stated.map(|(name, _)| excerpt(name, MAX_SHOWN)).collect();
        line!(out, "  bands       {} values of {}", table.rows(), stated.join(", "));
    }
    line!(out, "  layer            blocks      raw bytes   stored bytes  a receiver");
    let mut stored = 0;
    for layer in &manifest.layers {
        stored += layer.stored_bytes;
        let each = layer.stored_bytes as f64 / receivers.count.max(1) as f64;
        line!(
            out,
            "  {:<13} {:>9} {:>14} {:>14} {each:>11.1}",
            layer.name,
            layer.blocks,
            layer.raw_bytes,
            layer.stored_bytes
        );
    }
    let each = stored as f64 / receivers.count.max(1) as f64;
    line!(out, "  {:<13} {:>9} {:>14} {stored:>14} {each:>11.1}", "all", "", "");
    say(&out)?;
    Ok(Outcome::Fine)
}

/// Writes the error that the build estimated.
fn say_accuracy(out: &mut String, a: &Accuracy) {
    line!(
        out,
        "  error       {} % of the mean total ({:.2} of {} W/m2), RMSE of hourly totals; target {} %, predicted {} %",
        a.rmse_percent,
        a.rmse_w_m2(),
        a.mean_w_m2,
        a.target_percent,
        a.predicted_percent
    );
    line!(
        out,
        "              bias {} %, means over all hours {} %; {} receivers, {} conditions ({})",
        a.bias_percent,
        a.yearly_percent,
        a.sample,
        a.conditions,
        a.weather
    );
    let place = |name: &str| Component::ALL.iter().position(|component| component.name() == name);
    let mut parts: Vec<_> = a.components_percent.iter().filter(|(name, _)| *name != Component::Total.name()).collect();
    parts.sort_by_key(|(name, _)| place(name).unwrap_or(usize::MAX));
    let parts: Vec<String> = parts.into_iter().map(|(name, percent)| format!("{name} {percent} %")).collect();
    line!(out, "              {}", parts.join(", "));
    for hours in &a.hours {
        line!(out, "              {}", in_hours(hours));
    }
    for group in &a.groups {
        let ([low, high], receivers) = (group.sky_view, counted(group.receivers.into(), "receiver"));
        let (rmse, mean) = (group.rmse_w_m2, group.mean_w_m2);
        line!(out, "              sky view {low:.2} to {high:.2} ({receivers}): {rmse} of {mean} W/m2");
    }
    for tile in &a.tiles {
        let receivers = counted(tile.receivers.into(), "receiver");
        let values: Vec<String> = tile.rmse_w_m2.iter().map(f64::to_string).collect();
        line!(out, "              tile {} ({receivers}): {} W/m2", tile.tile, values.join(" "));
    }
}

/// `heliotile archive verify`: a damaged block is a finding (exit 1), not a failure of the program.
pub fn verify(request: &VerifyRequest, _: Provenance) -> Result<Outcome> {
    let mut outcome = Outcome::Fine;
    request.each(|checked| {
        say(&checked.text())?;
        checked.warning().iter().for_each(warn);
        if !checked.is_good() {
            outcome = Outcome::ProblemFound;
        }
        Ok(())
    })?;
    Ok(outcome)
}
