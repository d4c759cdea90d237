//! The book: what README summarises, a topic a page. The pages are plain files in `src/book`, too.
#![doc = include_str!("README.md")]

/// Declares a module for each page, with the text of the page.
macro_rules! pages {
    ($($page:ident = $file:literal),+ $(,)?) => {$(
        #[doc = include_str!($file)]
        pub mod $page {}
    )+};
}

pages! {
    first_hour = "first-hour.md",
    scenes = "scenes.md",
    footprints = "footprints.md",
    place = "place.md",
    terrain = "terrain.md",
    rasters = "rasters.md",
    materials = "materials.md",
    receivers = "receivers.md",
    building = "building.md",
    effects = "effects.md",
    command_line = "command-line.md",
    query_and_replay = "query-and-replay.md",
    comparing = "comparing.md",
    sunlight = "sunlight.md",
    glare = "glare.md",
    maps = "maps.md",
    pictures = "pictures.md",
    weather = "weather.md",
    skies = "skies.md",
    reflectances = "reflectances.md",
    canopies = "canopies.md",
    mirrors_and_glass = "mirrors-and-glass.md",
    bands = "bands.md",
    longwave = "longwave.md",
    comfort = "comfort.md",
    energyplus = "energyplus.md",
    pv = "pv.md",
    python = "python.md",
    viewing = "viewing.md",
    shading = "shading.md",
    buildings = "buildings.md",
    export = "export.md",
    regions = "regions.md",
    archives = "archives.md",
    remote = "remote.md",
    method = "method.md",
    accuracy = "accuracy.md",
    validation = "validation.md",
    radiance = "radiance.md",
    numerics = "numerics.md",
    performance = "performance.md",
    limits = "limits.md",
    studies = "studies.md",
    contributing = "contributing.md",
}

/// Options of all commands, a page for each.
pub mod reference;
