//! The command line of `view`.

use std::path::PathBuf;

use clap::Args;

use crate::cli::ClockArgs;
use crate::cli::sites::clock_of;

/// Text at the end of `view --help`.
const ABOUT: &str = "\
With --with the page has a switch of before, after and change. The change is that of receivers that are in both archives: those at one place that look
one way, whatever they are called, and those of one name.

Of an atlas one part is shown at a time; which one is chosen on a plan of them in the page.

The page is served on 127.0.0.1 only, to this machine, until Ctrl-C; it reads what it shows from the archive, which is not changed. To look at an
archive from elsewhere, put it on any web server that answers ranges and open the page with ?url=ADDRESS, &with=ADDRESS for the one after, or write a page that holds it with
`heliotile export SITE.helio --html PAGE.html`. On a machine without a screen: `ssh -L 8017:127.0.0.1:8017 MACHINE`.";

#[derive(Args, Debug)]
#[command(after_long_help = ABOUT)]
#[command(group(clock_of("weather")))]
pub struct ViewArgs {
    /// Archive to look at, or folder of an atlas
    pub archive: PathBuf,
    /// Archive of the same site after a change: the page shows before, after and the change, under
    /// one sun, weather and camera
    #[arg(long, value_name = "AFTER")]
    pub with: Option<PathBuf>,
    /// Weather file whose hours and sums are shown: EPW, TMY3, SAM, PVGIS or CSV, packed with gzip
    /// or not
    #[arg(long, short)]
    pub weather: Option<PathBuf>,
    #[command(flatten)]
    pub about_weather: ClockArgs,
    /// Port of the address; without it 8017, or any that is free
    #[arg(long, value_name = "PORT")]
    pub port: Option<u16>,
}
