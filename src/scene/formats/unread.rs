//! Formats that heliotile does not read. In: the ending of a name. Out: an error that names the
//! format and a program that converts it to a format that heliotile reads.

use std::path::Path;

use heliotile_core::error::Error;

/// File endings, the kind of file they belong to, and how to convert it to a scene.
const UNREAD: [(&[&str], &str, &str); 19] = [
    (
        &["ifc", "ifczip", "ifcxml"],
        "a building model in IFC",
        "convert it with IfcOpenShell: `IfcConvert model.ifc model.obj`, and give model.obj",
    ),
    (
        &["rvt", "rfa"],
        "a Revit model",
        "export IFC from Revit, convert it with IfcOpenShell: `IfcConvert model.ifc model.obj`, and give model.obj",
    ),
    (
        &["gbxml"],
        "a building model in gbXML",
        "convert it to Honeybee: `honeybee-energy translate model-from-gbxml model.gbxml -f model.hbjson`, and give model.hbjson",
    ),
    (
        &["osm"],
        "an OpenStudio model or OpenStreetMap data",
        "from OpenStudio, export IDF (File, Export); from OpenStreetMap, extract the buildings: `ogr2ogr town.gpkg town.osm multipolygons -where \"building is not null\"`",
    ),
    (
        &["pbf"],
        "OpenStreetMap data",
        "extract the buildings: `ogr2ogr town.gpkg town.osm.pbf multipolygons -where \"building is not null\"`, and give town.gpkg",
    ),
    (
        &["las", "laz", "copc", "e57"],
        "a point cloud",
        "make a raster of its highest points with PDAL: `pdal pipeline dsm.json`, where dsm.json is [\"points.laz\", {\"type\": \"writers.gdal\", \"filename\": \"dsm.tif\", \"resolution\": 0.5, \"output_type\": \"max\"}], and give dsm.tif as {dsm}",
    ),
    (
        &["b3dm", "i3dm", "cmpt"],
        "a tile of 3D Tiles",
        "extract its glTF: `npx 3d-tiles-tools b3dmToGlb -i tile.b3dm -o tile.glb` (i3dmToGlb, cmptToGlb), and give the .glb; better give CityGML or CityJSON of the same city, because tiles do not name their buildings",
    ),
    (&["pnts"], "a point cloud of 3D Tiles", "make a raster of its highest points with PDAL, and give that as {dsm}"),
    (
        &["slpk"],
        "a scene layer of ArcGIS (I3S)",
        "export the buildings from ArcGIS as multipatch shapefile, or give CityGML or CityJSON of the same city",
    ),
    (
        &["step", "stp", "iges", "igs", "brep", "fcstd"],
        "a CAD solid",
        "export a mesh as OBJ or STL, such as from FreeCAD: File, Export, Wavefront (.obj)",
    ),
    (&["skp"], "a SketchUp model", "export glTF (.glb) or OBJ from SketchUp"),
    (&["3dm"], "a Rhino model", "export glTF (.glb) or OBJ from Rhino"),
    (
        &["dwg", "dxf"],
        "a CAD drawing",
        "export meshes as OBJ or STL; outlines of buildings as GeoPackage: `ogr2ogr town.gpkg drawing.dxf`",
    ),
    (
        &["blend", "fbx", "dae", "usd", "usda", "usdc", "usdz", "max", "3ds"],
        "a model of a 3D program",
        "export glTF from Blender: File, Export, glTF 2.0 (.glb)",
    ),
    (
        &["fgb", "kml", "kmz", "gpx", "tab", "mif"],
        "a GIS file that GDAL reads",
        "convert them: `ogr2ogr town.gpkg FILE`, and give town.gpkg",
    ),
    (
        &["gdb", "mdb"],
        "an Esri geodatabase",
        "extract the buildings: `ogr2ogr town.gpkg data.gdb buildings`, and give town.gpkg",
    ),
    (
        &["nc", "hgt", "vrt", "jp2", "img", "bil", "flt", "xyz", "ecw"],
        "a raster that GDAL reads",
        "convert it: `gdal_translate -co COMPRESS=DEFLATE in.vrt out.tif`, and give out.tif",
    ),
    (&["shx", "dbf", "prj", "cpg", "sbn"], "a part of a shapefile", "give the .shp beside it"),
    (&["epw", "wea"], "weather", "give it as {weather}, and files with geometry as the scene"),
];

/// Returns the error for a known ending that heliotile does not read; `None` for other endings.
pub(super) fn refusal(path: &Path, ending: &str) -> Option<Error> {
    let (_, what, hint) = UNREAD.iter().find(|(endings, _, _)| endings.contains(&ending))?;
    Some(Error::input(path, None, format!("the file is {what}, which heliotile does not read as a scene"), *hint))
}

/// Bytes of a file in which its kind is looked for.
const HEAD: usize = 1 << 16;

/// Words of the head of a JSON file without spaces, all of which stand in it, the kind that they
/// tell, and a way out.
const JSON: [(&[&str], &str, &str); 4] = [
    (
        &["\"geometryType\":\"esri"],
        "features of Esri (Esri JSON)",
        "convert them: `ogr2ogr town.geojson ESRIJSON:query.json`, or ask the service for `f=geojson`",
    ),
    (
        &["\"elements\":["],
        "an answer of Overpass (OpenStreetMap)",
        "convert it: `npx osmtogeojson overpass.json > town.geojson`, and give town.geojson",
    ),
    (&["\"type\":\"Topology\""], "TopoJSON", "convert it: `ogr2ogr town.geojson topo.json`, and give town.geojson"),
    (
        &["\"asset\":{", "\"geometricError\""],
        "a tileset of 3D Tiles",
        "give CityGML or CityJSON of the same city; tiles do not name their buildings. To read one tile, extract its glTF: \
         `npx 3d-tiles-tools b3dmToGlb -i tile.b3dm -o tile.glb`",
    ),
];

/// Returns the error for a file whose content tells that it is of a kind that is not read, whatever
/// its name.
pub(super) fn refusal_of_content(path: &Path, bytes: &[u8]) -> Option<Error> {
    let head = bytes.get(..HEAD.min(bytes.len())).unwrap_or_default();
    if [b"b3dm", b"i3dm", b"cmpt", b"pnts"].iter().any(|magic| head.starts_with(*magic)) {
        return refusal(path, std::str::from_utf8(head.get(..4)?).ok()?);
    }
    if head.starts_with(b"ISO-10303-21") && String::from_utf8_lossy(head).to_uppercase().contains("FILE_SCHEMA(('IFC") {
        return refusal(path, "ifc");
    }
    if head.trim_ascii_start().first() != Some(&b'{') {
        return None;
    }
    let plain: String = String::from_utf8_lossy(head).chars().filter(|letter| !letter.is_whitespace()).collect();
    let is_known =
        ["\"type\":\"FeatureCollection\"", "CityJSON", "\"Version\":{"].iter().any(|word| plain.contains(word));
    let mut kinds = JSON.iter().filter(|_| !is_known);
    let (_, what, hint) = kinds.find(|(words, _, _)| words.iter().all(|word| plain.contains(word)))?;
    Some(Error::input(path, None, format!("the file is {what}, which heliotile does not read as a scene"), *hint))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Each of more than 50 endings is listed once, in lower case, with a hint on what to do.
    #[test]
    fn each_ending_is_listed_once_with_a_hint() {
        let mut all: Vec<&str> = UNREAD.iter().flat_map(|(endings, _, _)| endings.iter().copied()).collect();
        let count = all.len();
        all.sort_unstable();
        all.dedup();
        assert!(
            count > 50 && all.len() == count && all.iter().all(|ending| *ending == ending.to_lowercase()),
            "{count}"
        );
        let message = refusal(Path::new("a.ifc"), "ifc").expect("known").to_string();
        assert!(
            message.contains("the file is a building model in IFC, which heliotile does not read")
                && message.contains("IfcConvert"),
            "{message}"
        );
        assert!(refusal(Path::new("a.obj"), "obj").is_none());
    }

    /// Four kinds of JSON and a tile of 3D Tiles that is named as glTF are told by their content,
    /// each with a way out; GeoJSON and glTF are none of them.
    #[test]
    fn five_kinds_are_told_by_their_content() {
        for (bytes, kind, way) in [
            (&b"{\"geometryType\": \"esriGeometryPolygon\", \"features\": []}"[..], "Esri JSON", "ESRIJSON:"),
            (b"{\"version\": 0.6, \"elements\": []}", "Overpass", "osmtogeojson"),
            (b"{\"type\": \"Topology\", \"objects\": {}}", "TopoJSON", "ogr2ogr"),
            (b"{\"asset\": {\"version\": \"1.0\"}, \"geometricError\": 100}", "tileset", "CityGML"),
            (b"b3dm\x01\0\0\0", "a tile of 3D Tiles", "b3dmToGlb"),
        ] {
            let message = refusal_of_content(Path::new("a.json"), bytes).expect("known").to_string();
            assert!(message.contains(kind) && message.contains(way), "{message}");
        }
        for bytes in
            [&b"{\"type\":\"FeatureCollection\",\"elements\":[]}"[..], b"{\"asset\":{\"version\":\"2.0\"}}", b""]
        {
            assert!(refusal_of_content(Path::new("a.json"), bytes).is_none());
        }
    }
}
