// Archives of people that tests share: four points of a street, and a grid on its ground that fills several tiles.
import { execFileSync } from "node:child_process";
import { existsSync, mkdirSync, statSync } from "node:fs";

const RASTERS = "tests/data/rasters/street_";
const SCENE = ["dsm", "dem", "canopy", "landcover"].flatMap((name) => [`--${name}`, `${RASTERS}${name}.tif`]);
export const YEAR = "tests/data/weather/golden_tmy3.epw";

/** The path of the archive: of four people, or of people so far apart on the ground. */
export function people(folder, spacing = null) {
  const place = `${folder}/${spacing ? "grid" : "four"}.people`;
  const archive = `${place}/site.helio`;
  if (existsSync(archive) && statSync(archive).mtimeMs > statSync(process.env.HELIOTILE).mtimeMs) return archive;
  mkdirSync(folder, { recursive: true });
  const where = spacing ? ["--spacing", spacing] : ["--points", "tests/data/comfort/street_points.csv"];
  const asked = ["--quality", "draft", "--replace", "--folder", place, "--weather", YEAR, "--every", "total", "-o", `${place}.csv`, "--quiet"];
  execFileSync(process.env.HELIOTILE, ["comfort", ...SCENE, ...where, ...asked], { stdio: ["ignore", "ignore", "pipe"] });
  return archive;
}
