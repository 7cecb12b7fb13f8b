"""Writes the corpora of the files of the program from a short run and a map: python3 fuzz/own_files.py SWIM

SWIM is the program `swim`. To be run when a format has changed; tests fail until then.
"""

import json
import pathlib
import subprocess
import sys
import tempfile

SCENE = """
bodies = [
    { name = "a", radius = 1, position = [0, 0, 0] },
    { name = "b", radius = 1, position = [6, 0, 0] },
]
links = [{ name = "arm", body = "b", to = "a" }]
gait.phases = [{ link = "arm", length = 4 }, { link = "arm", length = 6 }]
model.kind = "rpy"
"""

with tempfile.TemporaryDirectory() as folder:
    scene = pathlib.Path(folder, "scene.toml")
    scene.write_text(SCENE)
    for command in ["run", "map"]:
        subprocess.run(
            [sys.argv[1], command, scene, "--quiet", "--out", f"{folder}/out"],
            check=True,
            stdout=subprocess.DEVNULL,
        )
    read = lambda name: pathlib.Path(folder, "out", name).read_text()
    checkpoint, slices, stroke_table = map(read, ["checkpoint.json", "flow_slices.json", "table.json"])
corpora = pathlib.Path(__file__).parent / "corpus"


def changed(whole, change):
    """A file after a change of its values, without line breaks as it is written."""
    value = json.loads(whole)
    change(value)
    return json.dumps(value, separators=(",", ":"))


def flipped(whole, place):
    """A file with the lowest bit of one byte flipped; `place` is a share of its length."""
    data = bytearray(whole, "ascii")
    data[int(place * len(data))] ^= 1
    return data.decode("ascii")


def write(target, whole, changes):
    """The whole file, the files after changes of its values, and damaged ones."""
    files = {"whole": whole, "cut": whole[: len(whole) // 2], "deep": "[" * 2000, "number": "1e999"}
    files |= {name: changed(whole, change) for name, change in changes.items()}
    for number, place in enumerate([0.03, 0.2, 0.4, 0.6, 0.8, 0.95]):
        files[f"flipped-bit-{number}"] = flipped(whole, place)
    (corpora / target).mkdir(exist_ok=True)
    for name, text in files.items():
        (corpora / target / f"{name}.json").write_text(text)


def put(*path):
    """A change of one value: the keys that lead to it, and the value."""

    def change(value):
        *keys, last, new = path
        for key in keys:
            value = value[key]
        value[last] = new

    return change


NAN = float("nan")
write(
    "checkpoint",
    checkpoint,
    {
        "another-version": lambda value: value.update(version=value["version"] - 1),
        "changed-number": put("outcome", "displacement", 0, 0, 0.5),
        "control-characters": put("scene", "\u001b[31m\u0000"),
        "counts": put("outcome", "solves", 2**64 - 1),
        "huge-number": put("frames", 0, "translation", [1e308, -1e308, 1e308]),
        "nan": put("frames", 0, "translation", [NAN, 0.0, 0.0]),
        "no-bodies": put("outcome", "displacement", []),
        "rotation-of-zero": put("frames", 0, "rotation", [0, 0, 0, 0]),
    },
)
# One slice is enough, with its 50 kB; the fuzz target makes its checksum.
write(
    "flow_slices",
    changed(slices, lambda value: value.update(slices=value["slices"][:1])),
    {
        "columns": put("slices", 0, "columns", 10**9),
        "counts": put("slices", 0, "rows", 2**63),
        "no-columns": put("slices", 0, "columns", 0),
        "plane-not-finite": put("slices", 0, "plane", "centre", [1e308, NAN, -1e308]),
        "time": put("slices", 0, "time", -1e308),
        "unit": put("slices", 0, "unit", 1e308),
        "velocity": put("slices", 0, "velocity", "!!"),
    },
)
write(
    "table",
    stroke_table,
    {
        "no-ranges": put("ranges", []),
        "scene": put("scene", "bodies = 3"),
        "tolerance": put("tolerance", -1.0),
        "empty": put("table", {}),
    },
)
