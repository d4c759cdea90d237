"""Parquet as DuckDB reads it, beside the CSV of the same replay, both read by DuckDB itself. In: files. Out: a line for each check."""
import duckdb

COMPONENTS = ["sun_direct", "sky_direct", "sun_reflected", "sky_reflected", "sun_mirrored", "sky_mirrored", "total"]


def check_duckdb(check, replay, archive, files, folder, share, hourly):
    """`files` are the map and the table of receivers; a day of hours is written into the folder."""
    ask = duckdb.connect()
    read = lambda path: f"read_parquet('{path}')" if path.suffix == ".parquet" else f"read_csv('{path}')"
    off = ", ".join(f"max(abs(a.{name}_kwh_m2 - b.{name}_kwh_m2) / greatest(abs(b.{name}_kwh_m2), 1))" for name in COMPONENTS)
    ours, theirs = read(files["receivers", "parquet"]), read(files["receivers", "csv"])
    rows, *worst = ask.execute(f"select count(*), {off} from {ours} a join {theirs} b using (receiver)").fetchone()
    (count,) = ask.execute(f"select count(*) from {theirs}").fetchone()
    check("receivers.parquet: sums in DuckDB", rows == count and max(worst) < share, f"{max(worst):.1e}, {rows} of {count} rows")
    kind, = {column[0]: str(column[1]) for column in ask.execute(f"describe select geometry from {ours}").fetchall()}.values()
    check("receivers.parquet: geometry in DuckDB", kind.startswith("GEOMETRY") and "28992" in kind, kind[:12])
    day = ["--from", "06-21", "--to", "06-21", "--year", "2019", "--by", "surface"]
    tables = [folder / f"duck.{ending}" for ending in ("parquet", "csv")]
    for path in tables:
        replay(archive, path, *day)
    ours, theirs = map(read, tables)
    off = ", ".join(f"max(abs(a.{name} - b.{name}))" for name in COMPONENTS)
    rows, *worst = ask.execute(f"select count(*), {off} from {ours} a join {theirs} b on a.time = b.time::timestamptz and a.surface = b.surface").fetchone()
    (count,) = ask.execute(f"select count(*) from {theirs}").fetchone()
    check("a day of hours in DuckDB, by instant", rows == count and max(worst) < hourly, f"{max(worst):.1e} W/m2, {rows} of {count} rows")
