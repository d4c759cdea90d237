"""The picture. In: rows of the table. Out: an SVG, a panel a scene: error of the hourly total against CPU seconds a receiver,
both on logarithmic axes."""
import math
from html import escape

PANEL, HEIGHT, LEFT, TOP, BOTTOM, GAP = 300, 300, 60, 34, 64, 26
COLOURS = {"heliotile": "#0b6e4f", "Radiance": "#b3541e"}
STYLE = "<style>text{font:11px sans-serif;fill:#222}.s{font-size:10px;fill:#555}.b{font-weight:bold}</style>"


def draw(rows, path):
    """Writes the picture of all scenes in `rows`."""
    scenes = list(dict.fromkeys(r.scene for r in rows))
    xs = span([r.cpu_total_s for r in rows])
    ys = span([r.hourly_rmse_pct for r in rows])
    width = LEFT + len(scenes) * (PANEL + GAP)
    out = [f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{TOP + HEIGHT + BOTTOM}">', STYLE,
           f'<rect width="{width}" height="{TOP + HEIGHT + BOTTOM}" fill="#fff"/>']
    for k, scene in enumerate(scenes):
        x0 = LEFT + k * (PANEL + GAP)
        out += axes(scene, x0, xs, ys, k == 0)
        for family, colour in COLOURS.items():
            points = sorted((across(r.cpu_total_s, xs, x0), up(r.hourly_rmse_pct, ys), r.method.split(" ", 1)[1])
                            for r in rows if r.scene == scene and r.method.startswith(family))
            if family == "heliotile":
                line = " ".join(f"{x:.1f},{y:.1f}" for x, y, _ in points)
                out.append(f'<polyline points="{line}" fill="none" stroke="{colour}" stroke-opacity="0.5"/>')
            for x, y, name in points:
                shift, anchor = (-7, "end") if x > x0 + PANEL * 0.6 else (7, "start")
                out.append(f'<circle cx="{x:.1f}" cy="{y:.1f}" r="4" fill="{colour}"/>')
                out.append(f'<text x="{x + shift:.1f}" y="{y - 5:.1f}" text-anchor="{anchor}" class="s">{escape(name)}</text>')
    for k, (family, colour) in enumerate(COLOURS.items()):
        x, y = LEFT + 8 + k * 90, TOP + HEIGHT + 52
        out.append(f'<circle cx="{x}" cy="{y - 4}" r="4" fill="{colour}"/><text x="{x + 8}" y="{y}">{family}</text>')
    path.write_text("\n".join([*out, "</svg>"]) + "\n")


def span(values):
    """(low, high) powers of ten of an axis, with a little room."""
    return math.log10(min(values)) - 0.15, math.log10(max(values)) + 0.15


def across(value, span_x, x0):
    return x0 + (math.log10(value) - span_x[0]) / (span_x[1] - span_x[0]) * PANEL


def up(value, span_y):
    return TOP + HEIGHT - (math.log10(value) - span_y[0]) / (span_y[1] - span_y[0]) * HEIGHT


def ticks(low, high):
    """1, 2 and 5 times powers of ten between the ends of an axis."""
    found = [m * 10.0**e for e in range(math.floor(low), math.ceil(high) + 1) for m in (1, 2, 5)]
    return [v for v in found if low <= math.log10(v) <= high]


def axes(scene, x0, xs, ys, first):
    """Frame, grid lines, numbers and titles of a panel."""
    floor = TOP + HEIGHT
    out = [f'<rect x="{x0}" y="{TOP}" width="{PANEL}" height="{HEIGHT}" fill="none" stroke="#888"/>',
           f'<text x="{x0 + PANEL / 2}" y="{TOP - 10}" text-anchor="middle" class="b">{escape(scene)}</text>',
           f'<text x="{x0 + PANEL / 2}" y="{floor + 32}" text-anchor="middle">'
           "CPU seconds a receiver, trace and a year of hours</text>"]
    for v in ticks(*xs):
        x = across(v, xs, x0)
        out.append(f'<path d="M{x:.1f} {TOP}V{floor}" stroke="#eee"/>')
        out.append(f'<text x="{x:.1f}" y="{floor + 14}" text-anchor="middle" class="s">{v:g}</text>')
    for v in ticks(*ys):
        y = up(v, ys)
        out.append(f'<path d="M{x0} {y:.1f}h{PANEL}" stroke="#eee"/>')
        if first:
            out.append(f'<text x="{x0 - 6}" y="{y + 4:.1f}" text-anchor="end" class="s">{v:g}</text>')
    if first:
        middle = TOP + HEIGHT / 2
        out.append(f'<text transform="translate(16 {middle}) rotate(-90)" text-anchor="middle">'
                   "hourly total, RMSE in % of the mean</text>")
    return out
