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
    install = "install.md",
    method = "method.md",
    first_hour = "first-hour.md",
    scenes = "scenes.md",
    footprints = "footprints.md",
    rasters = "rasters.md",
    terrain = "terrain.md",
    place = "place.md",
    materials = "materials.md",
    mirrors_and_glass = "mirrors-and-glass.md",
    trees = "trees.md",
    canopies = "canopies.md",
    receivers = "receivers.md",
    weather_sources = "weather-sources.md",
    weather = "weather.md",
    skies = "skies.md",
    building = "building.md",
    effects = "effects.md",
    archives = "archives.md",
    command_line = "command-line.md",
    questions = "questions.md",
    query_and_replay = "query-and-replay.md",
    pv = "pv.md",
    cells = "cells.md",
    trackers = "trackers.md",
    buildings = "buildings.md",
    comparing = "comparing.md",
    envelope = "envelope.md",
    shading = "shading.md",
    sunlight = "sunlight.md",
    glare = "glare.md",
    comfort = "comfort.md",
    energyplus = "energyplus.md",
    reflectances = "reflectances.md",
    bands = "bands.md",
    longwave = "longwave.md",
    viewing = "viewing.md",
    pictures = "pictures.md",
    maps = "maps.md",
    export = "export.md",
    statements = "statements.md",
    regions = "regions.md",
    remote = "remote.md",
    python = "python.md",
    accuracy = "accuracy.md",
    validation = "validation.md",
    radiance = "radiance.md",
    energyplus_evidence = "energyplus-evidence.md",
    numerics = "numerics.md",
    performance = "performance.md",
    studies = "studies.md",
    glossary = "glossary.md",
    faq = "faq.md",
    limits = "limits.md",
    contributing = "contributing.md",
}

/// Options of all commands, a page for each.
pub mod reference;
