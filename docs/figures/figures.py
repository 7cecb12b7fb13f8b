"""What the scripts of this folder share: runs of the command `swim`, tables and charts.

The command is target/release/swim, or the program that the environment variable SWIM names.
"""

import argparse
import datetime
import html
import json
import math
import os
import pathlib
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[2]
# Palette of Okabe & Ito (2008), whose colours colour-blind readers can distinguish.
COLOURS = ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#785ef0", "#282828"]


class Refused(Exception):
    """The command ended with an error message."""


def arguments(description, **more):
    """Options of a script: --quick, --out, and more ones with a default value and a help text."""
    parser = argparse.ArgumentParser(description=description)
    parser.add_argument("--quick", action="store_true", help="a small part of the study")
    text = "folder to write to: docs, or one with the name of the script for --quick"
    parser.add_argument("--out", type=pathlib.Path, help=text)
    for name, (default, text) in more.items():
        parser.add_argument(f"--{name}", type=type(default), default=default, help=text)
    chosen = parser.parse_args()
    script = pathlib.Path(pathlib.Path(sys.argv[0]).stem)
    chosen.out = chosen.out or (script if chosen.quick else ROOT / "docs")
    chosen.out.mkdir(parents=True, exist_ok=True)
    return chosen


def program():
    """The command `swim`."""
    return os.environ.get("SWIM", str(ROOT / "target" / "release" / "swim"))


def swim_text(command, scene, *options, overrides=(), threads=None, seconds=None):
    """What `swim` prints; `scene` is a path or the text of a scene file. Refused after `seconds`."""
    environment = os.environ | ({"RAYON_NUM_THREADS": str(threads)} if threads else {})
    with tempfile.TemporaryDirectory() as folder:
        if not isinstance(scene, pathlib.Path):
            text, scene = scene, pathlib.Path(folder) / "scene.toml"
            scene.write_text(text)
        sets = [word for override in overrides for word in ("--set", override)]
        words = [program(), command, str(scene), "--quiet", *sets, *map(str, options)]
        try:
            done = subprocess.run(
                words, capture_output=True, text=True, env=environment, timeout=seconds
            )
        except subprocess.TimeoutExpired:
            raise Refused(f"no result after {seconds} s") from None
    if done.returncode:
        lines = done.stderr.strip().splitlines() or [f"exit code {done.returncode}"]
        errors = [line for line in lines if line.startswith("error: ")]
        raise Refused((errors or lines)[-1].removeprefix("error: "))
    return done.stdout


def swim(command, scene, *options, **more):
    """The JSON that `swim` prints."""
    return json.loads(swim_text(command, scene, "--json", *options, **more))


def machine():
    """Number and model of the processors."""
    lines = pathlib.Path("/proc/cpuinfo").read_text().splitlines()
    model = next((line.split(":")[1].strip() for line in lines if "model name" in line), "unknown")
    return f"{os.cpu_count()} threads of {model}"


def page(title, script, *parts):
    """A Markdown page with the day, the machine and the script that made it."""
    made = f"{datetime.date.today()}, {machine()}. Made by `python docs/figures/{script}`."
    return "\n\n".join([f"# {title}", made, *parts]) + "\n"


def table(headings, rows):
    """A Markdown table."""
    lines = [headings, ["---"] * len(headings), *rows]
    return "\n".join("| " + " | ".join(map(str, line)) + " |" for line in lines)


def ticks(low, high, is_log):
    """Places of the labels of an axis."""
    if is_log:
        return [10.0**k for k in range(math.floor(low), math.ceil(high) + 1)]
    step = 10.0 ** math.floor(math.log10(high - low))
    step = next(s for s in (0.2 * step, 0.5 * step, step, 2 * step) if (high - low) / s <= 8)
    first = math.ceil(low / step)
    return [k * step for k in range(first, math.floor(high / step + 1e-9) + 1)]


def chart(path, x, y, series, is_log=False, legend=0):
    """Writes an SVG chart of series (name, points, style): line, points or both.

    Names are inside the chart, or beside it in a column of the width `legend`.
    """
    width, height, left, top, right, bottom = 760 + legend, 460, 76, 16, 16 + legend, 46
    height = max(height, 18 * len(series) + 60) if legend else height
    names = width - legend if legend else left + 18
    place = math.log10 if is_log else float
    points = [p for _, points, _ in series for p in points]
    axes = []
    for values in zip(*points):
        low, high = min(map(place, values)), max(map(place, values))
        if is_log:
            axes.append((math.floor(low), math.ceil(high)))
        else:
            axes.append((min(low, 0.0) if low < 0.5 * high else low, high + 0.15 * (high - low)))
    (x0, x1), (y0, y1) = axes
    at_x = lambda v: left + (place(v) - x0) / (x1 - x0) * (width - left - right)
    at_y = lambda v: height - bottom - (place(v) - y0) / (y1 - y0) * (height - top - bottom)
    text = lambda a, b, anchor, s, more="": (
        f'<text x="{a:.1f}" y="{b:.1f}" text-anchor="{anchor}"{more}>{html.escape(s)}</text>'
    )
    svg = [
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{height}" '
        f'viewBox="0 0 {width} {height}" font-family="sans-serif" font-size="14" fill="#282828">',
        '<rect width="100%" height="100%" fill="#fff"/>',
    ]
    for value in ticks(x0, x1, is_log):
        svg.append(text(at_x(value), height - bottom + 18, "middle", f"{value:g}"))
    for value in ticks(y0, y1, is_log):
        level = at_y(value)
        svg.append(f'<path d="M{left} {level:.1f}H{width - right}" stroke="#ddd"/>')
        svg.append(text(left - 6, level + 5, "end", f"{value:.4g}"))
    frame = f"M{left} {top}V{height - bottom}H{width - right}"
    svg.append(f'<path d="{frame}" fill="none" stroke="#282828"/>')
    svg.append(text((left + width - right) / 2, height - 8, "middle", x))
    middle = height / 2
    svg.append(text(16, middle, "middle", y, f' transform="rotate(-90 16 {middle})"'))
    for number, (name, points, style) in enumerate(series):
        colour = COLOURS[number % len(COLOURS)]
        places = [(at_x(a), at_y(b)) for a, b in points]
        if style != "points" and places:
            line = "M" + "L".join(f"{a:.1f} {b:.1f}" for a, b in places)
            svg.append(f'<path d="{line}" fill="none" stroke="{colour}" stroke-width="2"/>')
        if style != "line":
            svg += [f'<circle cx="{a:.1f}" cy="{b:.1f}" r="4" fill="{colour}"/>' for a, b in places]
        level = top + 16 + 18 * number
        svg.append(f'<circle cx="{names}" cy="{level}" r="5" fill="{colour}"/>')
        svg.append(text(names + 12, level + 5, "start", name))
    path.write_text("\n".join(svg) + "\n</svg>\n")
