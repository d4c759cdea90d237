//! One weather in many layouts, for tests. In: two clear days by formula at 40 N, 105 W. Out: files
//! in the layouts of services, programs and people.

use serde_json::json;

use heliotile_core::weather::options::{DateOrder, StampedAt, TimeShift, WeatherOptions};
use heliotile_core::weather::time::calendar::Date;
use heliotile_core::weather::time::clock_zone::ClockZone;
use heliotile_core::weather::time::sun::{Interval, Location};

/// One hour of the made weather, by the clock of UTC-7.
#[derive(Clone, Copy)]
pub struct Hour {
    pub day: u32,
    pub hour: u32,
    pub ghi: f64,
    pub dni: f64,
    pub dhi: f64,
}

impl Hour {
    /// Returns the seconds after 1970 in UTC, `minutes` minutes after the start of the hour.
    pub fn unix(self, minutes: i64) -> i64 {
        1_622_530_800 + i64::from((self.day - 1) * 24 + self.hour) * 3600 + minutes * 60
    }

    /// Returns `YYYY-MM-DDTHH:MM` of a clock ahead of UTC, `minutes` minutes after the start of the
    /// hour.
    pub fn iso(self, zone_hours: i64, minutes: i64) -> String {
        let (date, after) = Date::OF_DAY_0.after((self.unix(minutes) + zone_hours * 3600) as f64 / 60.0);
        date.label(after as u32)
    }

    pub fn light(self, each: impl Fn(f64) -> String) -> String {
        [self.ghi, self.dni, self.dhi].map(each).join(",")
    }
}

/// Returns 1 and 2 June 2021 from 00:00 to 24:00 of UTC-7: DNI of a clear sky by the height of the
/// sun, DHI of 100 W/m2 by day.
pub fn hours() -> Vec<Hour> {
    let site = Location::new(40.0, -105.0, -7.0, 1600.0).expect("a site");
    let of = |(day, hour): (u32, u32)| {
        let date = Date::new(2021, 6, day).expect("a date");
        let start_min = f64::from(60 * hour);
        let interval = Interval { date, start_min, end_min: start_min + 60.0 };
        let middle = site.sun(date, start_min + 30.0);
        let suns = site.sunlit(&interval, middle.into(), 60);
        let cosine = suns.iter().map(|sun| sun.z).sum::<f64>() / suns.len().max(1) as f64;
        let dni = if cosine > 0.05 { 950.0 * (-0.16 / cosine).exp() } else { 0.0 };
        let dhi = if cosine > 0.05 { 100.0 } else { 0.0 };
        Hour { day, hour, ghi: dhi + dni * cosine, dni, dhi }
    };
    (1..=2).flat_map(|day| (0..24).map(move |hour| (day, hour))).map(of).collect()
}

pub const AT_PLACE: WeatherOptions = WeatherOptions {
    latitude_deg: Some(40.0),
    longitude_deg: Some(-105.0),
    zone: Some(ClockZone::Hours(-7.0)),
    shift: TimeShift::Minutes(0.0),
    stamped_at: None,
    date_order: None,
    with_air: false,
};

/// Options for files that state place and zone themselves.
pub const SILENT: WeatherOptions = WeatherOptions { latitude_deg: None, longitude_deg: None, zone: None, ..AT_PLACE };

/// Returns a table with a line for each hour.
pub fn table(head: &str, row: impl Fn(Hour) -> String) -> String {
    hours().into_iter().fold(format!("{head}\n"), |text, hour| text + &row(hour) + "\n")
}

pub fn plain(value: f64) -> String {
    format!("{value:.4}")
}

/// Returns hours of UTC by their start, with light in a unit of which `factor` are one W/m2.
pub fn in_unit(names: &str, factor: f64) -> String {
    table(names, |hour| format!("{}Z,{}", hour.iso(0, 0), hour.light(|value| format!("{:.6}", value * factor))))
}

fn open_meteo_csv() -> String {
    let head = "latitude,longitude,elevation,utc_offset_seconds,timezone,timezone_abbreviation\n40.0,-105.0,1600.0,0,GMT,GMT\n\n\
                time,shortwave_radiation (W/m²),direct_radiation (W/m²),diffuse_radiation (W/m²),direct_normal_irradiance (W/m²)";
    let rows = table(head, |hour| {
        let [ghi, dni, dhi] = [hour.ghi, hour.dni, hour.dhi];
        format!("{},{ghi:.3},{:.3},{dhi:.3},{dni:.3}", hour.iso(0, 60), ghi - dhi)
    });
    format!("{rows}\ntime,sunrise (iso8601)\n2021-06-01,2021-06-01T11:30\n")
}

pub fn open_meteo_json(times: impl Fn(Hour) -> serde_json::Value, time_unit: &str) -> String {
    let column = |of: fn(Hour) -> f64| hours().into_iter().map(of).collect::<Vec<f64>>();
    let unit = "W/m²";
    json!({
        "latitude": 40.0, "longitude": -105.0, "elevation": 1600.0, "utc_offset_seconds": 0, "timezone": "GMT",
        "hourly_units": {"time": time_unit, "shortwave_radiation": unit, "diffuse_radiation": unit, "direct_normal_irradiance": unit},
        "hourly": {
            "time": hours().into_iter().map(times).collect::<Vec<_>>(), "shortwave_radiation": column(|hour| hour.ghi),
            "diffuse_radiation": column(|hour| hour.dhi), "direct_normal_irradiance": column(|hour| hour.dni),
        },
    })
    .to_string()
}

fn compact(stamp: &str, clock: bool) -> String {
    let digits: String = stamp.chars().filter(char::is_ascii_digit).collect();
    if clock { format!("{}:{}", &digits[..8], &digits[8..]) } else { digits[..10].to_owned() }
}

fn pvgis_csv() -> String {
    let head = "Latitude (decimal degrees): 40.000\nLongitude (decimal degrees): -105.000\nElevation (m): 1600\n\n\
                time(UTC),T2m,G(h),Gb(n),Gd(h)";
    table(head, |hour| format!("{},15,{}", compact(&hour.iso(0, 30), true), hour.light(plain))) + "\nT2m: air\n"
}

fn pvgis_json() -> String {
    let row = |hour: Hour| json!({"time(UTC)": compact(&hour.iso(0, 30), true), "T2m": 15.0, "G(h)": hour.ghi, "Gb(n)": hour.dni, "Gd(h)": hour.dhi});
    json!({
        "inputs": {"location": {"latitude": 40.0, "longitude": -105.0, "elevation": 1600.0}},
        "outputs": {"months_selected": [{"month": 6, "year": 2021}], "tmy_hourly": hours().into_iter().map(row).collect::<Vec<_>>()},
        "meta": {},
    })
    .to_string()
}

pub fn nasa_csv(zone: &str, zone_hours: i64) -> String {
    let head = format!(
        "-BEGIN HEADER-\nNASA/POWER CERES/MERRA2 Native Resolution Hourly Data \n\
         Dates (month/day/year): 06/01/2021 through 06/02/2021 in {zone}\nLocation: Latitude  40.0   Longitude -105.0 \n\
         Elevation from MERRA-2: Average for 0.5 x 0.625 degree lat/lon region = 1600.0 meters\n\
         The value for missing source data that cannot be computed or is outside of the sources availability range: -999 \n\
         Parameter(s): \nALLSKY_SFC_SW_DWN     CERES SYN1deg All Sky Surface Shortwave Downward Irradiance (Wh/m^2) \n\
         ALLSKY_SFC_SW_DNI     CERES SYN1deg All Sky Surface Shortwave Downward Direct Normal Irradiance (Wh/m^2) \n\
         ALLSKY_SFC_SW_DIFF    CERES SYN1deg All Sky Surface Shortwave Diffuse Irradiance (Wh/m^2) \n-END HEADER-\n\
         YEAR,MO,DY,HR,ALLSKY_SFC_SW_DWN,ALLSKY_SFC_SW_DNI,ALLSKY_SFC_SW_DIFF"
    );
    table(&head, |hour| {
        let stamp = hour.iso(zone_hours, 0);
        let parts = [&stamp[..4], &stamp[5..7], &stamp[8..10], &stamp[11..13]];
        let parts = parts.map(|part| part.trim_start_matches('0')).map(|part| if part.is_empty() { "0" } else { part });
        format!("{},{}", parts.join(","), hour.light(plain))
    })
}

fn nasa_json(unit: &str, factor: f64) -> String {
    let column = |of: fn(Hour) -> f64| {
        let cell = |hour: Hour| (compact(&hour.iso(0, 0), false), json!(of(hour) * factor));
        serde_json::Value::Object(hours().into_iter().map(cell).collect())
    };
    let units = json!({"units": unit});
    json!({
        "type": "Feature", "geometry": {"type": "Point", "coordinates": [-105.0, 40.0, 1600.0]},
        "properties": {"parameter": {
            "ALLSKY_SFC_SW_DWN": column(|hour| hour.ghi), "ALLSKY_SFC_SW_DNI": column(|hour| hour.dni),
            "ALLSKY_SFC_SW_DIFF": column(|hour| hour.dhi),
        }},
        "header": {"title": "NASA/POWER", "fill_value": -999.0, "time_standard": "UTC"},
        "parameters": {"ALLSKY_SFC_SW_DWN": units, "ALLSKY_SFC_SW_DNI": units, "ALLSKY_SFC_SW_DIFF": units},
    })
    .to_string()
}

const SOLARGIS: &str = "#SOLARGIS TIME SERIES\n#\n#Site name: Town\n#Latitude: 40.000000\n#Longitude: -105.000000\n\
                        #Elevation: 1600.0 m a.s.l.\n#\n#Columns:\n#Date - Date of measurement, format DD.MM.YYYY\n\
                        #Time - Time of measurement, time reference UTC-7, time step 60 min, time format HH:MM\n\
                        #GHI - Global horizontal irradiation [Wh/m2], no data value -9\n\
                        #DNI - Direct normal irradiation [Wh/m2], no data value -9\n\
                        #DIF - Diffuse horizontal irradiation [Wh/m2], no data value -9\n#\n#Data:\n";

fn solargis() -> String {
    table(&format!("{SOLARGIS}Date;Time;GHI;DNI;DIF;flagR"), |hour| {
        format!("{:02}.06.2021;{:02}:30;{:.3};{:.3};{:.3};1", hour.day, hour.hour, hour.ghi, hour.dni, hour.dhi)
    })
}

fn solargis_typical() -> String {
    table(&format!("{SOLARGIS}Day;Time;GHI;DNI;DIF"), |hour| {
        format!("{};{:02}:30;{:.3};{:.3};{:.3}", 151 + hour.day, hour.hour, hour.ghi, hour.dni, hour.dhi)
    })
}

fn pvsyst() -> String {
    let head = "#Meteo hourly data;;\n#Site;Town;\n#Country;USA;\n#Data Source;made;\n#Time step;Hour;\n#Latitude;40.0;\n#Longitude;-105.0;\n\
                #Altitude;1600;m\n#Time Zone;-7.00;\nYear;Month;Day;Hour;Minute;GHI;DHI;DNI;Tamb\n;;;;;W/m2;W/m2;W/m2;deg.C";
    table(head, |hour| {
        format!("2021;6;{};{};0;{:.3};{:.3};{:.3};15", hour.day, hour.hour, hour.ghi, hour.dhi, hour.dni)
    })
}

pub fn cams(reference: &str) -> String {
    let head = format!(
        "# Coding: utf-8\n# Title: CAMS Radiation Service v4.5 all-sky irradiation (derived from satellite data).\n\
         # Latitude (positive North, ISO 19115): 40.0000\n# Longitude (positive East, ISO 19115): -105.0000\n# Altitude (m): 1600.00\n\
         # Time reference: {reference}\n# Summarization (integration) period: 0 year 0 month 0 day 1 h 0 min 0 s\n# noValue: nan\n\
         # Columns:\n# 7. GHI. Global irradiation on horizontal plane at ground level (Wh/m2)\n\
         # Observation period;TOA;Clear sky GHI;GHI;BHI;DHI;BNI;Reliability"
    );
    table(&head, |hour| {
        let [start, end] = [hour.iso(0, 0), hour.iso(0, 60)];
        let beam = hour.ghi - hour.dhi;
        format!("{start}:00.0/{end}:00.0;1000;900;{:.4};{beam:.4};{:.4};{:.4};1.0", hour.ghi, hour.dhi, hour.dni)
    })
}

pub fn solar_anywhere(method: &str, minutes: i64) -> String {
    let head = format!(
        "0,Town,NA,-7,40.0,-105.0,1600,\"Data Version: 3.6 / Type: Timeseries / Time Resolution: 60 minutes{method} / TD: Yes\"\n\
         ObservationTime(LST),Global Horizontal Irradiance (GHI) W/m2,Direct Normal Irradiance (DNI) W/m2,AmbientTemperature (deg C),\
         Snow Depth (m),Clear Sky GHI,ObservationTime(GMT),Diffuse Horizontal Irradiance (DIF) W/m2,Albedo"
    );
    table(&head, |hour| {
        let american = |stamp: String| format!("{}/{}/{} {}", &stamp[5..7], &stamp[8..10], &stamp[..4], &stamp[11..]);
        let [local, utc] = [american(hour.iso(-7, minutes)), american(hour.iso(0, minutes))];
        format!("{local},{:.3},{:.3},15,0,900,{utc},{:.3},0.2", hour.ghi, hour.dni, hour.dhi)
    })
}

fn wea() -> String {
    let head =
        "place Town\nlatitude 40.00\nlongitude 105.00\ntime_zone 105\nsite_elevation 1600.0\nweather_data_file_units 1";
    table(head, |hour| format!("6 {} {}.500 {:.3} {:.3}", hour.day, hour.hour, hour.dni, hour.dhi))
}

fn tmy3() -> String {
    let head = "1,Town,NA,-7,40.0,-105.0,1600,\"made by hand, 60 minutes\",,\n\
                Date (MM/DD/YYYY),Time (HH:MM),GHI (W/m^2),DNI (W/m^2),DHI (W/m^2),x";
    table(head, |hour| format!("06/{:02}/2021,{:02}:00,{},0", hour.day, hour.hour + 1, hour.light(plain)))
}

fn epw() -> String {
    let head = "LOCATION,Town,-,XXX,Custom,999999,40.0,-105.0,-7,1600.0  Morphed:TAS|DWPT\nDESIGN CONDITIONS,0\nTYPICAL/EXTREME PERIODS,0\n\
                GROUND TEMPERATURES,0\nHOLIDAYS/DAYLIGHT SAVINGS,No,0,0,0\nCOMMENTS 1,made\nCOMMENTS 2,made\n\
                DATA PERIODS,1,1,Data,Tuesday,6/ 1,6/ 2";
    table(head, |hour| {
        let (clock, light) =
            (format!("0,6,{},{},0", hour.day, hour.hour + 1), [-99.0, hour.dni, hour.dhi].map(plain).join(","));
        format!(
            "{clock},?9,15.0,5.0,50,101000,0,0,300,{light},0,0,0,0,180,2,5,5,20,77777,9,999999999,10,0.1,0,88,0.2,0,1"
        )
    })
}

fn toa5() -> String {
    let head = "\"TOA5\",\"CR1000\",\"CR1000\",\"1234\",\"CR1000.Std.32\",\"CPU:a.CR1\",\"1\",\"Hour\"\n\
                \"TIMESTAMP\",\"RECORD\",\"GHI_Avg\",\"DNI_Avg\",\"DHI_Avg\"\n\"TS\",\"RN\",\"W/m^2\",\"W/m^2\",\"W/m^2\"\n\"\",\"\",\"Avg\",\"Avg\",\"Avg\"";
    table(head, |hour| format!("\"{}:00\",{},{}", hour.iso(-7, 60).replace('T', " "), hour.hour, hour.light(plain)))
}

pub fn nsrdb(zone: &str, zone_hours: i64, minutes: bool) -> String {
    let head = format!(
        "Source,Location ID,City,State,Country,Latitude,Longitude,Time Zone,Elevation,Local Time Zone\n\
         NSRDB,1,-,-,-,40.0,-105.0,{zone},1600,-7\nYear,Month,Day,Hour{},GHI,DNI,DHI",
        if minutes { ",Minute" } else { "" }
    );
    table(&head, |hour| {
        let stamp = hour.iso(zone_hours, 0);
        let minute = if minutes { ",30" } else { "" };
        format!("2021,{},{},{}{minute},{}", &stamp[5..7], &stamp[8..10], &stamp[11..13], hour.light(plain))
    })
}

fn records_json() -> String {
    let row = |hour: Hour| json!({"time": hour.iso(0, 0) + "Z", "ghi": hour.ghi, "dni": hour.dni, "dhi": hour.dhi});
    json!({"estimated_actuals": hours().into_iter().map(row).collect::<Vec<_>>()}).to_string()
}

fn columns_json() -> String {
    let column = |of: fn(Hour) -> serde_json::Value| {
        let cells = hours().into_iter().zip(0..).map(|(hour, row): (Hour, usize)| (row.to_string(), of(hour)));
        serde_json::Value::Object(cells.collect())
    };
    json!({
        "time": column(|hour| json!(hour.unix(0) * 1000)), "ghi (kW/m2)": column(|hour| json!(hour.ghi / 1000.0)),
        "dni (kW/m2)": column(|hour| json!(hour.dni / 1000.0)), "dhi (kW/m2)": column(|hour| json!(hour.dhi / 1000.0)),
    })
    .to_string()
}

fn lines_json() -> String {
    let row = |hour: Hour| {
        json!({"time": hour.iso(0, 0) + "Z", "ghi": hour.ghi, "dni": hour.dni, "dhi": hour.dhi}).to_string()
    };
    hours().into_iter().map(row).collect::<Vec<_>>().join("\n")
}

fn split_json() -> String {
    let row = |hour: Hour| json!([hour.iso(0, 0) + "Z", hour.ghi, hour.dni, hour.dhi]);
    json!({"columns": ["time", "ghi", "dni", "dhi"], "data": hours().into_iter().map(row).collect::<Vec<_>>()})
        .to_string()
}

/// A layout: its name, its bytes, and the options of the user.
pub type Layout = (&'static str, Vec<u8>, WeatherOptions);

pub fn units() -> Vec<Layout> {
    let joules = 3600.0;
    let named = [
        ("W/m2", "time,ghi,dni,dhi", 1.0),
        ("kW/m2 in brackets", "time,ghi (kW/m2),dni (kW/m2),dhi (kW/m2)", 1e-3),
        ("kW behind the name", "time,ghi_kw,dni_kw,dhi_kw", 1e-3),
        ("kWh/m2 behind the name", "time,ghi_kwh_m2,dni_kwh_m2,dhi_kwh_m2", 1e-3),
        ("Wh/m2", "time,GHI [Wh/m²],DNI [Wh/m²],DHI [Wh/m²]", 1.0),
        ("J/cm2", "time,ghi [J/cm2],dni [J/cm2],dhi [J/cm2]", joules / 1e4),
        ("kJ/m2", "time,ghi_kj_m2,dni_kj_m2,dhi_kj_m2", joules / 1e3),
        ("MJ/m2", "time,GHI (MJ m-2),DNI (MJ m-2),DHI (MJ m-2)", joules / 1e6),
        ("J/m2", "time,ghi (J m**-2),dni (J m**-2),dhi (J m**-2)", joules),
        ("langley", "time,ghi (langley),dni (langley),dhi (langley)", joules / 41_840.0),
        ("BTU/ft2", "time,ghi BTU/ft2,dni BTU/ft2,dhi BTU/ft2", 1.0 / 3.154_590_7),
        ("a row of units", "time,ghi,dni,dhi\n,kW/m2,kW/m2,kW/m2", 1e-3),
        ("a row of units in brackets", "time,GHI,DNI,DHI\nUTC,[J/cm²],[J/cm²],[J/cm²]", joules / 1e4),
    ];
    let mut all: Vec<Layout> =
        named.into_iter().map(|(name, names, factor)| (name, in_unit(names, factor).into_bytes(), AT_PLACE)).collect();
    let latin: Vec<u8> = in_unit("time,ghi (kW/m²),dni (kW/m²),dhi (kW/m²)", 1e-3).chars().map(|c| c as u8).collect();
    all.push(("Latin 1", latin, AT_PLACE));
    let wide = format!("\u{feff}{}", in_unit("time,ghi,dni,dhi", 1.0).replace(',', "\t"));
    all.push(("UTF-16", wide.encode_utf16().flat_map(u16::to_le_bytes).collect(), AT_PLACE));
    all
}

pub fn stamps() -> Vec<Layout> {
    let day = |stamp: &str, order: [std::ops::Range<usize>; 3], sign: &str| order.map(|part| &stamp[part]).join(sign);
    let dmy = [8..10, 5..7, 0..4];
    let mdy = [5..7, 8..10, 0..4];
    let twelve = |hour: u32| format!("{}:00 {}", (hour + 11) % 12 + 1, if hour < 12 { "AM" } else { "PM" });
    let local = |hour: Hour| hour.iso(-7, 0);
    let texts = [
        (
            "period_end and period, any order",
            table("dhi,period_end,ghi,period,dni", |hour| {
                format!("{:.4},{}:00Z,{:.4},PT60M,{:.4}", hour.dhi, hour.iso(0, 60), hour.ghi, hour.dni)
            }),
        ),
        (
            "PeriodStart and PeriodEnd",
            table("PeriodEnd,PeriodStart,Period,Ghi,Dni,Dhi", |hour| {
                format!("{}Z,{}Z,PT1H,{}", hour.iso(0, 60), hour.iso(0, 0), hour.light(plain))
            }),
        ),
        ("Period End", table("Period End,GHI,DNI,DHI", |hour| format!("{},{}", hour.iso(-7, 60), hour.light(plain)))),
        (
            "hours 1 to 24",
            table("year,month,day,hour,ghi,dni,dhi", |hour| {
                format!("2021,6,{},{},{}", hour.day, hour.hour + 1, hour.light(plain))
            }),
        ),
        (
            "hours 0 to 23",
            table("Year,Month,Day,Hour,GHI,DNI,DHI", |hour| {
                format!("2021,6,{},{},{}", hour.day, hour.hour, hour.light(plain))
            }),
        ),
        (
            "24:00",
            table("time,ghi,dni,dhi", |hour| {
                format!("2021-06-{:02} {:02}:00,{}", hour.day, hour.hour + 1, hour.light(plain))
            }),
        ),
        (
            "day first",
            table("time,ghi,dni,dhi", |hour| {
                format!("{} {},{}", day(&local(hour), dmy.clone(), "/"), &local(hour)[11..], hour.light(plain))
            }),
        ),
        (
            "US dates, AM and PM",
            table("Timestamp,GHI,DNI,DHI", |hour| {
                format!("{} {},{}", day(&local(hour), mdy.clone(), "/"), twelve(hour.hour), hour.light(plain))
            }),
        ),
        (
            "date and time, decimal commas",
            table("Datum;Date;Time;GHI;DNI;DIF", |hour| {
                let light = [hour.ghi, hour.dni, hour.dhi].map(|value| plain(value).replace('.', ",")).join(";");
                format!("x;{};{};{light}", day(&local(hour), dmy.clone(), "."), &local(hour)[11..])
            }),
        ),
        (
            "date and hour ending",
            table("date,hour,ghi,dni,dhi", |hour| {
                format!("2021-06-{:02},{},{}", hour.day, hour.hour + 1, hour.light(plain))
            }),
        ),
        (
            "date in a named order",
            table("Date (DD/MM/YYYY),Time (HH:MM),GHI,DNI,DHI", |hour| {
                format!("{},{},{}", day(&local(hour), dmy.clone(), "/"), &local(hour)[11..], hour.light(plain))
            }),
        ),
        ("Unix seconds", table("time,ghi,dni,dhi", |hour| format!("{},{}", hour.unix(0), hour.light(plain)))),
        (
            "Unix milliseconds",
            table("timestamp,ghi,dni,dhi", |hour| format!("{},{}", hour.unix(0) * 1000, hour.light(plain))),
        ),
        (
            "named months",
            table("date,ghi,dni,dhi", |hour| {
                format!("{:02}-Jun-2021 {:02}:00,{}", hour.day, hour.hour, hour.light(plain))
            }),
        ),
        (
            "blanks",
            table("date   time   ghi dni  dhi", |hour| {
                format!("{}   {}", local(hour).replace('T', "  "), hour.light(plain).replace(',', "  "))
            }),
        ),
        (
            "tabs, units in words",
            table("Date/Time\tGHI in W/m2\tDNI in W/m2\tDHI in W/m2", |hour| {
                format!("{}\t{}", local(hour), hour.light(plain).replace(',', "\t"))
            }),
        ),
        (
            "a zone in the name",
            table("time (UTC+2),ghi,dni,dhi", |hour| format!("{},{}", hour.iso(2, 0), hour.light(plain))),
        ),
        (
            "YYYYMMDDHH",
            table("time,ghi,dni,dhi", |hour| format!("{},{}", compact(&local(hour), false), hour.light(plain))),
        ),
        (
            "lines above the names",
            table("My station\nLatitude: 40\nLongitude: -105\n# Time zone; UTC-7\ntime,ghi,dni,dhi", |hour| {
                format!("{},{}", local(hour), hour.light(plain))
            }),
        ),
    ];
    let mut all: Vec<Layout> = texts.into_iter().map(|(name, text)| (name, text.into_bytes(), AT_PLACE)).collect();
    let one_day =
        table("time,ghi,dni,dhi", |hour| format!("0{}/06/2021 {:02}:00,{}", hour.day, hour.hour, hour.light(plain)));
    all.push((
        "day first by option",
        one_day.into_bytes(),
        WeatherOptions { date_order: Some(DateOrder::Dmy), ..AT_PLACE },
    ));
    all
}

pub fn services() -> Vec<Layout> {
    let blank = WeatherOptions { zone: Some(ClockZone::Hours(-7.0)), ..SILENT };
    let end = WeatherOptions { stamped_at: Some(StampedAt::End), ..AT_PLACE };
    let meteonorm = table("Meteonorm 8\ny,m,dm,h,G_Gh,G_Bn,G_Dh", |hour| {
        format!("2021,6,{},{},{}", hour.day, hour.hour + 1, hour.light(plain))
    });
    let texts = [
        ("NSRDB", nsrdb("-7", -7, true), SILENT),
        ("NSRDB in UTC", nsrdb("0", 0, true), SILENT),
        ("NSRDB with a blank zone", nsrdb("", -7, true), blank),
        ("SAM without minutes", nsrdb("-7", -7, false), SILENT),
        ("Open-Meteo CSV", open_meteo_csv(), SILENT),
        ("Open-Meteo JSON", open_meteo_json(|hour| json!(hour.iso(0, 60)), "iso8601"), SILENT),
        ("Open-Meteo JSON, Unix seconds", open_meteo_json(|hour| json!(hour.unix(60)), "unixtime"), SILENT),
        ("PVGIS CSV", pvgis_csv(), SILENT),
        ("PVGIS JSON", pvgis_json(), SILENT),
        ("NASA POWER CSV, UTC", nasa_csv("UTC", 0), SILENT),
        ("NASA POWER CSV, LST", nasa_csv("LST", -7), SILENT),
        ("NASA POWER JSON", nasa_json("Wh/m^2", 1.0), SILENT),
        ("NASA POWER JSON, MJ/hr", nasa_json("MJ/hr", 0.0036), SILENT),
        ("Solargis", solargis(), SILENT),
        ("Solargis, typical year", solargis_typical(), SILENT),
        ("PVsyst", pvsyst(), SILENT),
        ("CAMS", cams("Universal time (UT)"), SILENT),
        ("SolarAnywhere, end", solar_anywhere(" / Averaging Method: End of Period", 60), SILENT),
        ("SolarAnywhere, middle", solar_anywhere(" / Averaging Method: Center of Period", 30), SILENT),
        ("Meteonorm, as the user says", meteonorm, end),
        ("WEA", wea(), SILENT),
        ("TMY3", tmy3(), SILENT),
        ("EPW", epw(), SILENT),
        ("TOA5", toa5(), AT_PLACE),
        ("JSON of records", records_json(), AT_PLACE),
        ("JSON of columns", columns_json(), AT_PLACE),
        ("JSON a line each", lines_json(), AT_PLACE),
        ("JSON, split", split_json(), AT_PLACE),
    ];
    texts.into_iter().map(|(name, text, options)| (name, text.into_bytes(), options)).collect()
}
