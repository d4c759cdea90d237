//! The commands whose requests declare their fields. In: words of a command line. Out: texts by
//! field, and the command that takes them.

use clap::builder::{PossibleValue, PossibleValuesParser, ValueParser};
use clap::parser::ValueSource;
use clap::{Arg, ArgAction, ArgGroup, ArgMatches, Command};

use heliotile::cases::{self, Given};
use heliotile::requests::{GroupKind, Many, Row};
use heliotile::text::Named;

/// Text at the end of the help of some commands.
const MORE: [(&str, &str); 3] = [
    ("copy", "\
FROM, TO or both are addresses: s3://BUCKET/NAME, gs://BUCKET/NAME or az://CONTAINER/NAME; https://HOST/NAME can only be read. An object
appears under its name when it is complete. If two programs write one name at the same time, one succeeds and the other reports an error. An
archive of more than 16 MiB is stored as NAME.ROOT.helio, and NAME is a small pointer that every command follows. An atlas, named by its folder
or address, is copied as a whole, atlas.json last. Files that are already there and equal are not sent again, so the same command resumes an
interrupted copy. Credentials come from environment variables: see src/book/remote.md."),
    ("view", "\
With --with the page switches between before, after and change. The change covers the receivers that both archives hold: those with the same
position and direction, whatever their names, and those with the same name.

An atlas is shown one part at a time; choose the part on the plan in the page.

The page is served on 127.0.0.1, to this machine only, until Ctrl-C. It reads the archive and does not change it. To show an archive elsewhere,
put it on any web server that supports range requests and open the page with ?url=ADDRESS (and &with=ADDRESS for the archive after a change), or
write a page that contains it with `heliotile export SITE.helio --html PAGE.html`. On a machine without a screen: `ssh -L 8017:127.0.0.1:8017 MACHINE`."),
    ("export", "\
An .exr file has three parts, or four if the receiver sees sky in mirrors (f32, texels of equal solid angle, see schema/layers.md). The attribute
`heliotile` of each part describes its contents as JSON. Parts and their channels:
  sky       upper hemisphere of the world, first line towards y: visible, weight_sr; with --sun also sky_direct, sun_direct
  hit       hemisphere of the surface, first line up the surface: class (1 ground, 2 obstruction), material, cell, mirrors
            passed, weight_sr; with --sun also sun_reflected, sky_reflected: the radiance of what is seen there
  response  upper hemisphere of the world: ground.x to obstruction.z, reflected light by the direction of its source;
            with --sun also weight_sr, sky_reflected: the radiance of the sky there
  mirror    upper hemisphere of the world, by the direction that light has in the sky: weight_sr;
            with --sun also sky_mirrored, sun_mirrored
Behind canopies, `sky` also has `through`, the share of light that passes them. Channels named like a column of `replay` are radiances, W/(m2 sr):
their sum over the texels of a part, each times weight_sr, is that column.

A .png shows the upper hemisphere, equidistant (fisheye), zenith in the middle, y up, x right as on a map, N at true north. With --weather or
--latitude it shows the sun's paths at the solstices and equinoxes, and the sun's position at each full hour through the year. With --panel and
--sun it has six pictures as a camera on the surface sees them: what is seen, then radiances of the sky, of sunlit surfaces, of sun and sky in
mirrors and of skylit surfaces, and their sum, on one logarithmic scale; the irradiance of each, in W/m2, stands above it."),
];

/// Returns a command as clap parses it, with or without its options.
pub fn parsed(of: &cases::Command, has_options: bool) -> Command {
    let mut command = Command::new(of.last_word()).about(of.about);
    if !has_options {
        return command;
    }
    let rows = (of.rows)();
    if let Some((_, text)) = MORE.iter().find(|(name, _)| *name == of.last_word()) {
        command = command.after_long_help(*text);
    }
    let is_known = |name: &&str| rows.iter().any(|row| row.name == *name);
    for row in &rows {
        let mut arg = arg_of(row).conflicts_with_all(row.conflicts.iter().copied().filter(is_known));
        let needed: Vec<&str> = row.requires.iter().copied().filter(is_known).collect();
        match needed.as_slice() {
            [] => {}
            [only] => arg = arg.requires(*only),
            several => {
                let group = several.join("|");
                if command.get_groups().all(|known| known.get_id() != &group) {
                    command = command.group(ArgGroup::new(group.clone()).args(several.to_vec()).multiple(true));
                }
                arg = arg.requires(group);
            }
        }
        command = command.arg(arg);
    }
    for (number, group) in (of.groups)().into_iter().enumerate() {
        let names: Vec<&str> = group.names.iter().copied().filter(is_known).collect();
        if names.len() < 2 {
            continue;
        }
        let (multiple, required) = (group.kind == GroupKind::AnyOf, group.kind != GroupKind::AtMostOne);
        command =
            command.group(ArgGroup::new(format!("group {number}")).args(names).multiple(multiple).required(required));
    }
    command
}

/// Returns the texts that were typed.
pub fn given(of: &cases::Command, matches: &ArgMatches) -> Given {
    let typed = |row: &Row| matches.value_source(row.name) == Some(ValueSource::CommandLine);
    let texts = |row: &Row| match row.many {
        Many::Flag => Vec::new(),
        _ => matches.get_many::<String>(row.name).into_iter().flatten().cloned().collect(),
    };
    (of.rows)().iter().filter(|row| typed(row)).map(|row| (row.name.to_owned(), texts(row))).collect()
}

/// Returns a field as an option.
fn as_option(named: Named) -> Option<String> {
    match named {
        Named::Field(field) => Some(format!("--{}", field.replace('_', "-"))),
        Named::Command(_) => None,
    }
}

fn arg_of(row: &Row) -> Arg {
    let mut arg = Arg::new(row.name).help(row.help.in_words(&as_option)).help_heading(row.heading);
    if !row.positional {
        arg = arg.long(row.name.replace('_', "-"));
    }
    if let Some(short) = row.short {
        arg = arg.short(short);
    }
    if row.many == Many::Flag {
        return arg.action(ArgAction::SetTrue);
    }
    let shown = row.metavar.map_or_else(|| row.name.to_uppercase(), str::to_owned);
    let choices = (row.form.choices)();
    let test = row.test;
    let parser = match choices.is_empty() {
        true => ValueParser::new(move |text: &str| test(text).map(|()| text.to_owned())),
        false => {
            let value = |(name, meaning): (&'static str, &'static str)| match meaning {
                "" => PossibleValue::new(name),
                meaning => PossibleValue::new(name).help(meaning),
            };
            PossibleValuesParser::new(choices.into_iter().map(value)).into()
        }
    };
    arg = arg.value_name(shown).value_parser(parser).allow_hyphen_values(row.hyphen).required(row.required);
    arg = arg.allow_negative_numbers(row.form.is_number && !row.hyphen);
    arg = match row.many {
        Many::List => arg.action(ArgAction::Append),
        _ => arg.action(ArgAction::Set),
    };
    if row.several || row.positional && row.many == Many::List {
        arg = arg.num_args(1..);
    }
    if let Some(delimiter) = row.delimiter {
        arg = arg.value_delimiter(delimiter);
    }
    match &row.default {
        Some(default) => arg.default_value(default.clone()),
        None => arg,
    }
}
