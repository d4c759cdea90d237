//! Hourly output of EnergyPlus. In: the text of `eplusout.eso`. Out: a series for each variable and
//! key, without design days.
//!
//! A dictionary of `number,values,key,variable [unit] !Hourly` is followed by lines `number,value`;
//! `1,...` begins an environment, `2,...` an hour, whose last word is the kind of day (Output
//! Details and Examples, chapter "eplusout.eso").

use std::collections::{BTreeMap, HashMap};
use std::path::Path;

use heliotile_core::error::{Error, Result};

/// Hourly values by variable and key, and the month of each hour.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct HourlySeries {
    /// Values by variable and key.
    pub values: BTreeMap<(String, String), Vec<f64>>,
    /// Month of each hour, from 1; 0 where it is not known.
    pub months: Vec<u8>,
}

/// Smallest number of a variable; smaller numbers are headings: environments, hours, days.
const FIRST_VARIABLE: u32 = 7;

/// Reads the series of the variables in `wanted`.
pub fn read_eso(file: &Path, bytes: &[u8], wanted: &[&str]) -> Result<HourlySeries> {
    let text = String::from_utf8_lossy(bytes);
    let mut lines = text.lines();
    let mut names: HashMap<u32, (String, String)> = HashMap::new();
    for line in lines.by_ref().take_while(|line| !line.starts_with("End of Data Dictionary")) {
        let mut parts = line.splitn(4, ',').map(str::trim);
        let number = parts.next().and_then(|number| number.parse::<u32>().ok());
        let (Some(number), Some(_), Some(key), Some(about)) = (number, parts.next(), parts.next(), parts.next()) else {
            continue;
        };
        let variable = about.split(" [").next().unwrap_or_default();
        if number >= FIRST_VARIABLE && wanted.contains(&variable) && about.contains("!Hourly") {
            names.insert(number, (variable.to_owned(), key.to_owned()));
        }
    }
    let (mut found, mut counts) = (HourlySeries::default(), true);
    for line in lines {
        let (number, rest) = line.split_once(',').unwrap_or((line, ""));
        let Ok(number) = number.trim().parse::<u32>() else { continue };
        match number {
            // Values count from the first hour on: only its kind of day tells a run from a design
            // day.
            1 => counts = false,
            2 => {
                counts = !rest.trim_end().ends_with("DesignDay");
                let month = rest.split(',').nth(1).and_then(|month| month.trim().parse::<u8>().ok());
                found.months.extend(counts.then(|| month.unwrap_or_default()));
            }
            _ if !counts => {}
            _ => {
                let Some(name) = names.get(&number) else { continue };
                let value: f64 = rest.trim().parse().map_err(|_| {
                    let what = format!("`{}` is not a number for {} of {}", rest.trim(), name.0, name.1);
                    Error::input(file, None, what, "run it again: the file was cut off")
                })?;
                found.values.entry(name.clone()).or_default().push(value);
            }
        }
    }
    Ok(found)
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "Program Version,EnergyPlus\n1,5,Environment Title[],Latitude[deg]\n2,8,Day of Simulation[],Month[]\n\
        7,1,WALL,Surface X [W/m2] !Hourly\n9,1,WALL,Other [W] !Hourly\nEnd of Data Dictionary\n1,SUMMER,1,2\n\
        2,1, 7,21, 0, 1, 0.00,60.00,SummerDesignDay\n7,5\n1,RUN,1,2\n2,1, 1, 1, 0, 1, 0.00,60.00,Monday\n7,1.5\n9,2\n\
        2,1, 1, 1, 0, 2, 0.00,60.00,Monday\n7,2.5E1\nEnd of Data\n";

    /// With two environments and two variables, the design day and the other variable are left out:
    /// 2 hours of January remain, 1.5 and 25. A value that is cut off is an error.
    #[test]
    fn only_hours_of_the_run_period_are_read() {
        let series = read_eso(Path::new("a.eso"), TEXT.as_bytes(), &["Surface X"]).expect("read");
        let expected = [(("Surface X".to_owned(), "WALL".to_owned()), vec![1.5, 25.0])];
        assert_eq!((series.values, series.months), (BTreeMap::from(expected), vec![1, 1]));
        let error = read_eso(Path::new("a.eso"), TEXT.replace("2.5E1", "2.5x").as_bytes(), &["Surface X"]);
        assert!(error.expect_err("cut").to_string().contains("`2.5x`"));
    }
}
