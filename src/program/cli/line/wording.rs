//! Errors of the library in the words of the command line. In: an error that names a field of a request. Out: the same with the name of the
//! option that fills the field.

use clap::CommandFactory;

use crate::cli::Cli;
use heliotile_core::error::Error;
use heliotile_core::text::with_fields;

/// An error in the words of the command line.
pub fn worded(error: Error) -> Error {
    error.in_words(&option)
}

/// A text in the words of the command line.
pub fn worded_text(text: &str) -> String {
    with_fields(text, &option)
}

/// The option that fills a field; the field itself if no option does.
fn option(field: &str) -> String {
    let cli = Cli::command();
    let mut commands = cli.get_subcommands();
    let long = commands.find_map(|command| command.get_arguments().find(|arg| arg.get_id() == field)?.get_long());
    long.map_or_else(|| field.to_owned(), |long| format!("--{long}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Fields of 2 requests become 4 options, in texts too; what no option fills stays.
    #[test]
    fn fields_become_options() {
        let named = |argument: &str| match worded(Error::argument(argument, "is 0", "give more")) {
            Error::Argument { argument, .. } => argument,
            _ => String::new(),
        };
        assert_eq!(named("azimuth_step, altitude_step"), "--azimuth-step, --altitude-step");
        assert_eq!(worded_text("take {every} month"), "take --every month");
        assert_eq!((named("bounces").as_str(), named("SCENE").as_str()), ("--bounces", "SCENE"));
    }
}
