//! Messages of the library in the words of the command line. In: errors and sentences that name
//! fields of requests and commands. Out: these with the options that fill the fields, and with the
//! commands as they are typed.

use std::collections::BTreeMap;
use std::sync::LazyLock;

use crate::cli::{command_line, named};
use heliotile::Error;
use heliotile::text::{Message, Named};

/// Options by the request field that they fill: the arguments of all commands.
static OPTIONS: LazyLock<BTreeMap<String, String>> = LazyLock::new(|| {
    let cli = command_line();
    let commands = [&cli].into_iter().chain(named(&cli).into_iter().map(|(_, command)| command));
    let options = commands.flat_map(|command| command.get_arguments());
    options.filter_map(|arg| Some((arg.get_id().to_string(), format!("--{}", arg.get_long()?)))).collect()
});

/// Words an error for the command line.
pub fn worded(error: Error) -> Error {
    error.in_words(&in_line)
}

/// Words a text for the command line.
pub fn worded_text(text: &Message) -> String {
    text.in_words(&in_line)
}

/// Returns the option that fills a field of a request, `--every` for `every`; `None` if no option
/// does.
pub fn option_of(field: &str) -> Option<&'static str> {
    OPTIONS.get(field).map(String::as_str)
}

fn in_line(named: Named) -> Option<String> {
    match named {
        Named::Field(field) => option_of(field).map(str::to_owned),
        Named::Command(words) => Some(format!("heliotile {words}")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Fields of 2 requests and of all commands become 4 options, in texts too; a name that no
    /// option fills stays.
    #[test]
    fn fields_become_options() {
        let named = |argument: &str| match worded(Error::argument(argument, "is 0", "give more")) {
            Error::Argument { argument, .. } => argument,
            _ => String::new(),
        };
        assert_eq!(named("azimuth_step, altitude_step"), "--azimuth-step, --altitude-step");
        assert_eq!(worded_text(&"take {every} month of {nothing}".into()), "take --every month of nothing");
        assert_eq!((named("threads").as_str(), named("SCENE").as_str()), ("--threads", "SCENE"));
    }

    /// A field has one option, whichever command takes it.
    #[test]
    fn options_have_one_name() {
        let cli = command_line();
        for (name, command) in named(&cli) {
            for arg in command.get_arguments() {
                let Some(long) = arg.get_long() else { continue };
                assert_eq!(option_of(arg.get_id().as_str()), Some(format!("--{long}").as_str()), "{name}");
            }
        }
    }
}
