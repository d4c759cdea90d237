//! Injection of light into a model. In: its surfaces with their light. Out: tables, sensors,
//! actuators and programs among its objects, and a solar distribution without EnergyPlus's own
//! reflections.

use super::document::{Document, ModelObject};
use super::erl::{Names, SENSORS, SHARED, SurfaceTerms, TABLES, sun_program, surface_lines};
use super::new_object::{FieldValue, NewObject};
use super::sun_tables::{GroundLine, NOMINAL_W_M2, ReflectedSky, SurfaceLight};
use heliotile_core::error::Result;
use heliotile_core::replay::factors::SunGrid;
use heliotile_core::site::ground::MonthlyGround;
use heliotile_core::text::Message;
use heliotile_scene::{GROUND_MONTHS, USUAL_GROUND};

/// Sun tables below this everywhere are not written, W/m2 under 1000 W/m2.
const NOTHING_W_M2: f64 = 0.005;

/// Decimals of table values in W/m2.
const DECIMALS: usize = 3;

/// Surfaces in one program; below, programs that one calling manager runs. EnergyPlus reads 500
/// lines and 25 programs.
const PROGRAM_SURFACES: usize = 60;
const MANAGER_PROGRAMS: usize = 20;

/// Reflectance that a month without ground reflectance is set to: the actuator multiplies the
/// ground's light, so there must be some.
pub const MIN_GROUND: f64 = 0.01;

/// Field number and key of the solar distribution of a `Building`.
pub const DISTRIBUTION: (usize, &str) = (6, "solar_distribution");

/// Distributions with EnergyPlus's own reflections, each with its counterpart without them.
pub const WITH_OWN: [(&str, &str); 2] = [
    ("FullExteriorWithReflections", "FullExterior"),
    ("FullInteriorAndExteriorWithReflections", "FullInteriorAndExterior"),
];

/// Light to inject, and the surfaces that get it.
pub struct Injection<'a> {
    pub grid: SunGrid,
    pub sky: ReflectedSky,
    pub lights: &'a [SurfaceLight],
    /// Names of EnergyPlus's surfaces, each with the number of its light; a surface without a
    /// number gets none.
    pub targets: &'a [(String, Option<usize>)],
}

/// Summary of the changes to a model.
#[derive(Debug, Default)]
pub struct Changed {
    /// Sentences for the report.
    pub notes: Vec<Message>,
    pub tables: usize,
}

/// Returns the ground as the model states it; its material has no name.
pub fn ground_of(document: &Document) -> MonthlyGround {
    let object = document.of("Site:GroundReflectance").next();
    let mut reflectance = [USUAL_GROUND; 12];
    for ((place, key), value) in GROUND_MONTHS.into_iter().enumerate().zip(&mut reflectance) {
        let stated = object.and_then(|object| object.text(place + 1, key).parse::<f64>().ok());
        *value = stated.filter(|value| (0.0..=1.0).contains(value)).unwrap_or(USUAL_GROUND);
    }
    let modifier = document.first_text("Site:GroundReflectance:SnowModifier", 1, "ground_reflected_solar_modifier");
    let modifier = modifier.parse::<f64>().ok().filter(|value| value.is_finite());
    MonthlyGround { material: String::new(), reflectance, snow_modifier: modifier.unwrap_or(1.0).max(0.0) }
}

/// Writes all objects of an injection into the model.
pub fn write(document: &mut Document, injection: &Injection) -> Result<Changed> {
    let mut changed = Changed::default();
    changed.notes.extend(switch_distribution(document)?.into_iter().map(Message::from));
    // The actuator multiplies the ground's light, so the ground must reflect something.
    let bare = brighten_ground(document, &mut changed.notes)?;
    let names = Names::free(document.objects.iter().map(ModelObject::name));
    write_site(document, &names);
    write_suns(document, injection.grid, &names, "Sun");
    let is_worth = |values: &Vec<f64>| values.iter().any(|value| value.abs() >= NOTHING_W_M2);
    if injection.lights.iter().any(|light| is_worth(&light.mirrored)) {
        write_suns(document, SunGrid::FINE, &names, "FineSun");
    }
    let mut has = Vec::new();
    for (number, light) in injection.lights.iter().enumerate() {
        let tables = [&light.sun.fixed, &light.sun.by_ground, &light.mirrored];
        let worth = tables.map(is_worth);
        for ((letter, values), _) in TABLES.into_iter().zip(tables).zip(worth).filter(|(_, worth)| *worth) {
            let name = names.of(&format!("{letter}{}", number + 1));
            let table = names.of(&format!("Table_{letter}{}", number + 1));
            let suns = names.of(if letter == TABLES[2] { "FineSun" } else { "Sun" });
            let fields = [("independent_variable_list_name", suns)];
            let mut lookup = NewObject::new("Table:Lookup", &table, &fields.each_ref().map(|(k, v)| (*k, v.as_str())));
            lookup.fields.push(("normalization_method", FieldValue::Text("None".into())));
            for blank in [
                "normalization_divisor",
                "minimum_output",
                "maximum_output",
                "output_unit_type",
                "external_file_name",
                "external_file_column_number",
                "external_file_starting_row_number",
            ] {
                lookup.fields.push((blank, FieldValue::Nothing));
            }
            let values = values.iter().map(|value| FieldValue::number(*value, DECIMALS)).collect();
            document.add(lookup.with_list("values", &["output_value"], values));
            document.add(NewObject::new(
                "EnergyManagementSystem:CurveOrTableIndexVariable",
                name,
                &[("curve_or_table_object_name", &table)],
            ));
            changed.tables += 1;
        }
        has.push(worth);
    }
    write_programs(document, injection, &names, &has, &bare);
    Ok(changed)
}

/// Writes the axes of tables: azimuth, altitude, and the list of both.
fn write_suns(document: &mut Document, grid: SunGrid, names: &Names, list: &str) {
    for (name, values) in [("Azimuth", grid.azimuths_deg()), ("Altitude", grid.altitudes_deg())] {
        let (first, last) = (values.first().copied().unwrap_or_default(), values.last().copied().unwrap_or_default());
        let mut axis = NewObject::new(
            "Table:IndependentVariable",
            names.of(&format!("{list}_{name}")),
            &[("interpolation_method", "Linear"), ("extrapolation_method", "Constant")],
        );
        axis.fields.extend([
            ("minimum_value", FieldValue::number(first, 4)),
            ("maximum_value", FieldValue::number(last, 4)),
            ("normalization_reference_value", FieldValue::Nothing),
            ("unit_type", FieldValue::Text("Angle".into())),
            ("external_file_name", FieldValue::Nothing),
            ("external_file_column_number", FieldValue::Nothing),
            ("external_file_starting_row_number", FieldValue::Nothing),
        ]);
        let values = values.iter().map(|value| FieldValue::number(*value, 4)).collect();
        document.add(axis.with_list("values", &["value"], values));
    }
    let axes = ["Azimuth", "Altitude"].map(|axis| FieldValue::Text(names.of(&format!("{list}_{axis}"))));
    document.add(NewObject::new("Table:IndependentVariableList", names.of(list), &[]).with_list(
        "independent_variables",
        &["independent_variable_name"],
        axes.to_vec(),
    ));
}

/// Writes the sensors of the site, and the variables that programs share.
fn write_site(document: &mut Document, names: &Names) {
    for (name, output) in SENSORS {
        document.add(NewObject::sensor(names.of(name), "Environment", output));
    }
    let shared = SHARED.map(|name| FieldValue::Text(names.of(name)));
    let mut list = NewObject::new("EnergyManagementSystem:GlobalVariable", names.of("Shared"), &[]).nameless();
    list = list.with_list("variables", &["erl_variable_name"], shared.to_vec());
    document.add(list);
}

/// Writes actuators, and the programs that set them.
fn write_programs(document: &mut Document, injection: &Injection, names: &Names, has: &[[bool; 3]], bare: &[usize]) {
    let mut programs = vec![(names.of("Prepare"), sun_program(names, injection.sky, bare))];
    for (i, (surface, number)) in injection.targets.iter().enumerate() {
        let name = names.of(&format!("A{}", i + 1));
        document.add(NewObject::actuator(name, surface, "Surface", "View Factor To Ground"));
        let light = number.and_then(|number| injection.lights.get(number));
        let sky = |line: &GroundLine| [&line.fixed, &line.by_ground].map(|v| v.first().copied().unwrap_or_default());
        let terms = SurfaceTerms {
            actuator: i + 1,
            tables: number.map_or(0, |number| number + 1),
            has: number.and_then(|number| has.get(number)).copied().unwrap_or_default(),
            sky: light.map_or([0.0; 2], |light| sky(&light.sky)).map(|value| value / NOMINAL_W_M2),
            horizon: light.map_or([0.0; 2], |light| sky(&light.horizon)).map(|value| value / NOMINAL_W_M2),
        };
        extend_programs(&mut programs, names, i, surface_lines(names, &terms));
    }
    add_programs(document, names, programs);
}

/// Adds the lines of a surface to the last program, or to a new one if that is full.
pub fn extend_programs(
    programs: &mut Vec<(String, Vec<String>)>,
    names: &Names,
    surface: usize,
    lines: impl IntoIterator<Item = String>,
) {
    if surface.is_multiple_of(PROGRAM_SURFACES) {
        programs.push((names.of(&format!("Surfaces{}", surface / PROGRAM_SURFACES + 1)), Vec::new()));
    }
    if let Some((_, all)) = programs.last_mut() {
        all.extend(lines);
    }
}

/// Adds programs, and the managers that call them in each time step.
pub fn add_programs(document: &mut Document, names: &Names, programs: Vec<(String, Vec<String>)>) {
    for (number, some) in programs.chunks(MANAGER_PROGRAMS).enumerate() {
        let listed = some.iter().map(|(name, _)| FieldValue::Text(name.clone())).collect();
        let manager = names.of(&format!("Manager{}", number + 1));
        let point = [("energyplus_model_calling_point", "BeginZoneTimestepBeforeInitHeatBalance")];
        document.add(NewObject::new("EnergyManagementSystem:ProgramCallingManager", manager, &point).with_list(
            "programs",
            &["program_name"],
            listed,
        ));
    }
    for (name, lines) in programs {
        let lines = lines.into_iter().map(FieldValue::Text).collect();
        let program = NewObject::new("EnergyManagementSystem:Program", name, &[]);
        document.add(program.with_list("lines", &["program_line"], lines));
    }
}

/// Switches EnergyPlus's own reflections off, which would make the injected light ineffective.
/// Returns a note about the change.
pub fn switch_distribution(document: &mut Document) -> Result<Option<String>> {
    let (place, key) = DISTRIBUTION;
    let stated = document.first_text("Building", place, key).to_owned();
    if stated.eq_ignore_ascii_case("MinimalShadowing") {
        let note = "solar distribution stays MinimalShadowing: in EnergyPlus, neighbours do not shade direct light";
        return Ok(Some(note.into()));
    }
    let Some((_, now)) = WITH_OWN.into_iter().find(|(with, _)| stated.eq_ignore_ascii_case(with)) else {
        return Ok(None);
    };
    document.set("Building", place, key, now)?;
    Ok(Some(format!("solar distribution {stated} became {now}: EnergyPlus's own reflections are off")))
}

/// Sets months without ground reflectance to [`MIN_GROUND`]; the programs subtract its light
/// again. Returns these months, from 1.
pub fn brighten_ground(document: &mut Document, notes: &mut Vec<Message>) -> Result<Vec<usize>> {
    let mut bare = Vec::new();
    for ((month, value), key) in ground_of(document).reflectance.into_iter().enumerate().zip(GROUND_MONTHS) {
        if value == 0.0 {
            document.set("Site:GroundReflectance", month + 1, key, &MIN_GROUND.to_string())?;
            bare.push(month + 1);
        }
    }
    if !bare.is_empty() {
        notes.push(format!(
            "the ground reflects nothing in {} of 12 months: its reflectance is set to {MIN_GROUND} there, because injected light is a \
             multiple of the ground's light; the programs subtract the ground's own light",
            bare.len()
        ).into());
    }
    Ok(bare)
}
