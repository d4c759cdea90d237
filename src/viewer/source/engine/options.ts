// Made by tools/faces from the requests. Do not edit.

/** Facts about a weather file that it does not state. */
export interface WeatherOptions {
  /** Latitude of the weather, degrees, north positive, in place of that of the file [default if the file states none: that of the scene] */
  latitude?: string;
  /** Longitude of the weather, degrees, east positive, in place of that of the file. */
  longitude?: string;
  /** Time zone of the weather file's clock, in place of that of the file: hours ahead of UTC, such as +01:00, -7 or UTC, or a name, such as Europe/Amsterdam, with its summer time. If its time stamps state an offset, the zone of days and labels in results. */
  time_zone?: string;
  /** Shift of the weather file's time stamps, such as 41min, -30min or 0.5h; `auto` chooses the shift under which GHI, DNI and DHI agree best, if they agree clearly better. */
  shift?: string;
  /** Position of the weather file's time stamps in their intervals; middle for values at one moment [default: as the format, the names of columns or hours 1 to 24 imply; start for plain CSV] */
  weather_stamp?: "start" | "middle" | "end";
  /** Order of day and month in the weather file's dates of three numbers, such as 01/06/2021 [default: what the whole column shows] */
  date_order?: "dmy" | "mdy" | "ymd";
}
