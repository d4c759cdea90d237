//! Footprints, rasters and CityGML through the commands that use a scene: parts of a region,
//! archives, surroundings of EnergyPlus models.

use std::fs;
use std::path::Path;
use std::process::Output;

use crate::cli::{Folder, golden, stderr, stdout};

/// Returns the scenes by their kinds.
fn sources(folder: &Folder) -> [(&'static str, String); 3] {
    let data = |name: &str| Path::new(crate::ROOT).join("tests/data").join(name).display().to_string();
    let text = fs::read_to_string(data("citygml/small.gml")).expect("a model");
    // Two tiles hold half of the city objects each.
    let (head, rest) = text.split_once("<core:cityObjectMember>").expect("members");
    let (members, tail) = rest.rsplit_once("</core:cityObjectMember>").expect("members");
    let members: Vec<&str> = members.split("</core:cityObjectMember>").collect();
    fs::create_dir_all(folder.path("tiles")).expect("a folder");
    for tile in 0..2 {
        let of_tile = members.iter().enumerate().filter(|(i, _)| i * 2 / members.len() == tile);
        let member = |(i, text): (usize, &&str)| {
            let open = if i == 0 { "<core:cityObjectMember>" } else { "" };
            format!("{open}{text}</core:cityObjectMember>")
        };
        let text = format!("{head}{}{tail}", of_tile.map(member).collect::<String>());
        folder.write(&format!("tiles/tile_{tile}.gml"), &text);
    }
    let street = |layer: &str| format!("--{} {}", layer, data(&format!("rasters/street_{layer}.tif")));
    let rasters = ["dsm", "dem", "canopy", "landcover"].map(street).join(" ");
    [("footprints", data("footprints/town.gpkg")), ("rasters", rasters), ("citygml", "tiles".to_owned())]
}

fn done(folder: &Folder, command: &str) -> Output {
    let output = folder.run(command);
    assert_eq!(output.status.code(), Some(0), "{command}: {}", stderr(&output));
    output
}

/// Returns the sums by receiver, sorted: name, and the rest of the row.
fn sums(folder: &Folder, place: &str) -> Vec<String> {
    let command = format!("replay {place} --weather {} --every total", golden().display());
    let mut rows: Vec<String> = stdout(&done(folder, &command)).lines().map(str::to_owned).collect();
    rows.sort();
    rows
}

/// Each kind of source, cut into parts that see the whole of it, gives the rows of the one archive
/// to the digit.
#[test]
fn parts_give_the_rows_of_one_archive() {
    let folder = Folder::new();
    for (kind, scene) in sources(&folder) {
        done(&folder, &format!("receivers {scene} --spacing 8m -o {kind}.csv"));
        done(&folder, &format!("build {scene} -r {kind}.csv --quality draft -o {kind}.helio"));
        done(
            &folder,
            &format!("atlas partition {scene} --spacing 8m --quality draft --part-size 40m --sample 0 -o {kind}"),
        );
        done(&folder, &format!("build {kind} --part all"));
        let parts = fs::read_dir(folder.path(kind).join("parts")).expect("parts").count();
        let (whole, atlas) = (sums(&folder, &format!("{kind}.helio")), sums(&folder, kind));
        println!("{kind}: {} receivers in {parts} parts", whole.len() - 1);
        assert!(parts > 1 && whole.len() > 20, "{kind}: {parts} parts, {} receivers", whole.len() - 1);
        assert_eq!(whole, atlas, "{kind}");
    }
}

/// A folder of two tiles has the surfaces of the file that they were cut from.
#[test]
fn tiles_have_the_surfaces_of_the_whole_file() {
    let folder = Folder::new();
    let file = Path::new(crate::ROOT).join("tests/data/citygml/small.gml");
    let surfaces = |scene: &str| {
        let text = stdout(&done(&folder, &format!("info {scene}")));
        let lines = text.lines().filter(|line| line.starts_with(' '));
        lines.map(str::to_owned).collect::<Vec<_>>()
    };
    sources(&folder);
    let (one, two) = (surfaces(&file.display().to_string()), surfaces("tiles"));
    assert!(one.len() > 5);
    assert_eq!(one, two);
}

/// Each kind of source, moved to the box of an EnergyPlus model, becomes more than 8 shading
/// surfaces around it.
#[test]
fn every_source_becomes_shading_around_a_model() {
    let folder = Folder::new();
    folder.write("box.idf", include_str!("../data/energyplus/box.idf"));
    let rasters = Path::new(crate::ROOT).join("tests/data/rasters");
    let street = |layer: &str| format!("{layer} = {:?}\n", rasters.join(format!("street_{layer}.tif")));
    let layers: String = ["dsm", "dem", "canopy", "landcover"].map(street).concat();
    folder.write("street.toml", &format!("[[scene]]\n{layers}"));
    let at = [("footprints", "691600,5334800"), ("rasters", "500030,5700030"), ("citygml", "565060,5935020")];
    for ((kind, scene), (_, place)) in sources(&folder).into_iter().zip(at) {
        let scene = if kind == "rasters" { "street.toml" } else { &scene };
        let command = format!("energyplus box.idf --quality draft --scene {scene} --at {place} -o {kind}");
        let output = done(&folder, &command);
        let text = fs::read_to_string(folder.path(kind).join("model.idf")).expect("a model");
        let shades = text.matches("Shading:Site:Detailed,").count();
        println!("{kind}: {shades} shades");
        assert!(shades > 8, "{kind}: {shades}: {}", stderr(&output));
    }
}

/// Writes an Esri ASCII grid of 20 x 20 cells of 2 m, by the height of a column and row.
fn grid(folder: &Folder, name: &str, height: impl Fn(usize, usize) -> f64) {
    let line = |row: usize| (0..20).map(|column| format!("{} ", height(column, row))).collect::<String>() + "\n";
    let cells: String = (0..20).map(line).collect();
    folder.write(name, &format!("ncols 20\nnrows 20\nxllcorner 0\nyllcorner 0\ncellsize 2\n{cells}"));
}

/// A crown of 10 x 10 m, 8 m high with 2 m of trunk, stands at the east wall of a block of 10 m: 15
/// of the 25 receivers on this wall are in the crown, and `receivers` and `run` say so once if its
/// faces dim the light; a volume of leaves may hold them. Of 4 points in a forest of ground and
/// this crown alone, 1 is inside, the others below, beside, above.
#[test]
fn receivers_in_crowns_are_counted() {
    let folder = Folder::new();
    let is_in =
        |column: usize, row: usize, first: usize| (first..first + 5).contains(&column) && (5..10).contains(&row);
    grid(&folder, "dem.asc", |_, _| 0.0);
    grid(&folder, "dsm.asc", |column, row| if is_in(column, row, 5) { 10.0 } else { 0.0 });
    grid(&folder, "chm.asc", |column, row| if is_in(column, row, 10) { 8.0 } else { 0.0 });
    let points = ["in,25,25,5", "below,25,25,1", "beside,35,25,5", "above,25,25,9"].map(|row| format!("{row},0,0,1\n"));
    folder.write("points.csv", &format!("receiver,x,y,z,nx,ny,nz\n{}", points.concat()));
    folder.write("faces.toml", "[canopy]\ntransmittance = 0.17\n");
    let city = "--dsm dsm.asc --dem dem.asc --canopy chm.asc --spacing 2m -m faces.toml";
    let weather = golden().display().to_string();
    for (command, said) in [
        (format!("receivers {city} -o walls.csv"), "15 receivers stand in closed hulls"),
        (format!("run {city} -w {weather} --quality draft -o walls"), "15 receivers stand in closed hulls"),
        (
            "build --dem dem.asc --canopy chm.asc -m faces.toml -r points.csv --quality draft -o forest.helio"
                .to_owned(),
            "1 receiver stands in the closed hull",
        ),
    ] {
        let text = stderr(&done(&folder, &command));
        assert_eq!((text.matches("closed hull").count(), text.contains(said)), (1, true), "{command}: {text}");
        let leaves = command
            .replace(" -m faces.toml", "")
            .replace("forest.helio", "leaves.helio")
            .replace("-o walls", "-o leaves");
        assert!(!stderr(&done(&folder, &leaves)).contains("closed hull"), "{leaves}");
    }
}
