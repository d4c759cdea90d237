//! The command line of `view`.

use std::path::PathBuf;

use clap::Args;

use crate::cli::ClockArgs;
use crate::cli::sites::clock_of;

/// Text at the end of `view --help`.
const ABOUT: &str = "\
With --with the page switches between before, after and change. The change covers the receivers that both archives hold: those with the same
position and direction, whatever their names, and those with the same name.

An atlas is shown one part at a time; choose the part on the plan in the page.

The page is served on 127.0.0.1, to this machine only, until Ctrl-C. It reads the archive and does not change it. To show an archive elsewhere,
put it on any web server that supports range requests and open the page with ?url=ADDRESS (and &with=ADDRESS for the archive after a change), or
write a page that contains it with `heliotile export SITE.helio --html PAGE.html`. On a machine without a screen: `ssh -L 8017:127.0.0.1:8017 MACHINE`.";

#[derive(Args, Debug)]
#[command(after_long_help = ABOUT)]
#[command(group(clock_of("weather")))]
pub struct ViewArgs {
    /// Archive to show, or folder of an atlas
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
    /// Port of the page's address [default: 8017, or any free port if it is taken]
    #[arg(long, value_name = "PORT")]
    pub port: Option<u16>,
}
