"""The picture of the hours of a day. In: surface -> part of the light -> (ours, EnergyPlus's) of 24 hours, W/m2. Out: an SVG: a
row a surface, direct light on the left, reflected light by kind on the right; lines are ours, dots EnergyPlus's own."""

import math
from html import escape

WIDTH, HEIGHT, LEFT, TOP, GAP, FOOT = 330, 130, 54, 40, 44, 60
STYLE = "<style>text{font:11px sans-serif;fill:#222}.s{font-size:10px;fill:#555}.b{font-weight:bold}</style>"
COLUMNS = {
    "direct": ("sun_direct", "sky_direct"),
    "reflected": (
        "sun_reflected_obstruction",
        "sun_reflected_ground",
        "sky_reflected_obstruction",
        "sky_reflected_ground",
        "sun_mirrored",
    ),
}
COLOURS = {
    "sun_direct": "#c9820a",
    "sky_direct": "#2a6fb0",
    "sun_reflected_obstruction": "#b3541e",
    "sun_reflected_ground": "#0b6e4f",
    "sky_reflected_obstruction": "#8d6cab",
    "sky_reflected_ground": "#5b8c9e",
    "sun_mirrored": "#c2185b",
}


def draw(surfaces, path):
    """Writes the picture."""
    width, height = LEFT + 2 * (WIDTH + GAP), TOP + len(surfaces) * (HEIGHT + GAP) + FOOT
    out = [f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{height}">', STYLE]
    out.append(f'<rect width="{width}" height="{height}" fill="#fff"/>')
    for row, (surface, lights) in enumerate(surfaces.items()):
        for column, names in enumerate(COLUMNS.values()):
            top = nice(max(max(max(pair) for pair in zip(*lights[name])) for name in names))
            x0, y0 = LEFT + column * (WIDTH + GAP), TOP + row * (HEIGHT + GAP)
            out += frame(x0, y0, top)
            out += [f'<text x="{x0}" y="{y0 - 6}" class="b">{escape(surface)}</text>'] if column == 0 else []
            for name in names:
                out += curve(*lights[name], x0, y0, top, COLOURS[name])
    out += legend(TOP + len(surfaces) * (HEIGHT + GAP))
    path.write_text("\n".join([*out, "</svg>"]) + "\n")


def curve(ours, own, x0, y0, top, colour):
    """A line of ours and dots of EnergyPlus's; hours without light have no dot."""
    at = lambda hour, value: (x0 + (hour + 0.5) / 24 * WIDTH, y0 + HEIGHT * (1 - value / top))
    line = " ".join("{:.1f},{:.1f}".format(*at(hour, value)) for hour, value in enumerate(ours))
    yield f'<polyline points="{line}" fill="none" stroke="{colour}" stroke-width="1.4"/>'
    for hour, value in enumerate(own):
        if value > 0.0:
            x, y = at(hour, value)
            yield f'<circle cx="{x:.1f}" cy="{y:.1f}" r="2.6" fill="none" stroke="{colour}"/>'


def frame(x0, y0, top):
    """Frame, hours and W/m2 of a panel."""
    yield f'<rect x="{x0}" y="{y0}" width="{WIDTH}" height="{HEIGHT}" fill="none" stroke="#888"/>'
    for hour in range(0, 25, 6):
        x = x0 + hour / 24 * WIDTH
        yield f'<text x="{x:.1f}" y="{y0 + HEIGHT + 13}" text-anchor="middle" class="s">{hour}</text>'
    for share in (0.0, 0.5, 1.0):
        y = y0 + HEIGHT * (1 - share)
        yield f'<line x1="{x0}" x2="{x0 + WIDTH}" y1="{y:.1f}" y2="{y:.1f}" stroke="#ddd"/>'
        yield f'<text x="{x0 - 4}" y="{y + 3:.1f}" text-anchor="end" class="s">{share * top:g}</text>'


def legend(y0):
    """Names of the lines, under their column."""
    for column, names in enumerate(COLUMNS.values()):
        for k, name in enumerate(names):
            x, y = LEFT + column * (WIDTH + GAP) + 150 * (k % 2), y0 + 14 * (k // 2)
            yield f'<line x1="{x}" x2="{x + 16}" y1="{y - 4}" y2="{y - 4}" stroke="{COLOURS[name]}" stroke-width="2"/>'
            yield f'<text x="{x + 20}" y="{y}">{name}</text>'
    yield f'<text x="{LEFT}" y="{y0 + 28}" class="s">W/m2 by hour of standard time; lines: heliotile, circles: EnergyPlus</text>'


def nice(value):
    """The next of 1, 2, 4, 5 and 10 times a power of ten."""
    power = 10.0 ** math.floor(math.log10(max(value, 1e-3)))
    return next(m * power for m in (1, 2, 4, 5, 10) if value <= m * power * (1 + 1e-9))
