//! Where on Earth a file's coordinates lie: a coordinate reference system by its EPSG number, or the place itself.

/// What a file says of its place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Reference {
    /// Number of a coordinate reference system in the EPSG register; a compound one counts by its horizontal part.
    Epsg(u32),
    /// Degrees, north and east positive; coordinates are those of a local system, y to true north.
    Place { latitude_deg: f64, longitude_deg: f64 },
}
