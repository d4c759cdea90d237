"""A chart of the hours of a day. In: two series of values by hour, such as measured and found ones. Out: an SVG of some panels, dark ink on white, so
that it is read on any page."""
from pathlib import Path

MEASURED, FOUND = "#222222", "#d55e00"
WIDE, HIGH, LEFT, TOP, GAP = 250, 170, 46, 46, 62


def panel(left, title, ends, step, hours, of_day, measured, found):
    """`ends` and `step` of the upright axis; hours are those up to which values are means, `of_day` the first and the last of the level axis."""
    low, high = ends
    first, last = of_day
    x = lambda hour: left + WIDE * (hour - first) / (last - first)  # noqa: E731
    y = lambda value: TOP + HIGH * (high - value) / (high - low)  # noqa: E731
    lines = [f'<text x="{left}" y="{TOP - 10}" class="b">{title}</text>']
    for value in range(low, high + 1, step):
        lines.append(f'<line x1="{left}" x2="{left + WIDE}" y1="{y(value):.1f}" y2="{y(value):.1f}" stroke="#dddddd"/>')
        lines.append(f'<text x="{left - 5}" y="{y(value) + 3.5:.1f}" text-anchor="end">{value}</text>')
    for hour in range(first, last + 1, 3):
        lines.append(f'<text x="{x(hour):.1f}" y="{TOP + HIGH + 15}" text-anchor="middle">{hour}</text>')
    # Means of an hour stand at its middle.
    at = [hour - 0.5 for hour in hours]
    for values, colour, dash in ((measured, MEASURED, ""), (found, FOUND, ' stroke-dasharray="5 3"')):
        points = " ".join(f"{x(hour):.1f},{y(value):.1f}" for hour, value in zip(at, values))
        lines.append(f'<polyline points="{points}" fill="none" stroke="{colour}" stroke-width="1.6"{dash}/>')
    lines += [f'<circle cx="{x(hour):.1f}" cy="{y(value):.1f}" r="2.6" fill="{MEASURED}"/>' for hour, value in zip(at, measured)]
    lines.append(f'<rect x="{left}" y="{TOP}" width="{WIDE}" height="{HIGH}" fill="none" stroke="#888888"/>')
    return lines


def draw(path, hours, panels, caption, names=("measured", "found"), of_day=(6, 18)):
    """`panels`: title, ends of the upright axis, its step, values of both series."""
    width, height = LEFT + len(panels) * (WIDE + GAP) - GAP + 16, TOP + HIGH + 40
    lines = [f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{height}" viewBox="0 0 {width} {height}">',
             "<style>text{font:11px sans-serif;fill:#333333}.b{font-weight:bold}</style>", f'<rect width="{width}" height="{height}" fill="#ffffff"/>',
             f'<line x1="{LEFT}" x2="{LEFT + 26}" y1="14" y2="14" stroke="{MEASURED}" stroke-width="1.6"/><circle cx="{LEFT + 13}" cy="14" r="2.6" fill="{MEASURED}"/>',
             f'<text x="{LEFT + 32}" y="18">{names[0]}</text>',
             f'<line x1="{LEFT + 104}" x2="{LEFT + 130}" y1="14" y2="14" stroke="{FOUND}" stroke-width="1.6" stroke-dasharray="5 3"/>',
             f'<text x="{LEFT + 136}" y="18">{names[1]}</text>']
    for number, (title, ends, step, measured, found) in enumerate(panels):
        lines += panel(LEFT + number * (WIDE + GAP), title, ends, step, hours, of_day, measured, found)
    lines.append(f'<text x="{LEFT}" y="{height - 6}">{caption}</text></svg>')
    Path(path).write_text("\n".join(lines) + "\n")
