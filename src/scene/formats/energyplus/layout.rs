//! Field order of the EnergyPlus classes that are read. In: a class name and a version. Out: the
//! keys of its fields.
//!
//! Keys and order follow EnergyPlus' Input Output Reference 25.2 (keys as epJSON spells them), and
//! its chapters "What's changed" for older files.

use crate::model_version::ModelVersion;

/// First version with spaces: surfaces name one between zone and boundary.
const SPACES_SINCE: ModelVersion = ModelVersion { major: 9, minor: 6 };
/// First version whose windows no longer name their shading control.
const NO_SHADING_CONTROL_SINCE: ModelVersion = ModelVersion { major: 9, minor: 0 };

/// Fields of a class.
#[derive(Debug)]
pub(super) struct Layout {
    pub class: &'static str,
    /// Keys in IDF order. `+` marks a field that was added with spaces, `-` one that was removed
    /// with the shading control.
    fields: &'static [&'static str],
    /// True if vertices follow the fields, three numbers each.
    pub has_vertices: bool,
}

impl Layout {
    /// Returns the layout of a class, whose name may be in any case.
    pub(super) fn of_class(class: &str) -> Option<&'static Layout> {
        LAYOUTS.iter().find(|layout| layout.class.eq_ignore_ascii_case(class))
    }

    /// Returns the keys in the order of an IDF file of a version.
    pub(super) fn order(&self, version: ModelVersion) -> Vec<&'static str> {
        let key = |field: &&'static str| match (field.strip_prefix('+'), field.strip_prefix('-')) {
            (Some(key), _) => (version >= SPACES_SINCE).then_some(key),
            (_, Some(key)) => (version < NO_SHADING_CONTROL_SINCE).then_some(key),
            (None, None) => Some(*field),
        };
        self.fields.iter().filter_map(key).collect()
    }

    /// Returns the static form of a key; `None` if the class has no such field.
    pub(super) fn key(&self, key: &str) -> Option<&'static str> {
        self.fields.iter().map(|field| field.trim_start_matches(['+', '-'])).find(|known| *known == key)
    }

    /// Returns true if objects have names of their own, which epJSON uses as keys.
    pub(super) fn is_named(&self) -> bool {
        self.fields.first() == Some(&"name")
    }
}

macro_rules! layouts {
    ($($class:literal $($vertices:ident)? : $($field:literal)*;)*) => {
        &[$(Layout { class: $class, fields: &[$($field),*], has_vertices: false $(|| stringify!($vertices).len() > 0)? }),*]
    };
}

#[rustfmt::skip]
const LAYOUTS: &[Layout] = layouts! {
    "Version": "version_identifier";
    "Building": "name" "north_axis";
    "GlobalGeometryRules": "starting_vertex_position" "vertex_entry_direction" "coordinate_system"
        "daylighting_reference_point_coordinate_system" "rectangular_surface_coordinate_system";
    "GeometryTransform": "plane_of_transform";
    "Site:Location": "name" "latitude" "longitude";
    "Site:GroundReflectance": "january_ground_reflectance" "february_ground_reflectance" "march_ground_reflectance"
        "april_ground_reflectance" "may_ground_reflectance" "june_ground_reflectance" "july_ground_reflectance"
        "august_ground_reflectance" "september_ground_reflectance" "october_ground_reflectance" "november_ground_reflectance"
        "december_ground_reflectance";
    "Site:GroundReflectance:SnowModifier": "ground_reflected_solar_modifier";
    "Zone": "name" "direction_of_relative_north" "x_origin" "y_origin" "z_origin" "type" "multiplier";

    "BuildingSurface:Detailed" vertices: "name" "surface_type" "construction_name" "zone_name" "+space_name"
        "outside_boundary_condition" "outside_boundary_condition_object" "sun_exposure" "wind_exposure" "view_factor_to_ground"
        "number_of_vertices";
    "Wall:Detailed" vertices: "name" "construction_name" "zone_name" "+space_name" "outside_boundary_condition"
        "outside_boundary_condition_object" "sun_exposure" "wind_exposure" "view_factor_to_ground" "number_of_vertices";
    "RoofCeiling:Detailed" vertices: "name" "construction_name" "zone_name" "+space_name" "outside_boundary_condition"
        "outside_boundary_condition_object" "sun_exposure" "wind_exposure" "view_factor_to_ground" "number_of_vertices";
    "Floor:Detailed" vertices: "name" "construction_name" "zone_name" "+space_name" "outside_boundary_condition"
        "outside_boundary_condition_object" "sun_exposure" "wind_exposure" "view_factor_to_ground" "number_of_vertices";
    "FenestrationSurface:Detailed": "name" "surface_type" "construction_name" "building_surface_name"
        "outside_boundary_condition_object" "view_factor_to_ground" "-shading_control_name" "frame_and_divider_name" "multiplier"
        "number_of_vertices" "vertex_1_x_coordinate" "vertex_1_y_coordinate" "vertex_1_z_coordinate" "vertex_2_x_coordinate"
        "vertex_2_y_coordinate" "vertex_2_z_coordinate" "vertex_3_x_coordinate" "vertex_3_y_coordinate" "vertex_3_z_coordinate"
        "vertex_4_x_coordinate" "vertex_4_y_coordinate" "vertex_4_z_coordinate";

    "Wall:Exterior": "name" "construction_name" "zone_name" "+space_name" "azimuth_angle" "tilt_angle"
        "starting_x_coordinate" "starting_y_coordinate" "starting_z_coordinate" "length" "height";
    "Wall:Adiabatic": "name" "construction_name" "zone_name" "+space_name" "azimuth_angle" "tilt_angle"
        "starting_x_coordinate" "starting_y_coordinate" "starting_z_coordinate" "length" "height";
    "Wall:Underground": "name" "construction_name" "zone_name" "+space_name" "azimuth_angle" "tilt_angle"
        "starting_x_coordinate" "starting_y_coordinate" "starting_z_coordinate" "length" "height";
    "Wall:Interzone": "name" "construction_name" "zone_name" "+space_name" "outside_boundary_condition_object"
        "azimuth_angle" "tilt_angle" "starting_x_coordinate" "starting_y_coordinate" "starting_z_coordinate" "length" "height";
    "Roof": "name" "construction_name" "zone_name" "+space_name" "azimuth_angle" "tilt_angle" "starting_x_coordinate"
        "starting_y_coordinate" "starting_z_coordinate" "length" "width";
    "Ceiling:Adiabatic": "name" "construction_name" "zone_name" "+space_name" "azimuth_angle" "tilt_angle"
        "starting_x_coordinate" "starting_y_coordinate" "starting_z_coordinate" "length" "width";
    "Ceiling:Interzone": "name" "construction_name" "zone_name" "+space_name" "outside_boundary_condition_object"
        "azimuth_angle" "tilt_angle" "starting_x_coordinate" "starting_y_coordinate" "starting_z_coordinate" "length" "width";
    "Floor:GroundContact": "name" "construction_name" "zone_name" "+space_name" "azimuth_angle" "tilt_angle"
        "starting_x_coordinate" "starting_y_coordinate" "starting_z_coordinate" "length" "width";
    "Floor:Adiabatic": "name" "construction_name" "zone_name" "+space_name" "azimuth_angle" "tilt_angle"
        "starting_x_coordinate" "starting_y_coordinate" "starting_z_coordinate" "length" "width";
    "Floor:Interzone": "name" "construction_name" "zone_name" "+space_name" "outside_boundary_condition_object"
        "azimuth_angle" "tilt_angle" "starting_x_coordinate" "starting_y_coordinate" "starting_z_coordinate" "length" "width";
    "Window": "name" "construction_name" "building_surface_name" "-shading_control_name" "frame_and_divider_name"
        "multiplier" "starting_x_coordinate" "starting_z_coordinate" "length" "height";
    "GlazedDoor": "name" "construction_name" "building_surface_name" "-shading_control_name" "frame_and_divider_name"
        "multiplier" "starting_x_coordinate" "starting_z_coordinate" "length" "height";
    "Door": "name" "construction_name" "building_surface_name" "multiplier" "starting_x_coordinate"
        "starting_z_coordinate" "length" "height";
    "Window:Interzone": "name";
    "GlazedDoor:Interzone": "name";
    "Door:Interzone": "name";

    "Shading:Site": "name" "azimuth_angle" "tilt_angle" "starting_x_coordinate" "starting_y_coordinate"
        "starting_z_coordinate" "length" "height";
    "Shading:Building": "name" "azimuth_angle" "tilt_angle" "starting_x_coordinate" "starting_y_coordinate"
        "starting_z_coordinate" "length" "height";
    "Shading:Site:Detailed" vertices: "name" "transmittance_schedule_name" "number_of_vertices";
    "Shading:Building:Detailed" vertices: "name" "transmittance_schedule_name" "number_of_vertices";
    "Shading:Zone:Detailed" vertices: "name" "base_surface_name" "transmittance_schedule_name" "number_of_vertices";
    "Shading:Overhang": "name" "window_or_door_name" "height_above_window_or_door" "tilt_angle_from_window_door"
        "left_extension_from_window_door_width" "right_extension_from_window_door_width" "depth";
    "Shading:Overhang:Projection": "name" "window_or_door_name" "height_above_window_or_door" "tilt_angle_from_window_door"
        "left_extension_from_window_door_width" "right_extension_from_window_door_width"
        "depth_as_fraction_of_window_door_height";
    "Shading:Fin": "name" "window_or_door_name" "left_extension_from_window_door" "left_distance_above_top_of_window"
        "left_distance_below_bottom_of_window" "left_tilt_angle_from_window_door" "left_depth"
        "right_extension_from_window_door" "right_distance_above_top_of_window" "right_distance_below_bottom_of_window"
        "right_tilt_angle_from_window_door" "right_depth";
    "Shading:Fin:Projection": "name" "window_or_door_name" "left_extension_from_window_door"
        "left_distance_above_top_of_window" "left_distance_below_bottom_of_window" "left_tilt_angle_from_window_door"
        "left_depth_as_fraction_of_window_door_width" "right_extension_from_window_door" "right_distance_above_top_of_window"
        "right_distance_below_bottom_of_window" "right_tilt_angle_from_window_door"
        "right_depth_as_fraction_of_window_door_width";
    "ShadingProperty:Reflectance": "shading_surface_name" "diffuse_solar_reflectance_of_unglazed_part_of_shading_surface"
        "diffuse_visible_reflectance_of_unglazed_part_of_shading_surface" "fraction_of_shading_surface_that_is_glazed"
        "glazing_construction_name";
    "Schedule:Constant": "name" "schedule_type_limits_name" "hourly_value";

    "Construction": "name" "outside_layer" "layer_2" "layer_3" "layer_4" "layer_5" "layer_6" "layer_7" "layer_8" "layer_9"
        "layer_10";
    "Construction:CfactorUndergroundWall": "name";
    "Construction:FfactorGroundFloor": "name";
    "Material": "name" "roughness" "thickness" "conductivity" "density" "specific_heat" "thermal_absorptance"
        "solar_absorptance" "visible_absorptance";
    "Material:NoMass": "name" "roughness" "thermal_resistance" "thermal_absorptance" "solar_absorptance"
        "visible_absorptance";
    "Material:AirGap": "name";
    "Material:InfraredTransparent": "name";
    "Material:RoofVegetation": "name" "height_of_plants" "leaf_area_index" "leaf_reflectivity";
    "WindowMaterial:Glazing": "name" "optical_data_type" "window_glass_spectral_data_set_name" "thickness"
        "solar_transmittance_at_normal_incidence" "front_side_solar_reflectance_at_normal_incidence"
        "back_side_solar_reflectance_at_normal_incidence";
    "WindowMaterial:Glazing:RefractionExtinctionMethod": "name" "thickness" "solar_index_of_refraction"
        "solar_extinction_coefficient";
    "WindowMaterial:GlazingGroup:Thermochromic": "name";
    "WindowMaterial:SimpleGlazingSystem": "name" "u_factor";
};
